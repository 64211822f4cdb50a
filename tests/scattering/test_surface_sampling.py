"""Scatterers: fixed, on the surface, carrying its area."""

import numpy as np
import pytest

from radar_service.fidelity import MIN_SCATTERERS
from radar_service.scattering.surface_sampling import cell_density, sample_surface, triangle_frames
from radar_service.scene.body import Mesh
from tests.scenes import scene

SLIVERS = Mesh(
    np.array([[0.0, 0, 0], [10, 0, 0], [10, 5, 0], [0, 5, 0], [10, 0.01, 0]]), np.array([[0, 1, 4], [0, 4, 2], [0, 2, 3]])
)


def test_points_lie_on_their_triangles_and_carry_the_area() -> None:
    """Every point is in the plane and inside its triangle; areas sum to the surface's exactly (systematic sampling)."""
    _, _, area = triangle_frames(SLIVERS)
    made = sample_surface(SLIVERS, np.full(3, 20.0), np.random.default_rng(1))
    assert len(made) == pytest.approx(20 * area.sum(), abs=1)
    assert made.area.sum() == pytest.approx(area.sum(), rel=1e-9)
    a, b, c = (SLIVERS.vertices[SLIVERS.faces[made.triangle, i]] for i in range(3))
    system = np.stack([b - a, c - a, np.cross(b - a, c - a)], axis=-1)
    u, v, w = np.linalg.solve(system, (made.position - a)[..., None])[..., 0].T
    assert np.abs(w).max() < 1e-9 and u.min() > -1e-9 and v.min() > -1e-9 and (u + v).max() < 1 + 1e-9
    counts = np.bincount(made.triangle, minlength=3)
    assert np.all(np.abs(counts - 20 * area) <= 1)  # the expected number of each triangle, to within one


def test_density_varies_by_triangle_without_bias() -> None:
    """A triangle with a tenth of the density has a tenth of the points, each with ten times the area."""
    made = sample_surface(SLIVERS, np.array([50.0, 50.0, 5.0]), np.random.default_rng(1))
    _, _, area = triangle_frames(SLIVERS)
    carried = np.bincount(made.triangle, made.area, minlength=3)
    np.testing.assert_allclose(carried[1:], area[1:], rtol=1 / (5 * area[2]))  # within one point


def test_a_small_body_has_the_minimum_of_points() -> None:
    made = sample_surface(SLIVERS, np.full(3, 1e-3), np.random.default_rng(1))
    assert len(made) == MIN_SCATTERERS


def test_phases_are_uniform_and_the_same_for_the_same_generator() -> None:
    first = sample_surface(SLIVERS, np.full(3, 100.0), np.random.default_rng(4))
    second = sample_surface(SLIVERS, np.full(3, 100.0), np.random.default_rng(4))
    np.testing.assert_array_equal(first.phasor, second.phasor)
    np.testing.assert_allclose(np.abs(first.phasor), 1.0, rtol=1e-12)
    assert abs(first.phasor.mean()) < 4 / np.sqrt(len(first))  # 4 sigma


def test_density_follows_the_resolution_cell() -> None:
    """At 1 km a cell of 2 m x 68.07 m holds the requested 4 points: 4 / (2 x 68.07) per m^2."""
    assert cell_density(np.array([1000.0]), 2.0, np.deg2rad(3.9), 4.0)[0] == pytest.approx(4 / (2 * 68.068), rel=1e-4)


def test_built_in_shapes_have_scatterers() -> None:
    made = scene([{"name": "s", "shape": "sphere", "radius_m": 3, "position_m": [0, 500, 5], "rcs_dbsm": 0}]).bodies[0]
    assert made.mesh is not None
    points = sample_surface(made.mesh, np.full(len(made.mesh.faces), 1.0), np.random.default_rng(1))
    assert np.linalg.norm(points.position, axis=1).max() <= 3.0 + 1e-9
