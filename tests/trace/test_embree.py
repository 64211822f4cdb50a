"""Embree's answers against float64, and the same from a tree that unpickling built again."""

import pickle

import numpy as np
import pytest

from radar_service.trace.embree import RayCount, TriangleScene
from radar_service.trace.moller_trumbore import watertight_crossings
from tests.trace.test_occluder import hills

MESH = hills(1, 300.0)
ORIGIN = np.array([3.0, -4.0, 60.0])


def rays(count: int = 400) -> np.ndarray:
    aims = np.random.default_rng(2).uniform([-400, -400, -20], [400, 400, 80], (count, 3))
    return np.asarray((aims - ORIGIN) / np.linalg.norm(aims - ORIGIN, axis=1)[:, None])


def scene(count: RayCount | None = None) -> TriangleScene:
    return TriangleScene(MESH.vertices, MESH.faces, count)


def test_first_hits_and_their_distances_are_those_of_float64() -> None:
    """The same triangle wherever the two nearest lie 1 cm apart; the distance in float64, 1e-9 m."""
    crossings = np.sort(watertight_crossings(ORIGIN, rays(), MESH.vertices[MESH.faces]), axis=1)
    which = np.argmin(watertight_crossings(ORIGIN, rays(), MESH.vertices[MESH.faces]), axis=1)
    made = scene()
    hit = made.first_hit(ORIGIN, rays())
    met = np.isfinite(crossings[:, 0])
    clear = np.zeros(len(met), dtype=np.bool_)
    clear[met] = crossings[met, 1] - crossings[met, 0] > 0.01
    assert (clear & met).sum() > 100 and np.mean((hit >= 0) == met) > 0.99  # edges of the terrain: float32
    both = clear & met & (hit >= 0)
    np.testing.assert_array_equal(hit[both], which[both])
    distance = made.hit_distance(hit[both], ORIGIN, rays()[both])
    np.testing.assert_allclose(distance, crossings[both, 0], rtol=0, atol=1e-9)


def test_occluded_counts_only_triangles_within_reach() -> None:
    made = scene()
    hit = made.first_hit(ORIGIN, rays())
    met = np.flatnonzero(hit >= 0)
    distance = made.hit_distance(hit[met], ORIGIN, rays()[met])
    assert made.occluded(ORIGIN, rays()[met], distance + 0.01).all()
    assert not made.occluded(ORIGIN, rays()[met], distance - 0.01).any()
    assert not made.occluded(ORIGIN, rays()[hit < 0], 1e6).any()


def test_a_pickled_scene_hits_the_same() -> None:
    """Also where it had cast rays before, and where it had cast none. No tree travels along: it cannot be pickled."""
    used = scene()
    before = used.first_hit(ORIGIN, rays())
    used.hit_distance(before[before >= 0], ORIGIN, rays()[before >= 0])
    for made in (used, scene()):
        copy = pickle.loads(pickle.dumps(made))
        np.testing.assert_array_equal(copy.first_hit(ORIGIN, rays()), before)
        met = np.flatnonzero(before >= 0)
        args = before[met], ORIGIN, rays()[met]
        np.testing.assert_array_equal(copy.hit_distance(*args), used.hit_distance(*args))
        assert (copy.radius, copy.centre.tolist()) == (made.radius, made.centre.tolist())


def test_rays_are_counted_and_none_give_none() -> None:
    count = RayCount()
    made = scene(count)
    made.first_hit(ORIGIN, rays(30))
    made.occluded(ORIGIN, rays(12), 5.0)
    assert count.rays == 42
    assert made.first_hit(ORIGIN, np.zeros((0, 3))).shape == made.occluded(ORIGIN, np.zeros((0, 3)), 1.0).shape == (0,)


def test_a_ray_along_a_plane_never_meets_it() -> None:
    made = TriangleScene(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert np.isinf(made.hit_distance(np.zeros(1, dtype=np.int64), np.array([0.0, 0, 1]), np.array([[1.0, 0, 0]])))[0]


@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_a_scene_far_from_the_origin_is_as_exact(offset: float) -> None:
    """Stored about its own centre: rays 2 mm inside and outside an edge are told apart 100 km off."""
    vertices = np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0]]) + offset
    made = TriangleScene(vertices, np.array([[0, 1, 2]]))
    down = np.array([[0.0, 0, -1], [0.0, 0, -1]])
    origin = np.array([[5.0, 0.002, 1.0], [5.0, -0.002, 1.0]]) + offset
    assert made.first_hit(origin, down).tolist() == [0, -1]
