"""Dents of the chart: a wall loses what theory says, and keeps it where its dents are kept."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.special import j0, j1

from radar_service.scattering.physical_optics.plating import SPREAD
from radar_service.study.chart.dents_panel import DENTS, FLAT, KEPT, METHODS, dents_points
from radar_service.study.chart.ships_panel import rolling_ships
from radar_service.world.scene import Scene
from radar_service.world.sway import Sway
from tests.scenes import scene

RADAR: dict[str, Any] = {"azimuths": 720, "beamwidth_deg": 3.0, "range_max_m": 600, "rpm": 24, "pattern": "cosine2"}
BODY = {"name": "ship", "scattering": "optics", "material": "steel", "speed_kn": 3.0, "course_deg": 0.0, "heading_deg": 90.0,
        "position_m": [0.0, 300.0, 0.0]}  # fmt: skip
WALL = BODY | {"shape": "box", "length_m": 14.0, "width_m": 2.0, "height_m": 3.0}


def upright_ship(body: dict[str, Any], **radar: Any) -> Scene:
    """A body alone under way, which does not roll."""
    (rolling,) = rolling_ships(scene([body], radar=RADAR | radar, environment={"earth": "flat"}))
    (only,) = rolling.bodies
    sway = Sway(np.zeros(4), np.full(4, 10.0))
    return rolling.with_world(bodies=(replace(only, motion=replace(only.motion, sway=sway)),))


def test_a_wall_errs_by_its_coherent_loss_without_dents() -> None:
    """At its normal dents of mean w take |J0(k w)|^2, as far as 40 drawn panels tell; kept, they err by nothing, as a box has
    no traces to share."""
    done: list[int] = []
    far = upright_ship(WALL | {"position_m": [0.0, 12_000.0, 0.0]}, range_max_m=13_000, height_m=1.5)  # D^2 / lambda is 6 km
    points = dents_points(far, 2, 1, lambda: done.append(1))
    assert len(points) == len(done) == METHODS
    wavenumber = 2.0 * np.pi / upright_ship(WALL).radar.wavelength
    for depth, kept, flat in zip(DENTS, points[::2], points[1::2], strict=True):
        assert (kept.family, flat.family) == (KEPT, FLAT) and kept.setting == flat.setting == f"{1e3 * depth:g} mm"
        assert kept.error_db == pytest.approx(0.0, abs=0.05)
        phase = wavenumber * depth
        drawn = (
            2.0 * SPREAD / np.sqrt(40.0) * 20.0 / np.log(10.0) * phase * j1(phase) / j0(phase)
        )  # 2 sigma of the mean depth
        assert flat.error_db == pytest.approx(-20.0 * np.log10(j0(phase)), abs=0.1 + drawn)
        assert min(kept.times) > 0.0


def test_a_ship_out_of_range_has_no_points() -> None:
    assert dents_points(upright_ship(WALL | {"position_m": [0.0, 3000.0, 0.0]}), 2, 1, lambda: None) == []
