import numpy as np
import pytest
import trimesh

from radar_service.trace.embree import TriangleScene
from radar_service.trace.moller_trumbore import (
    TriangleList,
    printed_crossings,
    watertight_crossings,
    watertight_pairs,
)

TESTS = pytest.mark.parametrize("crossings", [printed_crossings, watertight_crossings])
UNIT = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
DOWN = np.array([[0.0, 0.0, -1.0]])


def ball() -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.icosphere(2)
    return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)


def barycentric(corners: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Smallest barycentric coordinate (M,) of each position in its triangle: how near an edge it is."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.einsum("ij,ij->i", normal, normal)
    parts = [np.einsum("ij,ij->i", np.cross(q - p, position - p), normal) / size for p, q in ((a, b), (b, c), (c, a))]
    return np.min(parts, axis=0)


@TESTS
@pytest.mark.parametrize(
    ("x", "y", "distance"),
    [(0.25, 0.25, 2.0), (0.5, 0.5, 2.0), (0.9, 0.05, 2.0), (0.6, 0.6, np.inf), (-0.01, 0.5, np.inf), (0.5, -0.01, np.inf)],
)
def test_a_ray_through_or_beside_one_triangle(crossings, x: float, y: float, distance: float) -> None:
    assert crossings(np.array([x, y, 2.0]), DOWN, UNIT)[0, 0] == pytest.approx(distance, rel=1e-14)  # rounding


@TESTS
def test_distance_counts_in_lengths_of_the_direction_and_never_backwards(crossings) -> None:
    origin = np.array([0.2, 0.2, 2.0])
    assert crossings(origin, 4 * DOWN, UNIT)[0, 0] == pytest.approx(0.5, rel=1e-14)
    assert crossings(origin, -DOWN, UNIT)[0, 0] == np.inf
    assert crossings(np.array([0.2, 0.2, 0.0]), DOWN, UNIT)[0, 0] == np.inf


@TESTS
def test_a_ray_in_the_plane_of_a_triangle_misses_it(crossings) -> None:
    assert crossings(np.array([-1.0, 0.2, 0.0]), np.array([[1.0, 0.0, 0.0]]), UNIT)[0, 0] == np.inf


@TESTS
def test_ten_thousand_rays_meet_the_triangle_that_embree_meets(crossings) -> None:
    vertices, faces = ball()
    random = np.random.default_rng(1)
    origin = np.array([3.0, 0.3, 0.2])
    rays = random.normal(scale=0.6, size=(10_000, 3)) - origin
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    embree = TriangleScene(vertices, faces)
    by_embree, one_by_one = embree.first_hit(origin, rays), TriangleList(vertices, faces, crossings).first_hit(origin, rays)
    assert 5000 < np.count_nonzero(one_by_one >= 0) < 9000
    differ = (by_embree != one_by_one) & (one_by_one >= 0)
    chosen = np.flatnonzero(differ)
    position = origin + rays[chosen] * embree.hit_distance(one_by_one[chosen], origin, rays[chosen])[:, None]
    near_edge = np.abs(barycentric(vertices[faces[one_by_one[chosen]]], position)) < 1e-6
    assert np.all(near_edge)  # elsewhere float32 is 1e-7 of these coordinates off: too little to change the triangle
    assert np.count_nonzero((by_embree >= 0) != (one_by_one >= 0)) == 0


@TESTS
def test_distances_are_those_of_the_embree_holder(crossings) -> None:
    vertices, faces = ball()
    rays = np.random.default_rng(2).normal(size=(200, 3))
    triangle = TriangleList(vertices, faces, crossings).first_hit(np.zeros(3), rays)
    there = TriangleList(vertices, faces, crossings).hit_distance(triangle, np.zeros(3), rays)
    nearest = crossings(np.zeros(3), rays, vertices[faces]).min(axis=1)
    assert there == pytest.approx(nearest, rel=1e-12)  # rounding
    assert there == pytest.approx(TriangleScene(vertices, faces).hit_distance(triangle, np.zeros(3), rays), rel=1e-12)


@TESTS
def test_blocks_do_not_change_the_answer(crossings, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = ball()
    rays = np.random.default_rng(3).normal(size=(50, 3))
    whole = TriangleList(vertices, faces, crossings).first_hit(np.array([2.0, 0.0, 0.0]), rays)
    monkeypatch.setattr("radar_service.trace.moller_trumbore.MAX_PAIRS", 97)
    assert np.array_equal(TriangleList(vertices, faces, crossings).first_hit(np.array([2.0, 0.0, 0.0]), rays), whole)


def test_rays_aimed_at_edges_and_corners_leak_as_printed_and_never_through_the_watertight_test() -> None:
    vertices, faces = ball()
    a, b = vertices[faces], vertices[np.roll(faces, 1, axis=1)]
    aims = np.concatenate([vertices, (0.3 * a + 0.7 * b).reshape(-1, 3), (0.5 * a + 0.5 * b).reshape(-1, 3)])
    origin = np.array([0.1, 0.2, 0.3])
    lost = {
        test: np.count_nonzero(TriangleList(vertices, faces, test).first_hit(origin, aims - origin) < 0)
        for test in (printed_crossings, watertight_crossings)
    }
    assert lost[printed_crossings] > 20 and lost[watertight_crossings] == 0


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
def test_the_watertight_test_does_not_know_the_scale(scale: float) -> None:
    vertices, faces = ball()
    rays = np.random.default_rng(4).normal(size=(500, 3))
    hit = TriangleList(scale * vertices, faces, watertight_crossings).first_hit(np.zeros(3), rays)
    assert np.array_equal(hit, TriangleList(vertices, faces, watertight_crossings).first_hit(np.zeros(3), rays))


def test_degenerate_triangles_are_never_met() -> None:
    line = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]])
    for crossings in (printed_crossings, watertight_crossings):
        assert crossings(np.array([0.5, 0.0, 1.0]), DOWN, line)[0, 0] == np.inf


def test_pairs_are_the_same_crossings_as_of_every_triangle() -> None:
    vertices, faces = ball()
    random = np.random.default_rng(3)
    origin = random.normal(scale=2.0, size=(400, 3))
    rays = random.normal(scale=0.3, size=(400, 3)) - origin
    triangle = random.integers(len(faces), size=400)
    every = watertight_crossings(origin, rays, vertices[faces])
    triangle[:200] = every[:200].argmin(axis=1)  # many that are met
    pairs = watertight_pairs(origin, rays, vertices[faces[triangle]])
    np.testing.assert_array_equal(pairs, every[np.arange(400), triangle])
    assert np.count_nonzero(np.isfinite(pairs)) > 150
