"""Sway of the oracle by hand; its other laws of motion meet those of the engine (test_ships_under_way)."""

import numpy as np
import pytest

from tests.reference.ship_tracks import stand


def bow(table: dict[str, object], time: float, **tracks: np.ndarray) -> float:
    """The heading [degrees]."""
    rotation = stand(table, time, tracks).rotation
    return float(np.rad2deg(np.arctan2(rotation[0, 1], rotation[1, 1])) % 360.0)


def test_sway_is_that_of_the_scene_file() -> None:
    """Starboard down, bow up, yaw to starboard, heave up; a quarter period after the start."""
    table = {
        "roll_deg": 10.0,
        "roll_period_s": 4.0,
        "heave_m": 0.5,
        "heave_period_s": 4.0,
        "yaw_deg": 3.0,
        "yaw_period_s": 4.0,
    }
    placed = stand(table, 1.0, {})
    assert placed.rotation[2, 0] == pytest.approx(-np.sin(np.deg2rad(10.0)))
    assert placed.position[2] == pytest.approx(0.5) and bow(table, 1.0) == pytest.approx(3.0)
    assert stand({"pitch_deg": 5.0}, 1.75, {}).rotation[2, 1] == pytest.approx(np.sin(np.deg2rad(5.0)))
