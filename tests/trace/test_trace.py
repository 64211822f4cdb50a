"""The short modules of trace, each under its name."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.numerics.result_cache import Revision
from radar_service.numerics.types import Flags, Floats
from radar_service.trace.moving_occluders import MovingOccluders
from radar_service.trace.occluder import Occluder
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPoses, pose_at
from radar_service.world.steered_motion import SteeredMotion
from tests.reference.legs import reflection_points
from tests.scenes import scene


# triangle_clusters: triangles that a test concerns are found without a look at all of them, and none is missed.
def soup(count: int, seed: int) -> Mesh:
    """Triangles of 1 m at random in a cube of 100 m, in no order."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0.0, 100.0, (count, 1, 3)) + rng.uniform(-0.5, 0.5, (count, 3, 3))
    return Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def near(points: Floats) -> Flags:
    """Which hulls may have a part in a cube of 10 m."""
    return np.asarray(((points.min(axis=1) < 30.0) & (points.max(axis=1) > 20.0)).all(axis=1))


@pytest.mark.parametrize("count", [1, 15, 17, 1025, 20_000])
def test_no_triangle_is_missed(count: int) -> None:
    mesh = soup(count, count)
    corners = mesh.vertices[mesh.faces]
    expected, found = corners[near(corners)], TriangleClusters(mesh).chosen(near)
    assert sorted(map(tuple, found.reshape(-1, 9).tolist())) == sorted(map(tuple, expected.reshape(-1, 9).tolist()))


def test_few_of_many_triangles_are_looked_at() -> None:
    """A sheet of 300 x 300 squares of 1 m in rows, of which 10 x 10 concern: some hundred boxes and a thousand triangles."""
    side = 301
    east, north = np.meshgrid(np.arange(side, dtype=np.float64), np.arange(side, dtype=np.float64))
    square = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.stack([square, square + 1, square + side, square + 1, square + side + 1, square + side], axis=1).reshape(
        -1, 3
    )
    asked = []

    def counted(points: Floats) -> Flags:
        asked.append(len(points))
        return near(points)

    mesh = Mesh(np.stack([east.ravel(), north.ravel(), 25.0 + 0.0 * east.ravel()], axis=1), faces)
    assert len(TriangleClusters(mesh).chosen(counted)) >= 200 and sum(asked) < 0.03 * len(faces)


# posed_occluders: occlusion by many bodies at an instant, against one body after the other.
EARTH = 4 / 3 * 6_371_000.0
ANTENNA = np.array([0.0, 0.0, 15.0])
BOX = {"shape": "box", "width_m": 20, "height_m": 12, "rcs_dbsm": 0, "speed_kn": 10}
FLEET = [
    {
        **BOX,
        "name": f"b{k}",
        "position_m": [45 * (k % 7) - 140, 150 + 31 * k, 0],
        "length_m": 20 + k % 3,
        "course_deg": 9 * k,
    }
    for k in range(40)
]


@pytest.mark.parametrize("sway", [{}, {"roll_deg": 8, "roll_period_s": 7}], ids=["upright", "rolling"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_many_at_once_occlude_what_each_occludes(by_sea: bool, sway: dict[str, Any]) -> None:
    """40 boxes, of three sizes, against one after the other: their own surfaces and those of others."""
    bodies = scene([{**body, **sway} for body in FLEET]).bodies
    made, time, earth, count = MovingOccluders(bodies, EARTH), 3.0, EARTH, 2000
    rng = np.random.default_rng(5)
    key, poses = rng.integers(len(bodies), size=count), BodyPoses(bodies).at(np.full(1, time))
    triangle = rng.integers(12, size=count)
    corners = np.array([bodies[k].mesh.vertices[bodies[k].mesh.faces[t]] for k, t in zip(key, triangle, strict=True)])
    position = poses.map_from_bodies(0, np.einsum("ec,eci->ei", rng.dirichlet(np.ones(3), count), corners), key)
    position[:, 2] = np.maximum(position[:, 2], 0.5)
    distance = np.hypot(position[:, 0], position[:, 1])
    foot = reflection_points(position, ANTENNA, earth)[0] if by_sea else None
    result = made.occluded_surfaces(
        key, position, distance, lambda own: (triangle[own], triangle[own] + 1), foot, ANTENNA, time
    )
    expected = np.zeros(count, dtype=np.bool_)
    for k, body in enumerate(bodies):
        one, pose, own = Occluder(body.mesh, earth), pose_at(body, time), key == k
        origin = np.broadcast_to(ANTENNA, position.shape) if foot is None else foot
        expected[own] |= one.self_occluded(pose, origin[own], position[own], (triangle[own], triangle[own] + 1))
        expected[~own] |= one.occludes(pose, origin[~own], position[~own])
        if foot is not None:
            expected |= one.occludes(pose, ANTENNA, foot)
    assert np.array_equal(result, expected)
    assert 100 < np.count_nonzero(result) < count - 100


# moving_occluders: what moving bodies occlude, and where they are meanwhile.
FLAT = np.inf
PILLAR = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40, "rcs_dbsm": 0, "speed_kn": 10}


def hidden(made: MovingOccluders, time: float) -> list[int]:
    """Which of POINTS the bodies occlude."""
    return np.flatnonzero(made.occluded(POINTS, np.hypot(POINTS[:, 0], POINTS[:, 1]), ANTENNA, time)).tolist()


def test_the_same_occluders_follow_other_bodies_and_changed_motions() -> None:
    given = scene([{**PILLAR, "name": "b", "position_m": [0, 400, 0], "speed_kn": 0, "steerable": {}}]).bodies
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


def test_the_sea_falls_away_below_a_line_of_sight(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of many bodies: a box of 5.5 m at 10 km is above the line to a point 5 m high at 20 km, which passes it at 4.1 m."""
    monkeypatch.setattr("radar_service.trace.moving_occluders.FEW_BODIES", 0)
    box = {**PILLAR, "name": "b", "position_m": [0, 10_000, 0], "height_m": 5.5, "course_deg": 90}
    made = MovingOccluders(scene([box]).bodies, 4.0 / 3.0 * 6371e3)
    assert made.occluded(np.array([[0.0, 20_000.0, 5.0]]), np.array([20_000.0]), ANTENNA, 0.0).all()
