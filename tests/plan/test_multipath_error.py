"""The error of held multipath phases, by hand over a flat sea."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.plan.multipath_error import RAMP, multipath_error_db
from tests.scenes import point, scene

FLAT = {"multipath": True, "earth": "flat"}
RADAR = {"rpm": 24, "azimuths": 720, "height_m": 15, "range_max_m": 3000}


def moving(distance: float, speed_kn: float, environment: dict[str, Any] = FLAT) -> rs.Scene:
    target = point("t", 0, distance, 10.0, speed_kn=speed_kn, course_deg=180)
    return scene([target], radar=RADAR, environment=environment)


def by_hand(distance: float, speed: float, count: int) -> float:
    """RAMP x |Gamma| R / (R1 + R2) x k x the change of R1 + R2 - R in half a block; sea water of 55.3 - j38.2 at 9.41 GHz."""
    moved = speed * (count - 1) / 2 * 2.5 / 720
    excess = [np.hypot(d, 25.0) - np.hypot(d, 5.0) for d in (distance, distance + moved)]
    grazing = np.arctan2(25.0, distance)
    refracted = np.sqrt(55.3 - 38.2j - np.cos(grazing) ** 2)
    gamma = abs((np.sin(grazing) - refracted) / (np.sin(grazing) + refracted))
    ratio = gamma * np.hypot(distance, 5.0) / np.hypot(distance, 25.0)
    return float(20 * np.log10(RAMP * ratio * 2 * np.pi / (299_792_458 / 9.41e9) * abs(excess[1] - excess[0])))


@pytest.mark.parametrize(("distance", "knots", "count"), [(300, 12, 16), (300, 12, 2), (1000, 30, 16), (2500, 5, 8)])
def test_the_error_is_the_phase_of_half_a_block(distance: float, knots: float, count: int) -> None:
    """0.05 dB: three printed digits of the permittivity."""
    assert multipath_error_db(moving(distance, knots), count) == pytest.approx(
        by_hand(distance, knots * 1852 / 3600, count), abs=0.05
    )


def test_the_ramp_is_the_mean_over_all_phases() -> None:
    """F = 1 + exp(j theta): rms of F^2 at a phase within +-dphi less F^2 in the middle, over rms of F^2, per dphi."""
    theta, shift = np.meshgrid(np.linspace(0, 2 * np.pi, 400, endpoint=False), np.linspace(-1e-3, 1e-3, 401))
    square, middle = ((1 + np.exp(1j * angle)) ** 2 for angle in (theta + shift, theta))
    assert np.sqrt(np.mean(np.abs(square - middle) ** 2) / np.mean(np.abs(middle) ** 2)) / 1e-3 == pytest.approx(
        RAMP, abs=5e-3
    )


def test_there_is_no_error_without_blocks_multipath_or_motion() -> None:
    assert multipath_error_db(moving(300, 12), 1) == -math.inf
    assert multipath_error_db(moving(300, 12, {"earth": "flat"}), 16) == -math.inf
    assert multipath_error_db(scene([point("t", 0, 300, 10.0)], radar=RADAR, environment=FLAT), 16) == -math.inf


def test_the_worst_body_counts() -> None:
    bodies = [point(f"t{d}", 0, d, 10.0, speed_kn=12, course_deg=180) for d in (2500, 300)]
    both = scene(bodies, radar=RADAR, environment=FLAT)
    assert multipath_error_db(both, 16) == multipath_error_db(moving(300, 12), 16) > multipath_error_db(moving(2500, 12), 16)
