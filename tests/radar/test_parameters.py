"""What follows from a radar's parameters, against the textbook's figures."""

import math

import numpy as np
import pytest

from radar_service.radar.parameters import horizon
from tests.scenes import radar, scene

EARTH = 4.0 / 3.0 * 6_371_000.0
LIGHT = 299_792_458.0


def test_range_resolution_and_blind_range() -> None:
    """50 MHz resolve 3 m; a pulse of 1 us is 300 m long, and its echoes from 150 m arrive as it ends (c = 3e8 to 0.1 %)."""
    made = radar(bandwidth_hz=50e6, pulse_s=1e-6)
    assert made.range_resolution == pytest.approx(3.0, rel=1e-3)
    assert made.blind_range == pytest.approx(150.0, rel=1e-3)


def test_the_horizon_is_where_the_curved_sea_blocks_the_path() -> None:
    """4.12 km x (sqrt(15) + sqrt(h)) with h in metres (Skolnik 2001: 4.12 is sqrt(2 ae) in three digits); under the sea as on
    it, and without end on a flat earth."""
    height = np.array([0.0, 10.0, 100.0, -3.0])
    expected = 4120.0 * (np.sqrt(15.0) + np.sqrt(np.maximum(height, 0.0)))
    np.testing.assert_allclose(horizon(height, 15.0, EARTH), expected, rtol=1e-3)
    assert np.isinf(horizon(height, 15.0, np.inf)).all()


def test_a_scene_knows_its_horizon() -> None:
    made = scene(radar={"height_m": 20})
    assert made.horizon(10.0) == horizon(10.0, 20.0, EARTH)
    assert scene(environment={"earth": "flat"}).horizon() == np.inf


def test_the_first_spoke_and_scan_not_before_a_time_are_exact() -> None:
    """At the time of each spoke, and one rounding before and after it; a period of 1/11 s is not a binary number."""
    made = radar(azimuths=120, rpm=60 / 11 / 120 * 60)
    for number in (0, 1, 7, 119, 120, 12345, 10**9 + 7):
        time = made.time_of_spokes(float(number))
        before, after = math.nextafter(time, -math.inf), math.nextafter(time, math.inf)
        assert [made.first_spoke(each) for each in (before, time, after)] == [number, number, number + 1]
        assert [made.first_scan(each) for each in (time, after)] == [-(-number // 120), number // 120 + 1]
