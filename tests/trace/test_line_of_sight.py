"""Line of sight to points: every reason why one is not visible, and the shadows of moving bodies, in simple geometry."""

from typing import Any

import numpy as np
import pytest

from radar_service.numerics.frames import polar_from_map
from radar_service.trace.embree import RayCount
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.trace.occluder import Occluder
from radar_service.world.body import Body
from radar_service.world.poses import pose_at
from tests.occlusion import occluded
from tests.reference.legs import reflection_points
from tests.scenes import point, scene

EARTH = 4 / 3 * 6_371_000.0
ANTENNA = np.array([0.0, 0.0, 15.0])
BOX = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40, "rcs_dbsm": 0}


def bodies(*settings: dict[str, Any]) -> tuple[Body, ...]:
    return scene([{"name": f"b{k}", **one} for k, one in enumerate(settings)]).bodies


def points(*positions: tuple[float, float, float], body: int = 0, triangle: int = -1) -> SurfacePoints:
    count = len(positions)
    return SurfacePoints(np.full(count, body), np.full(count, triangle), np.array(positions))


def box(north: float, east: float = 0.0, **more: Any) -> dict[str, Any]:
    return {**BOX, "position_m": [east, north, 0], **more}


TARGET = point("t", 0, 900)
MOVES = {"course_deg": 90, "speed_kn": 10}


@pytest.mark.parametrize("motion", [{}, MOVES], ids=["at rest", "under way"])
def test_a_box_occludes_what_is_behind_it_and_nothing_else(motion: dict[str, Any]) -> None:
    made = OcclusionScene(bodies(TARGET, box(400, **motion)), EARTH)
    candidates = [(0, 900, 15), (0, 300, 15), (60, 900, 15), (0, 900, 100), (0, -900, 15)]
    visible = made.visible(points(*candidates), ANTENNA, 0.0, 1e5)
    assert visible.tolist() == [False, True, True, True, True]
    assert occluded(made, np.array(candidates, dtype=float), ANTENNA, 0.0).tolist() == [True, False, False, False, False]
    assert made.has_movers == bool(motion)


def test_bodies_under_way_occlude_where_they_are_at_the_time() -> None:
    """At 10 kn the box, 10 m to either side, has cleared the line to the target after 10 m: 1.9 s."""
    made = OcclusionScene(bodies(TARGET, box(400, **MOVES)), EARTH)
    behind = points((0, 900, 15))
    visible = [bool(made.visible(behind, ANTENNA, time, 1e5)[0]) for time in (0.0, 1.8, 2.1, 100.0)]
    assert visible == [False, False, True, True]
    assert made.visible(behind, ANTENNA, 0.0, 1e5, movers=False).all()
    assert not made.occluded_by_resting(behind.position, ANTENNA).any()


def test_transparent_bodies_occlude_nothing() -> None:
    made = OcclusionScene(bodies(TARGET, box(400, **MOVES)), EARTH, without=[1])
    assert made.visible(points((0, 900, 15)), ANTENNA, 0.0, 1e5).all()


def test_the_horizon_and_the_range_end_visibility() -> None:
    """15 m and 10 m: 28.998 km. The range is the slant one: 900 m off and 1200 m up are 1500 m."""
    made = OcclusionScene(bodies(TARGET), EARTH)
    far = points((0, 28_997, 10), (0, 28_999, 10), (0, 100, -1))
    assert made.visible(far, ANTENNA, 0.0, 1e5).tolist() == [True, False, False]
    high = points((0, 900, 1215))
    assert made.visible(high, ANTENNA, 0.0, 1500.2).all() and not made.visible(high, ANTENNA, 0.0, 1499.9).any()


@pytest.mark.parametrize("motion", [{}, MOVES], ids=["at rest", "under way"])
def test_a_body_occludes_its_own_far_side_but_not_its_near_side(motion: dict[str, Any]) -> None:
    """Middles of all triangles of a box, among other bodies before it in the list: those that face the antenna are visible."""
    made_bodies = bodies(TARGET, box(500, 300), box(400, heading_deg=0, **motion))
    mesh = made_bodies[2].mesh
    assert mesh is not None
    corners = mesh.vertices[mesh.faces] + [0, 400, 0]
    middle = corners.mean(axis=1)
    facing = np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), ANTENNA - middle)
    on_box = SurfacePoints(np.full(len(middle), 2), np.arange(len(middle)), middle + [0, 0, 1e-6])
    visible = OcclusionScene(made_bodies, EARTH).visible(on_box, ANTENNA, 0.0, 1e5)
    np.testing.assert_array_equal(visible, facing > 0)
    assert 2 <= visible.sum() <= 4


def test_a_body_that_counts_as_a_point_does_not_occlude_itself() -> None:
    made = OcclusionScene(bodies(box(400), box(600)), EARTH)
    assert made.visible(points((0, 400, 20), body=0), ANTENNA, 0.0, 1e5).all()
    assert not made.visible(points((0, 600, 20), body=1), ANTENNA, 0.0, 1e5).any()  # behind the other


def test_positions_together_are_occluded_as_each_alone() -> None:
    """Positions all round, sorted by azimuth, two ships, one of them due south where azimuths wrap."""
    rng = np.random.default_rng(5)
    position = np.stack([*rng.uniform(-1000, 1000, (2, 1000)), rng.uniform(0, 30, 1000)], axis=1)
    position = position[np.argsort(np.arctan2(position[:, 0], position[:, 1]))]
    made = OcclusionScene(bodies(TARGET, box(-200, **MOVES), box(150, 300, **MOVES)), EARTH)
    for time in (0.0, 3.0):
        shadowed = made.occluded_by_moving(position, ANTENNA, time)
        each = [bool(made.occluded_by_moving(one[None], ANTENNA, time)[0]) for one in position]
        np.testing.assert_array_equal(shadowed, each)
        assert set(position[shadowed, 1] < 0) == {True, False}


def test_the_sector_of_resting_shadows_holds_all_of_them() -> None:
    assert OcclusionScene(bodies(TARGET, box(400, **MOVES)), EARTH).resting_shadow_sector(ANTENNA)[1] == 0.0
    made = OcclusionScene(bodies(TARGET, box(400), box(400, 200)), EARTH)
    middle, half, begin = made.resting_shadow_sector(ANTENNA)
    rng = np.random.default_rng(6)
    position = np.stack([*rng.uniform(-1000, 1000, (2, 4000)), np.full(4000, 10.0)], axis=1)
    polar = polar_from_map(position[occluded(made, position, ANTENNA, 0.0)], ANTENNA, EARTH)
    assert len(polar.azimuth) > 50
    assert (np.abs(polar.azimuth - middle) <= half).all() and (polar.distance >= begin).all()
    assert half < np.deg2rad(30)


@pytest.mark.parametrize("motion", [{}, MOVES], ids=["at rest", "under way"])
@pytest.mark.parametrize("earth", [EARTH, np.inf])
def test_rays_by_the_sea_are_stopped_on_either_part(motion: dict[str, Any], earth: float) -> None:
    """From 15 m up to 15 m at 900 m the sea reflects half way. A low box stands in the reflection point's place, before it, or
    behind it: only there it stops the ray, although the direct ray passes above all of them."""
    target = points((0, 900, 15))
    for north, height, stopped in ((450, 2, True), (300, 4, False), (300, 6, True), (600, 4, False), (600, 6, True)):
        made = OcclusionScene(bodies(TARGET, box(north, **{**motion, "height_m": height})), earth)
        foot, _ = reflection_points(target.position, ANTENNA, earth)
        assert bool(made.visible_by_sea(target, foot, ANTENNA, 0.0, 1e5)[0]) != stopped
        assert made.visible(target, ANTENNA, 0.0, 1e5)[0]


def test_others_that_may_occlude_stand_between() -> None:
    made = OcclusionScene(bodies(TARGET, box(400), box(400, 200.0), box(1000), box(500, **MOVES)), EARTH)
    assert made.other_occluders(0, ANTENNA, 0.0) == [1, 4]
    assert made.other_occluders(0, ANTENNA, 60.0) == [1]
    assert made.other_occluders(0, ANTENNA, 0.0, movers=False) == [1]


def test_none_is_missed_whatever_bodies_do_within_half_a_second() -> None:
    """150 boxes at 60 kn, which move 15 m within half a second: those are named whose circles come within 1 m of the line at the
    instant itself, by positions of each body alone."""
    rng = np.random.default_rng(9)
    where, course = rng.uniform(-1000, 1000, (150, 2)), rng.uniform(0, 360, 150)
    fast = ({"course_deg": c, "speed_kn": 60} for c in course)
    many = bodies(*(box(*place, **motion) for place, motion in zip(where, fast, strict=True)))
    made, named = OcclusionScene(many, EARTH), 0
    for time in rng.uniform(0.0, 20.0, 40).tolist():
        plan = np.array([body.middle_at(time)[:2] for body in many])
        along = np.clip(plan @ plan[0] / (plan[0] @ plan[0]), 0.0, 1.0)
        reach = (many[0].radius + many[1].radius) * 1.001 + 1.0
        exact = np.flatnonzero(np.hypot(*(plan - along[:, None] * plan[0]).T) <= reach).tolist()
        assert made.other_occluders(0, ANTENNA, time) == [body for body in exact if body > 0]
        named += len(exact) - 1
    assert named > 10


def test_a_body_among_many_movers_is_tested_against_those_before_it() -> None:
    """400 boxes all round, at 300 to 2300 m: 20 m wide and 2 pi 1300 m round, a line of sight meets some 400 x 25 / 8168 = 1.2
    of them, and its own box. Each pair tried would be 400 rays."""
    rng = np.random.default_rng(8)
    azimuth, distance = rng.uniform(-np.pi, np.pi, 400), rng.uniform(300, 2300, 400)
    many = bodies(*(box(r * np.cos(a), r * np.sin(a), **MOVES) for a, r in zip(azimuth, distance, strict=True)))
    rays = RayCount()
    made = OcclusionScene(many, EARTH, rays=rays)
    rays.rays = 0
    middles = [(r * np.sin(a), r * np.cos(a), 20.0) for a, r in zip(azimuth, distance, strict=True)]
    visible = [bool(made.visible(points(middle, body=k), ANTENNA, 0.0, 1e5)[0]) for k, middle in enumerate(middles)]
    assert 400 < rays.rays < 5 * 400
    together = SurfacePoints(np.arange(400), np.full(400, -1), np.array(middles))
    assert made.visible(together, ANTENNA, 0.0, 1e5).tolist() == visible
    alone = [Occluder(body.mesh, EARTH) for body in many if body.mesh is not None]
    each = [one.occludes(pose_at(body, 0.0), ANTENNA, np.array(middles)) for one, body in zip(alone, many, strict=True)]
    others = np.array(each) & ~np.eye(400, dtype=np.bool_)
    np.testing.assert_array_equal(visible, ~others.any(axis=0))
    assert 50 < np.count_nonzero(visible) < 350


def test_a_scene_without_comings_and_goings_is_as_it_is_at_any_time() -> None:
    """Where a body goes, the scene of an earlier time is another one."""
    steady, going = (OcclusionScene(bodies(TARGET, box(400, **more)), EARTH) for more in (MOVES, {**MOVES, "end_s": 5.0}))
    assert steady.as_of(9.0) is steady and going.as_of(9.0) is not going
