"""The closest approach of two motions against hand arithmetic and sampled positions."""

import math
from typing import Any

import numpy as np
import pytest

from radar_service.echo.closest_approach import closest_approach, nearest_and_top
from tests.scenes import point, scene


@pytest.mark.parametrize(
    ("own", "other", "apart"),
    [
        ({}, {"position_m": [3000, 4000, 0]}, 5000.0),
        ({}, {"position_m": [3000, 4000, 0], "steerable": {}}, 0.0),  # commands may bring it anywhere
        ({"steerable": {}}, {"position_m": [3000, 4000, 0]}, 0.0),
        ({}, {"position_m": [-9000, 2000, 0], "speed_kn": 10, "course_deg": 90}, 2000.0),  # passes abeam
        ({}, {"position_m": [3000, 4000, 0], "speed_kn": 10, "course_deg": 0}, 5000.0),  # goes away
        (
            {"speed_kn": 10, "course_deg": 90},
            {"position_m": [500, 700, 0], "speed_kn": 10, "course_deg": 180},
            0.0,
        ),  # crosses
        ({"speed_kn": 10, "course_deg": 0}, {"position_m": [800, -900, 0], "speed_kn": 20, "course_deg": 0}, 800.0),
        ({}, {"position_m": [100, 0, 0], "waypoints": [{"position_m": [100, 300], "speed_kn": 9}]}, 100.0),
    ],
)
def test_closest_approach_of_two_paths(own: dict[str, Any], other: dict[str, Any], apart: float) -> None:
    """By hand; lines are compared, not times. Rounding of a leg of 1e8 m: 1e-8 m."""
    made = scene([point("t", 0, 0) | other], own_ship=own)
    assert closest_approach(made.own_ship, made.bodies[0].motion) == pytest.approx(apart, abs=1e-5)


def test_no_pair_of_random_courses_ever_comes_nearer_than_the_bound() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        courses = [{"position_m": rng.uniform(-5000, 5000, 2).tolist() + [0.0], "speed_kn": float(rng.uniform(0, 30)),
                 "course_deg": float(rng.uniform(0, 360))} for _ in range(2)]  # fmt: skip
        own = {"position_m": courses[0].pop("position_m")[:2]} | courses[0]  # type: ignore[index]
        made = scene(
            [{"name": "b", "shape": "box", "length_m": 80, "width_m": 30, "height_m": 9} | courses[1]], own_ship=own
        )
        nearest, top = nearest_and_top(made.bodies[0], made)
        time = np.linspace(0, 4000, 2000)
        gap = made.bodies[0].motion.pose(time).position - made.antenna(time)
        assert np.hypot(gap[:, 0], gap[:, 1]).min() - math.hypot(40, 15) >= nearest - 1e-6
        assert top == 9.0


def test_a_turning_ship_keeps_its_distance() -> None:
    """Waypoints with a turn radius: the arc comes 200 m nearer than the chord between its ends, and no more than it is long."""
    track = [{"position_m": [x, y], "speed_kn": 10} for x, y in ((3000, 3000), (1000, 0), (3000, -3000))]
    made = scene([point("t", 3000, 0, waypoints=track, turn_radius_m=900, loop=True)])
    time = np.linspace(0, 20_000, 20_000)
    position = made.bodies[0].motion.pose(time).position
    nearest = np.hypot(position[:, 0], position[:, 1]).min()
    assert closest_approach(made.own_ship, made.bodies[0].motion) <= nearest
    assert closest_approach(made.bodies[0].motion, made.own_ship) <= nearest
