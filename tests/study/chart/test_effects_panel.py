"""Dents and indirect echoes of the chart: a wall that dents change by a known loss, a corner whose indirect echo is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.special import j0, j1

from radar_service.radar.structure_reflection import NEAREST
from radar_service.radar.structure_shadow import structure_reflectors
from radar_service.scattering.physical_optics.plating import SPREAD
from radar_service.study.chart.effects_panel import (
    CELLS,
    COMPARED,
    DENTS,
    DENTS_METHODS,
    EACH,
    FLAT,
    HELD,
    INDIRECT_METHODS,
    KEPT,
    FalseShip,
    dents_points,
    indirect_points,
    with_funnel,
)
from radar_service.study.chart.ships_panel import rolling_ships
from radar_service.world.scene import Scene
from radar_service.world.sway import Sway
from tests.scenes import scene

RADAR: dict[str, Any] = {"azimuths": 720, "beamwidth_deg": 3.0, "range_max_m": 600, "rpm": 24, "pattern": "cosine2"}
BODY = {"name": "ship", "scattering": "optics", "material": "steel", "speed_kn": 3.0, "course_deg": 0.0, "heading_deg": 90.0,
        "position_m": [0.0, 300.0, 0.0]}  # fmt: skip
WALL = BODY | {"shape": "box", "length_m": 14.0, "width_m": 2.0, "height_m": 3.0}
CORNER = BODY | {"shape": "trihedral", "edge_m": 0.4, "heading_deg": 180.0, "position_m": [0.0, 300.0, 12.0]}


def ship(body: dict[str, Any], roll: float = 0.0, **radar: Any) -> Scene:
    """A body alone under way, rolling by an angle [rad] about the heights of the antenna."""
    (rolling,) = rolling_ships(scene([body], radar=RADAR | radar, environment={"earth": "flat"}))
    (only,) = rolling.bodies
    sway = Sway(np.array([roll, 0.0, 0.0, 0.0]), np.full(4, 10.0))
    return rolling.with_world(bodies=(replace(only, motion=replace(only.motion, sway=sway)),))


def test_a_wall_errs_by_its_coherent_loss_without_dents() -> None:
    """At its normal dents of mean w take |J0(k w)|^2, as far as 40 drawn panels tell; kept, they err by nothing, as a box has
    no traces to share."""
    done: list[int] = []
    far = ship(WALL | {"position_m": [0.0, 12_000.0, 0.0]}, range_max_m=13_000, height_m=1.5)  # D^2 / lambda is 6 km
    points = dents_points(far, 2, 1, lambda: done.append(1))
    assert len(points) == len(done) == DENTS_METHODS
    wavenumber = 2.0 * np.pi / ship(WALL).radar.wavelength
    for depth, kept, flat in zip(DENTS, points[::2], points[1::2], strict=True):
        assert (kept.family, flat.family) == (KEPT, FLAT) and kept.setting == flat.setting == f"{1e3 * depth:g} mm"
        assert kept.error_db == pytest.approx(0.0, abs=0.05)
        phase = wavenumber * depth
        drawn = (
            2.0 * SPREAD / np.sqrt(40.0) * 20.0 / np.log(10.0) * phase * j1(phase) / j0(phase)
        )  # 2 sigma of the mean depth
        assert flat.error_db == pytest.approx(-20.0 * np.log10(j0(phase)), abs=0.1 + drawn)
        assert min(kept.times) > 0.0


def test_indirect_echoes_of_a_corner_have_the_power_of_every_aspect() -> None:
    """In the middle of its lobe a corner looks the same a scan later: all methods agree, in the cells of which it fills few."""
    done: list[int] = []
    points = indirect_points(ship(CORNER), 2, lambda: done.append(1))
    assert len(points) == INDIRECT_METHODS and len(done) == 2 * INDIRECT_METHODS
    assert [point.family for point in points] == [HELD] * len(CELLS) + [EACH]
    assert all(point.error_db is not None and abs(point.error_db) < 0.2 for point in points)
    assert {point.setting: point.preset for point in points if point.preset} == {
        "cells of 1 rad": "balanced",
        "all of them": "reference",
    }


def test_the_funnel_stands_abeam_of_the_ship_and_needs_a_pattern_that_allows_it() -> None:
    made = with_funnel(ship(CORNER))
    assert made is not None
    (reflector,) = structure_reflectors(made.radar)
    assert abs(reflector.structure.bearing - np.pi / 2.0) < 1e-6 and NEAREST < np.pi / 2.0
    false = FalseShip(made)
    lit = 720 + 180 + np.arange(-1, COMPARED - 1)
    one, three = (false.powers(false.every_aspect(), lit[:count], 1) for count in (1, 3))
    assert one[0] == three[0] > 0.0
    assert with_funnel(ship(CORNER, pattern="gaussian")) is None
    assert indirect_points(ship(CORNER, pattern="gaussian"), 1, lambda: None) == []


def test_a_ship_out_of_range_has_no_points() -> None:
    far = WALL | {"position_m": [0.0, 3000.0, 0.0]}
    assert dents_points(ship(far), 2, 1, lambda: None) == [] and indirect_points(ship(far), 1, lambda: None) == []
