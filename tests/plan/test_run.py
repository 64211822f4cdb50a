"""Runs of bodies past the antenna, against hand arithmetic and dense samples of time."""

import math
from typing import Any

import numpy as np
import pytest

from radar_service.numerics.constants import KNOT
from radar_service.plan.body_errors import HORIZON, body_run, ends_at_horizon
from radar_service.scattering.predictions import NEAREST
from radar_service.world.steering import Steering
from tests.scenes import point, scene


def run_of(body: dict[str, Any], own: dict[str, Any] | None = None, **sections: Any) -> Any:
    made = scene([body], own_ship=own or {}, **sections)
    return body_run(made.bodies[0], made)


def test_a_straight_course_is_nearest_abeam() -> None:
    """40 kn south from 1300 m, 200 m aside: after 63.2 s; the aspect turns by v / d there, the range changes by v far off."""
    speed = 40 * KNOT
    run = run_of(point("t", 200, 1300, speed_kn=40, course_deg=180))
    assert (run.nearest, run.time) == pytest.approx((200.0, 1300 / speed), abs=1e-3)
    assert run.turn == pytest.approx(speed / 200.0, rel=1e-3)
    assert run.radial == pytest.approx(speed, rel=0.02)
    assert run.start == pytest.approx(math.hypot(200, 1300))


def test_lines_that_cross_at_other_times_are_no_approach() -> None:
    """Both go to the same point, 2000 m off, at 20 kn and 10 kn: 2000 m x sin(26.6 degrees) apart, 894 m."""
    run = run_of(point("t", 2000, 2000, speed_kn=10, course_deg=270), {"speed_kn": 20, "course_deg": 0})
    assert run.nearest == pytest.approx(2000 / math.sqrt(5), rel=1e-6)


def test_what_goes_away_is_nearest_now_and_what_rests_does_not_turn() -> None:
    away = run_of(point("t", 0, 700, speed_kn=20, course_deg=0))
    assert (away.nearest, away.time) == (700.0, 0.0)
    still = run_of(point("t", 0, 700))
    assert (still.turn, still.radial, still.nearest) == (0.0, 0.0, 700.0)


def test_sway_turns_the_aspect_of_what_rests() -> None:
    sway = {"roll_deg": 5, "roll_period_s": 8}
    run = run_of(point("t", 0, 700), sway, radar={"height_m": 20})
    assert run.turn == pytest.approx(20 * math.radians(5) * 2 * math.pi / 8 / 700, rel=0.01)


def test_the_nearest_part_of_a_body_counts() -> None:
    plate = {"name": "p", "shape": "plate", "width_m": 100, "height_m": 5, "rcs_dbsm": 20, "position_m": [0, 400, 0]}
    assert run_of(plate).nearest == pytest.approx(350.0)


@pytest.mark.parametrize("seed", range(6))
def test_no_sample_of_a_track_is_nearer_or_faster(seed: int) -> None:
    """Way points of both ships, looped or not: a hundred samples a second are never nearer by 0.1 %, nor turn faster by 2 %, than
    the run says, while it lasts."""
    rng = np.random.default_rng(seed)

    def track() -> list[dict[str, Any]]:
        return [{"position_m": rng.uniform(-900, 900, 2).tolist(), "speed_kn": float(rng.uniform(5, 40))} for _ in range(4)]

    body = point("t", 0, 0) | {"position_m": [*rng.uniform(-900, 900, 2), 5.0], "waypoints": track(), "loop": seed % 2 == 0}
    own = {"position_m": rng.uniform(-900, 900, 2).tolist(), "waypoints": track()} if seed % 3 else {}
    made = scene([body], own_ship=own)
    run = body_run(made.bodies[0], made)
    time = np.arange(0.0, 400.0, 0.01)
    apart = made.bodies[0].motion.pose(time).position[:, :2] - made.antenna(time)[:, :2]
    distance = np.linalg.norm(apart, axis=1)
    turn = np.abs(np.diff(np.unwrap(np.arctan2(*apart.T)))) / 0.01
    assert run.nearest <= distance.min() * 1.001
    assert run.turn >= 0.98 * turn[distance[1:] > 30.0].max()


def test_loops_that_do_not_repeat_together_end_at_the_horizon() -> None:
    loop = {
        "loop": True,
        "waypoints": [{"position_m": [600, 500], "speed_kn": 9}, {"position_m": [600, 700], "speed_kn": 9}],
    }
    made = scene([point("t", 500, 500) | loop])
    assert not ends_at_horizon(made.bodies[0], made)
    under_way = scene([point("t", 500, 500) | loop], own_ship={"speed_kn": 1, "course_deg": 90})
    assert ends_at_horizon(under_way.bodies[0], under_way)
    time = np.arange(0.0, HORIZON)
    apart = under_way.bodies[0].motion.pose(time).position[:, :2] - under_way.antenna(time)[:, :2]
    distance = np.linalg.norm(apart, axis=1)
    assert (
        body_run(under_way.bodies[0], under_way).approach <= distance.min() + 1e-3
    )  # at its last corners, far from the first


@pytest.mark.parametrize("seed", range(4))
def test_what_is_steered_stays_within_its_bounds(seed: int) -> None:
    """Own ship and a box are commanded at random about each other; the bounds hold, whatever they do."""
    limits = {"max_speed_kn": 25, "max_turn_rate_deg_s": 6}
    box = {"name": "box", "shape": "box", "length_m": 30, "width_m": 8, "height_m": 6, "position_m": [300, 200, 0]}
    given = scene([box | {"steerable": limits}], own_ship={"steerable": limits | {"max_speed_kn": 30}})
    run, random, made = body_run(given.bodies[0], given), np.random.default_rng(seed), Steering(given)
    for spoke in range(0, 20_000, 300):
        values = {"speed_kn": random.uniform(0, 25), "turn_rate_deg_s": random.uniform(-6, 6)}
        made.add(spoke, ("box", None)[random.integers(2)], values, reached=spoke)
    time = np.arange(0.0, 69.0, 0.01)
    body, own = made.past.bodies[0], made.past.own_ship
    offset = (body.middles_at(time) - own.pose(time).position)[:, :2]
    distance = np.hypot(*offset.T)
    away = np.maximum(distance - body.radius, NEAREST)
    aspect = np.unwrap(np.arctan2(*offset.T) - body.motion.pose(time).heading)
    assert np.abs(np.gradient(distance, time)).max() <= run.radial
    assert np.abs(np.gradient(aspect, time))[distance > body.radius + NEAREST].max() <= run.turn
    assert (2.0 * given.radar.height * np.abs(np.gradient(distance, time)) / away**2).max() <= run.sea_turn
    assert run.nearest == run.approach == 0.0 <= distance.min()


def test_own_ship_under_command_bounds_bodies_at_rest_too() -> None:
    steered = run_of(point("t", 0, 700), {"steerable": {"max_speed_kn": 10}})
    assert (steered.nearest, steered.start) == (0.0, 700.0)
    assert steered.radial == pytest.approx(10 * KNOT) and steered.turn == pytest.approx(2 * 10 * KNOT / NEAREST)
