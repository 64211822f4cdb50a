"""Sight lines against a float64 reference that bends every vertex about the antenna and tries every triangle."""

from typing import Any

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body
from radar_service.trace.occluder import Occluder, beyond_horizon
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPose

EARTH = 4 / 3 * 6_371_000.0
Floats = np.ndarray[Any, np.dtype[np.float64]]


def hills(seed: int, size: float, posts: int = 12) -> Mesh:
    """A rough square of terrain about its own origin."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-size, size, posts), np.linspace(-size, size, posts))
    z = rng.uniform(0, size / 20, x.shape)
    corner = np.arange(posts * posts).reshape(posts, posts)
    a, b, c, d = (q.ravel() for q in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces)


def bent(positions: Floats, antenna: Floats) -> Floats:
    """Positions as the antenna sees them, the definition of docs/conventions.md."""
    offset = positions - antenna
    drop = (offset[..., 0] ** 2 + offset[..., 1] ** 2) / (2 * EARTH)
    return np.stack([offset[..., 0], offset[..., 1], offset[..., 2] - drop], axis=-1)


def first_hits(mesh: Mesh, pose: BodyPose, antenna: Floats, rays: Floats) -> tuple[Floats, Floats, Floats]:
    """Where the nearest triangle stands along each ray, in its lengths (inf: none), its index, and the least distance of any
    barycentric coordinate there from an edge."""
    vertices = bent(map_from_body(mesh.vertices, pose.position, pose.heading), antenna)
    a, b, c = (vertices[mesh.faces[:, i]] for i in range(3))
    nearest, which, margin = np.full(len(rays), np.inf), np.full(len(rays), -1), np.full(len(rays), np.inf)
    for i, ray in enumerate(rays):
        system = np.stack([np.broadcast_to(ray, a.shape), a - b, a - c], axis=-1)
        t, u, v = np.linalg.solve(system, a[..., None])[..., 0].T
        edge = np.minimum(np.minimum(u, v), 1 - u - v)
        margin[i] = np.abs(edge[t > 0]).min()
        inside = np.flatnonzero((edge >= 0) & (t > 0))
        if len(inside):
            which[i] = inside[np.argmin(t[inside])]
            nearest[i] = t[which[i]]
    return nearest, which, margin


@pytest.mark.parametrize(("distance", "size"), [(800.0, 300.0), (20_000.0, 6000.0)])
def test_occluded_positions_are_those_of_the_reference(distance: float, size: float) -> None:
    """200 positions on and beyond turned terrain: the same answer except where a triangle's edge passes within 1 cm."""
    mesh, rng = hills(1, size), np.random.default_rng(2)
    pose = BodyPose(np.array([distance * 0.6, distance * 0.8, 5.0]), 0.7)
    occluder, antenna = Occluder(mesh, EARTH), np.array([3.0, -4.0, 60.0])
    positions = map_from_body(rng.uniform([-size, -size, 0], [size, size, size / 15], (200, 3)), pose.position, 0.7)
    nearest, _, _ = first_hits(mesh, pose, antenna, bent(positions, antenna))
    length = np.linalg.norm(positions - antenna, axis=1)
    clear = np.abs(nearest - 1) * length > 1.0  # a position within a metre of a surface: either answer
    occluded = occluder.occludes(pose, antenna, positions)
    assert 20 < occluded.sum() < 180
    np.testing.assert_array_equal(occluded[clear], (nearest < 1)[clear])
    assert clear.sum() > 100


def test_own_surface_is_seen_where_it_faces_and_occluded_behind() -> None:
    """Points on a sphere of 200 m at 3 km: those on the near side are seen, those on the far side are not."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=4, radius=200.0)
    mesh = Mesh(np.asarray(ball.vertices, float), np.asarray(ball.faces, np.int64))
    pose, antenna = BodyPose(np.array([0.0, 3000.0, 300.0]), 1.2), np.array([0.0, 0.0, 300.0])
    triangle = np.arange(len(mesh.faces))
    centroid = map_from_body(mesh.vertices[mesh.faces].mean(axis=1), pose.position, pose.heading)
    normal = map_from_body(np.asarray(ball.face_normals), np.zeros(3), pose.heading)
    facing = np.einsum("ij,ij->i", normal, antenna - centroid) / np.linalg.norm(antenna - centroid, axis=1)
    occluded = Occluder(mesh, EARTH).self_occluded(pose, antenna, centroid, (triangle, triangle + 1))
    steep = np.abs(facing) > 0.02  # facets of 6 degrees: nearer to edge-on the neighbours decide
    np.testing.assert_array_equal(occluded[steep], (facing < 0)[steep])


def test_line_of_sight_over_the_curved_earth() -> None:
    """A wall 40 m high at 15 km, seen from 60 m: at 30 km, the earth between, the line of sight passes the wall at
    (60 + h) / 2 - 15^2 / (2 ae) x ... = (60 + h) / 2 - 13.25 m, so h = 46.5 m is the edge; flat it would be 20 m."""
    wall = Mesh(np.array([[-500.0, 0, 0], [500, 0, 0], [500, 0, 40], [-500, 0, 40]]), np.array([[0, 1, 2], [0, 2, 3]]))
    pose, antenna = BodyPose(np.array([0.0, 15_000.0, 0.0]), 0.0), np.array([0.0, 0.0, 60.0])
    edge = 2 * (40 + 15_000**2 / (2 * EARTH)) - 60
    positions = np.array([[0.0, 30_000.0, edge - 0.5], [0.0, 30_000.0, edge + 0.5]])
    np.testing.assert_array_equal(Occluder(wall, EARTH).occludes(pose, antenna, positions), [True, False])
    flat_edge = 2 * 40 - 60
    np.testing.assert_array_equal(
        Occluder(wall, np.inf).occludes(
            pose, antenna, np.array([[0, 30_000.0, flat_edge - 0.5], [0, 30_000.0, flat_edge + 0.5]])
        ),
        [True, False],
    )


def test_horizon_is_the_sum_of_the_two_roots() -> None:
    """15 m and 10 m see each other to 28.998 km (reference values; half the last digit), and under water is occluded."""
    distance = np.array([28_997.0, 28_999.0, 100.0])
    height = np.array([10.0, 10.0, -0.1])
    np.testing.assert_array_equal(beyond_horizon(distance, height, 15.0, EARTH), [False, True, True])
    np.testing.assert_array_equal(beyond_horizon(distance, height, 15.0, np.inf), [False, False, True])


def test_what_diffracts_has_no_horizon() -> None:
    """Up to a height of antenna and point, one or one each; under water nothing does."""
    distance, height = np.full(4, 60e3), np.array([10.0, 19.0, 21.0, -0.1])
    np.testing.assert_array_equal(beyond_horizon(distance, height, 15.0, EARTH, 20.0), [False, False, True, True])
    np.testing.assert_array_equal(beyond_horizon(distance, height, 25.0, EARTH, 20.0), [True, True, True, True])
    each = np.array([9.0, 20.0, 22.0, 20.0])
    np.testing.assert_array_equal(beyond_horizon(distance, height, 5.0, EARTH, each), [True, False, False, True])


def test_no_ray_slips_through_the_edges_of_a_closed_body() -> None:
    """20,000 lines of sight at the vertices and edge middles of a sphere's far side: all blocked but for Embree's known
    0.09 % at exact edges (docs/accuracy.md#embree), allowed 0.3 %."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=5, radius=50.0)
    mesh = Mesh(np.asarray(ball.vertices, float), np.asarray(ball.faces, np.int64))
    middles = mesh.vertices[np.asarray(ball.edges_unique)].mean(axis=1)
    antenna = np.array([0.0, -2000.0, 0.0])
    through = np.concatenate([mesh.vertices, middles])
    through = through[through[:, 1] < -5.0]
    beyond = antenna + (through - antenna) * 1.5
    occluded = Occluder(mesh, np.inf).occludes(BodyPose(np.zeros(3), 0.0), antenna, beyond)
    assert np.mean(~occluded) < 0.003
