"""What moving bodies occlude, and where they are meanwhile."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.result_cache import Revision
from radar_service.trace.moving_occluders import MovingOccluders
from radar_service.world.steered_motion import SteeredMotion
from tests.scenes import scene

FLAT = np.inf
ANTENNA = np.array([0.0, 0.0, 15.0])
BOX = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40, "rcs_dbsm": 0, "speed_kn": 10}


def moving(*given: tuple[float, float, float], without: tuple[int, ...] = ()) -> MovingOccluders:
    """Boxes at east, north, on a course [deg], behind one at rest that does not count."""
    bodies = [{**BOX, "name": "rests", "position_m": [0, 50, 0], "speed_kn": 0}]
    for k, (east, north, course) in enumerate(given):
        bodies.append({**BOX, "name": f"b{k}", "position_m": [east, north, 0], "course_deg": course})
    return MovingOccluders(scene(bodies).bodies, FLAT, without)


def hidden(made: MovingOccluders, time: float) -> list[int]:
    """Which of POINTS the bodies occlude."""
    return np.flatnonzero(made.occluded(POINTS, np.hypot(POINTS[:, 0], POINTS[:, 1]), ANTENNA, time)).tolist()


def test_the_same_occluders_follow_other_bodies_and_changed_motions() -> None:
    given = scene([{**BOX, "name": "b", "position_m": [0, 400, 0], "speed_kn": 0, "steerable": {}}]).bodies
    revision = Revision()
    made = MovingOccluders(given, FLAT, revision=revision)
    assert hidden(made, 0.0) == [0]
    motion = given[0].motion
    assert isinstance(motion, SteeredMotion)
    motion.steer(motion.segment_at(0.0)._replace(position=np.array([400.0, 0.0, 0.0])))
    motion.follow()
    assert hidden(made, 0.0) == [0]  # is cached
    revision.change()
    assert hidden(made, 0.0) == [1]
    other = made.following([replace(given[0], motion=replace(motion))])
    assert hidden(other, 0.0) == [0] and hidden(made, 0.0) == [1]


POINTS = np.array([[0.0, 900, 5], [900, 0, 5], [0, 300, 5], [0, -900, 5]])


def test_each_occludes_the_points_behind_it_alone() -> None:
    made = moving((0, 400, 90), (400, 0, 0), (-400, -400, 0))
    assert hidden(made, 0.0) == [0, 1]
    assert hidden(moving((0, 400, 90), (400, 0, 0), without=(1,)), 0.0) == [1]
    assert hidden(moving(), 0.0) == []


def test_they_are_where_they_are_at_the_time() -> None:
    """10 kn to the east, from 400 m west of north: after 77.8 s the box stands before the first and the third point."""
    made = moving((-400, 200, 90))
    assert hidden(made, 0.0) == []
    assert hidden(made, 77.8) == [0, 2]
    ((_, pose, _),) = made.chosen([1], 77.8)
    np.testing.assert_allclose(pose.position, [-400 + 77.8 * 10 * 1852 / 3600, 200, 0], atol=1e-9)  # rounding


def test_a_pickled_copy_answers_the_same() -> None:
    made = moving((0, 400, 90), (400, 0, 0))
    assert hidden(pickle.loads(pickle.dumps(made)), 1.0) == hidden(made, 1.0) == [0, 1]


def test_the_sea_falls_away_below_a_line_of_sight(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of many bodies: a box of 5.5 m at 10 km is above the line to a point 5 m high at 20 km, which passes it at 4.1 m."""
    monkeypatch.setattr("radar_service.trace.moving_occluders.FEW_BODIES", 0)
    box = {**BOX, "name": "b", "position_m": [0, 10_000, 0], "height_m": 5.5, "course_deg": 90}
    made = MovingOccluders(scene([box]).bodies, 4.0 / 3.0 * 6371e3)
    assert made.occluded(np.array([[0.0, 20_000.0, 5.0]]), np.array([20_000.0]), ANTENNA, 0.0).all()
