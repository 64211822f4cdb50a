"""The radar and the environment of a scene file in SI units."""

import math

import numpy as np
import pytest

from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.scene_file.load import load_scene
from tests.scenes import radar

LIGHT = 299_792_458.0


def test_defaults_and_converted_units() -> None:
    radar = {"pattern": [[0, 0], [1, -3], [2, -40]], "blind_sectors_deg": [[90, 180]], "tilt_deg": -2, "loss_db": 3}
    scene = load_scene({"radar": radar, "environment": {"earth": "flat", "gas_db_per_km": "itu", "wind_from_deg": 90}})
    assert scene.radar.pattern.rows[1] == (pytest.approx(math.radians(1)), pytest.approx(10**-0.3))
    assert scene.radar.blind_sectors == ((pytest.approx(math.pi / 2), pytest.approx(math.pi)),)
    assert scene.radar.loss == pytest.approx(10**0.3)
    assert scene.environment.earth_factor == math.inf
    assert scene.environment.gas_db_per_km == pytest.approx(0.01327, rel=0.1)  # P.676-12 Annex 1; 10 % as Annex 2 claims
    assert scene.environment.wind_from == pytest.approx(math.pi / 2)
    assert scene.radar.sample_rate == 75e6


def test_defaults_of_a_plain_pulse() -> None:
    """A receiver of 1.2 / T, sampled 1.5 times as fast, and no window."""
    made = radar(modulation="none", pulse_s=0.25e-6)
    assert (made.bandwidth, made.sample_rate, made.window) == (pytest.approx(4.8e6), pytest.approx(7.2e6), "none")
    assert made.unambiguous_range == np.inf
    assert radar(prf_hz=1500).unambiguous_range == pytest.approx(LIGHT / 3000)


def test_the_level_of_labels_is_a_power_ratio() -> None:
    assert (radar().label_floor, radar(labels_within_db=20).label_floor) == (1e-3, pytest.approx(0.01))
    assert radar(labels_within_db="none").label_floor == 0.0


def test_patterns_of_both_planes() -> None:
    """The vertical pattern is the horizontal one by default, sinc2 where that is a table, and its own where it is given."""
    assert radar(pattern="cosine").pattern_el == PATTERNS["cosine"]
    assert radar(pattern=[[0, 0], [2, -20]]).pattern_el == PATTERNS["sinc2"]
    assert radar(pattern="taylor", taylor_sidelobe_db=35, taylor_nbar=5).pattern == Taylor(35.0, 5)
    table = radar(pattern_el=[[0, 0], [10, -3]]).pattern_el
    assert isinstance(table, Table) and table.rows[1] == (pytest.approx(np.deg2rad(10)), pytest.approx(10**-0.3))
