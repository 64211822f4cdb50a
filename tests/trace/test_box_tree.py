"""The tracer for platforms without Embree decides as Embree does, on the shipped meshes and in exact cases."""

from collections.abc import Iterator

import numpy as np
import pytest

import radar_service as rs
from radar_service.trace import box_tree
from radar_service.trace.box_tree import BoxTree
from radar_service.trace.embree import EmbreeTree
from radar_service.trace.moller_trumbore import watertight_crossings
from radar_service.world.body import Mesh
from tests.trace.test_occluder import hills

RAYS = 1000


def shipped_meshes() -> Iterator[Mesh]:
    """Every mesh of the packaged scenes once, about its own middle."""
    bodies = [body for name in ("harbour", "open-sea") for body in rs.load_scene(name).bodies]
    meshes = {body.mesh.vertices.tobytes(): body.mesh for body in bodies if body.mesh is not None}
    for mesh in meshes.values():
        middle = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2.0
        yield Mesh(mesh.vertices - middle, mesh.faces)


def rays_at(mesh: Mesh, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from one side, as an antenna casts them, each just reaching a point in or near the mesh's bounding box."""
    half = mesh.vertices.max(axis=0)
    aim = np.random.default_rng(seed).uniform(-1.1 * half, 1.1 * half, (RAYS, 3))
    origin = np.broadcast_to(np.array([1.5, 0.8, 0.3]) * np.linalg.norm(half[:2]), aim.shape)
    return np.ascontiguousarray(origin, dtype=np.float32), (aim - origin).astype(np.float32)


def as_float32(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)


def nearest_distances(mesh: Mesh, triangle: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Where each ray meets the plane of its triangle, in float64."""
    corners = as_float32(mesh)[0].astype(np.float64)[mesh.faces[triangle]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    toward = np.einsum("ij,ij->i", normal, corners[:, 0] - origins)
    return np.asarray(toward / np.einsum("ij,ij->i", normal, directions.astype(np.float64)))


def test_it_decides_as_embree_does_on_the_shipped_meshes() -> None:
    """Hits and shadows are the same. So are triangles, but where two lie within 1e-5 of the way (float32: 2^-23 relative, some
    ten operations): quays share walls. Embree leaks 0.09 % of rays aimed at edges, and these aim at none: 1 in 10,000 may."""
    count = hits = leaks = 0
    for seed, mesh in enumerate(shipped_meshes()):
        (origins, directions), reach = rays_at(mesh, seed), np.full(RAYS, 0.9, dtype=np.float32)
        embree, boxes = EmbreeTree(*as_float32(mesh)), BoxTree(*as_float32(mesh))
        ours, theirs = boxes.first_hit(origins, directions), embree.first_hit(origins, directions)
        leaks += np.count_nonzero((ours >= 0) != (theirs >= 0))
        differ = np.flatnonzero((ours != theirs) & (ours >= 0) & (theirs >= 0))
        one, other = (nearest_distances(mesh, hit[differ], origins[differ], directions[differ]) for hit in (ours, theirs))
        np.testing.assert_allclose(one, other, rtol=1e-5)
        shadows = boxes.occluded(origins, directions, reach), embree.occluded(origins, directions, reach)
        leaks += np.count_nonzero(shadows[0] != shadows[1])
        count, hits = count + 1, hits + int(np.count_nonzero(ours >= 0))
    assert count >= 15 and hits > 0.2 * count * RAYS
    assert leaks <= count * RAYS // 10_000


@pytest.mark.parametrize("pairs", [2**15, 7])
def test_first_hits_are_those_of_every_triangle_tried(monkeypatch: pytest.MonkeyPatch, pairs: int) -> None:
    """Also where few pairs are worked on at once. The triangles tried are float32 ones too, so all agree."""
    monkeypatch.setattr(box_tree, "MAX_PAIRS", pairs)
    mesh = hills(3, 300.0, posts=8)
    origins, directions = rays_at(mesh, 1)
    origins, directions = origins[:200], directions[:200]
    vertices, faces = as_float32(mesh)
    every = watertight_crossings(origins.astype(float), directions.astype(float), vertices.astype(float)[faces])
    expected = np.where(np.isfinite(every.min(axis=1)), every.argmin(axis=1), -1)
    assert 20 < np.count_nonzero(expected >= 0) < 200
    np.testing.assert_array_equal(BoxTree(vertices, faces).first_hit(origins, directions), expected)


def test_reach_ends_a_ray_and_nothing_lies_behind_it() -> None:
    vertices, faces = np.array([[0, 0, 5], [4, 0, 5], [0, 4, 5]], dtype=np.float32), np.array([[0, 1, 2]], dtype=np.int32)
    origins, up = np.ones((1, 3), dtype=np.float32), np.array([[0, 0, 2]], dtype=np.float32)
    tree = BoxTree(vertices, faces)
    assert [bool(tree.occluded(origins, up, np.array([reach], dtype=np.float32))[0]) for reach in (1.9, 2.1)] == [
        False,
        True,
    ]
    assert not tree.occluded(origins, -up, np.array([100], dtype=np.float32)).any()
    assert tree.first_hit(origins, np.concatenate([up, -up])[:1]).tolist() == [0]
    assert tree.first_hit(origins, -up).tolist() == [-1]


def test_rays_along_axes_and_faces_meet_what_they_should() -> None:
    """Directions with zeros, from inside the bounding box and on its faces, through a wall of 2 x 9 x 2 triangles."""
    y, z = np.meshgrid(np.arange(10.0), np.arange(3.0), indexing="ij")
    corner = np.arange(30).reshape(10, 3)
    a, b, c, d = (q.ravel() for q in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    tree = BoxTree(np.stack([np.zeros(30), y.ravel(), z.ravel()], 1).astype(np.float32), faces)
    east = np.array([[1, 0, 0]], dtype=np.float32)
    for y_value, z_value, met in (
        (0.3, 0.2, True),
        (4.0, 1.0, True),
        (9.0, 2.0, True),
        (9.01, 1.0, False),
        (4.0, -0.01, False),
    ):
        origin = np.array([[-2, y_value, z_value]], dtype=np.float32)
        assert (tree.first_hit(origin, east)[0] >= 0) == met, (y_value, z_value)


@pytest.mark.parametrize("pairs", [2**15, 5])
def test_of_coincident_triangles_the_first_is_met(monkeypatch: pytest.MonkeyPatch, pairs: int) -> None:
    monkeypatch.setattr(box_tree, "MAX_PAIRS", pairs)
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], dtype=np.float32)
    tree = BoxTree(vertices, np.array([[0, 1, 2]] * 9, dtype=np.int32))
    assert tree.first_hit(np.ones((1, 3), dtype=np.float32), np.array([[0, 0, -1]], dtype=np.float32)).tolist() == [0]
