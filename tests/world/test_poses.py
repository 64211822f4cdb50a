"""Poses of many bodies are those of each body."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body
from radar_service.world.poses import BodyPoses, map_from_bodies, merged_mesh, pose_at
from tests.scenes import point, scene


def test_poses_are_those_of_each_motion() -> None:
    """At rest, on a straight course, on a polygon and on arcs, before and after its end; to rounding of 1 km."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    made = scene(
        [
            point("rest", 1, 2, heading_deg=-30), point("straight", 3, 4, course_deg=50, speed_kn=9, heading_deg=-20),
            point("legs", 190, 160, waypoints=corners), point("arcs", 190, 160, waypoints=corners, turn_radius_m=40),
        ]
    )  # fmt: skip
    time = np.linspace(0, 60, 23)
    poses = BodyPoses(made.bodies).at(time)
    for b, body in enumerate(made.bodies):
        pose = body.motion.pose(time)
        np.testing.assert_allclose(poses.position[:, b], pose.position, atol=1e-12)
        np.testing.assert_allclose(poses.heading[:, b], pose.heading, atol=1e-15)


def test_points_are_transformed_as_by_the_frame() -> None:
    rng = np.random.default_rng(1)
    points, body = rng.normal(size=(40, 3)), rng.integers(0, 3, 40)
    position, heading = rng.normal(size=(3, 3)) * 100, np.array([0.0, 1.2, 5.0])
    transformed = map_from_bodies(points, body, position, heading)
    for b in range(3):
        expected = map_from_body(points[body == b], position[b], float(heading[b]))
        assert transformed[body == b] == pytest.approx(expected, abs=1e-12)


def test_poses_of_leaning_bodies_are_those_of_each_motion() -> None:
    """Of many bodies at once, of one, and back into the frame; what does not lean has no rotation of its own."""
    keys = {"roll_deg": 20, "pitch_deg": 10, "pitch_phase_deg": 60, "heave_m": 1, "yaw_deg": 5}
    made = scene([point("a", 1, 2), point("b", 30, 40, course_deg=50, speed_kn=9, **keys), point("c", 5, 6, yaw_deg=5)])
    time, rng = np.array([0.5, 3.0, 7.7]), np.random.default_rng(2)
    poses, points, body = BodyPoses(made.bodies).at(time), rng.normal(size=(30, 3)) * 9, rng.integers(0, 3, 30)
    assert list(poses.rotation) == [1]
    for k in range(len(time)):
        placed = poses.map_from_bodies(k, points, body)
        for b, one in enumerate(made.bodies):
            pose, own = pose_at(one, float(time[k])), body == b
            np.testing.assert_allclose(placed[own], pose.map_from_frame(points[own]), atol=1e-12)
            np.testing.assert_allclose(pose.frame_from_map(placed[own], np.inf), points[own], atol=1e-12)
            assert (pose.lean is None) == (b != 1) and pose.upright.rotation is None
            if pose.lean is not None:
                upright = pose.upright.map_from_frame(points[own] @ pose.lean.T)
                np.testing.assert_allclose(placed[own], upright, atol=1e-12)


def test_poses_of_ships_in_a_seaway_are_those_of_each_motion_to_the_byte() -> None:
    """Under way, at anchor, on legs, one that appears late, one that eases; of all or some, at few or many instants."""
    hull = {"shape": "hull", "length_m": 30, "beam_m": 8, "height_m": 8, "rcs_dbsm": 10}
    keys: list[dict[str, object]] = [{"course_deg": 50, "speed_kn": 9}, {},
                                     {"waypoints": [{"position_m": [99, 9], "speed_kn": 8}]}]  # fmt: skip
    keys += [{"course_deg": 300, "speed_kn": 5, "start_s": 4.0}, {"speed_kn": 5}]
    ships = [{"name": str(k), **hull, "position_m": [150.0 * k, 400, 0], **more} for k, more in enumerate(keys)]
    made = scene(ships, environment={"sea_state": 4, "seaway": True, "current_kn": 2, "current_to_deg": 20})
    *bodies, eases = made.bodies
    assert eases.motion.sway is not None
    bodies.append(replace(eases, motion=replace(eases.motion, sway=eases.motion.sway.eased((2.0, 1.0), 0.0))))
    evaluated = BodyPoses(bodies)
    for time in (np.array([6.0]), np.linspace(4.5, 90.0, 40), np.linspace(-1.0, 9.0, 5), np.zeros(0)):
        for requested in (None, np.array([1]), np.array([4, 0])):
            poses = evaluated.at(time, requested)
            for b in range(5) if requested is None else requested.tolist():
                pose = bodies[b].motion.pose(time)
                np.testing.assert_array_equal(poses.position[:, b], pose.position)
                np.testing.assert_array_equal(poses.heading[:, b], pose.heading)
                np.testing.assert_array_equal(poses.rotation[b], pose.rotation)


def test_bodies_that_are_not_even_are_found_among_those_requested() -> None:
    """Of one at rest, one on a straight course, and two on legs, of which one is not requested."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    legs = [point(name, 190, 160, waypoints=corners) for name in ("legs", "more")]
    made = scene([point("rest", 1, 2), legs[0], point("straight", 3, 4, course_deg=50, speed_kn=9), legs[1]])
    assert BodyPoses(made.bodies).uneven(np.array([0.0, 1.0]), np.array([0, 1, 2])).tolist() == [1]


def test_meshes_at_rest_are_merged_in_their_order_and_a_single_one_is_not_copied() -> None:
    box = {"shape": "box", "length_m": 4, "width_m": 2, "height_m": 3}
    made = scene(
        [
            {"name": "first", **box, "position_m": [10, 20, 0], "heading_deg": 90},
            point("buoy", 5, 5),
            {"name": "second", **box, "position_m": [-30, 5, 1]},
        ]
    )
    first, buoy, second = made.bodies
    merged, alone = merged_mesh(made.bodies), merged_mesh([first, buoy])
    assert merged is not None and alone is not None and first.mesh is not None and second.mesh is not None
    assert merged_mesh([buoy]) is None and alone.faces is first.mesh.faces
    expected = [pose_at(body, 0.0).map_from_frame(body.mesh.vertices[body.mesh.faces]) for body in (first, second)]
    assert np.array_equal(merged.vertices[merged.faces], np.concatenate(expected))
    assert np.array_equal(alone.vertices[alone.faces], expected[0])
