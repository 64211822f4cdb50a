"""Laws of motion of the oracle against closed forms."""

import numpy as np
import pytest

from tests.reference.ship_tracks import KNOT, stand


def bow(table: dict[str, object], time: float, **tracks: np.ndarray) -> float:
    """The heading [degrees]."""
    rotation = stand(table, time, tracks).rotation
    return float(np.rad2deg(np.arctan2(rotation[0, 1], rotation[1, 1])) % 360.0)


def test_a_loop_comes_back() -> None:
    """A square of 100 m at 10 m/s: 40 s a lap."""
    points = [{"position_m": p, "speed_kn": 10.0 / KNOT} for p in ([0, 100], [100, 100], [100, 0])]
    table = {"position_m": [0.0, 0.0, 2.0], "waypoints": points, "loop": True}
    for time, position, heading in ((5.0, (0, 50, 2), 0.0), (415.0, (50, 100, 2), 90.0), (39.0, (10, 0, 2), 270.0)):
        assert stand(table, time, {}).position == pytest.approx(position, abs=1e-9)
        assert bow(table, time) == pytest.approx(heading)


def test_a_rounded_corner_is_an_arc() -> None:
    """50 m of radius cut 50 m of each leg; half way the ship is 50 (1 - cos 45) m inside of both."""
    points = [{"position_m": p, "speed_kn": 10.0 / KNOT} for p in ([0, 200], [200, 200])]
    table = {"position_m": [0.0, 0.0], "waypoints": points, "turn_radius_m": 50.0}
    half = 15.0 + 2.5 * np.pi / 2.0
    inward = 50.0 * (1.0 - np.sqrt(0.5))
    assert stand(table, half, {}).position[:2] == pytest.approx([inward, 200.0 - inward])
    assert bow(table, half) == pytest.approx(45.0)
    assert stand(table, 1e4, {}).position[:2] == pytest.approx([200.0, 200.0])


def test_manoeuvres_turn_and_end() -> None:
    """90 degrees at 9 degrees a second from 10 s on, the short way; a speed in between does not end it."""
    changes = [{"time_s": 10.0, "course_deg": 270.0, "turn_rate_deg_s": 9.0}, {"time_s": 15.0, "speed_kn": 0.0}]
    table = {"course_deg": 0.0, "speed_kn": 10.0, "manoeuvre": changes, "drift_deg": 5.0}
    assert [bow(table, t) for t in (9.0, 15.0, 20.0, 99.0)] == pytest.approx([355.0, 310.0, 265.0, 265.0])
    assert stand(table, 99.0, {}).position == pytest.approx(stand(table, 15.0, {}).position)


def test_tracks_turn_the_short_way() -> None:
    rows = np.array([[0.0, 0, 0, 1, 350], [10.0, 0, 100, 1, 20], [20.0, 100, 100, 3, 20]])
    assert bow({"track": "t"}, 5.0, t=rows) == pytest.approx(5.0)
    assert stand({"track": "t"}, 15.0, {"t": rows}).position == pytest.approx([50, 100, 2])
    assert bow({"track": "t"}, 15.0, t=rows[:, :4]) == pytest.approx(90.0)


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
