"""Cutting meshes: nothing lost, nothing too long, never too many."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.plan.plan import plan_for
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.physical_optics.facets import (
    MAX_BEND,
    EdgeLimits,
    bend_edge,
    cut_facets,
)
from radar_service.scattering.physical_optics.optical_body import facet_enlargement
from radar_service.world.shapes import box, sphere
from tests.reference.shadow_witnesses import halves
from tests.reference.tube_witness import first_largest, line_through
from tests.scenes import scene

Floats = NDArray[np.float64]


def areas(corners: Floats) -> Floats:
    return np.asarray(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2)


def longest_edges(corners: Floats) -> Floats:
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1))


def test_facets_cover_every_triangle_and_are_short_enough() -> None:
    mesh = box(90.0, 13.0, 18.0)
    cut = cut_facets(mesh, 2.0)
    assert longest_edges(cut.corners).max() <= 2.0
    np.testing.assert_allclose(np.bincount(cut.triangle, areas(cut.corners)), areas(mesh.vertices[mesh.faces]), rtol=1e-12)
    np.testing.assert_allclose(cut.centre, cut.corners.mean(axis=1), atol=1e-12)
    assert cut.enlargement == 1.0


def test_too_many_facets_are_enlarged() -> None:
    """A 300 m ship at close quarters: the bound holds, and `enlargement` is how much longer the edges are."""
    mesh = box(300.0, 50.0, 40.0)
    cut = cut_facets(mesh, 0.4, max_facets=5000)
    assert len(cut) <= 5000 and cut.enlargement > 4.0
    assert longest_edges(cut.corners).max() <= 0.4 * cut.enlargement
    assert areas(cut.corners).sum() == pytest.approx(areas(mesh.vertices[mesh.faces]).sum(), rel=1e-12)


def test_a_mesh_finer_than_the_bound_is_taken_as_it_is() -> None:
    mesh = sphere(1.0)
    assert len(cut_facets(mesh, 5.0, max_facets=10)) == len(mesh.faces)


def test_the_plan_reports_enlarged_facets() -> None:
    """300 x 50 x 40 m in blocks of 32 m: at 1000 m the facets are as short as requested. At 17 m a block's would be too many,
    and the plan says so."""
    giant = {"name": "giant", "shape": "box", "length_m": 300, "width_m": 50, "height_m": 40, "scattering": "optics"}
    for north, enlarged in ((1150, False), (167, True)):
        made = scene([{**giant, "position_m": [0, north, 0]}])
        assert ("longer than they should be" in plan_for(made, Fidelity("test")).choices[-1].how) == enlarged
        assert (facet_enlargement(made.bodies[0], made.radar, north - 150.0) > 1.0) == enlarged


def test_the_phase_bends_by_the_bound_over_half_an_edge() -> None:
    """k (e/2)^2 / R of two-way phase."""
    edge = bend_edge(500.0, 0.03186)
    assert 2 * np.pi / 0.03186 * (edge / 2) ** 2 / 500.0 == pytest.approx(MAX_BEND)


def test_cells_lie_within_range_cell_beam_and_extent() -> None:
    """A quarter of c/2B far off; a sixth of the beam near by, at the lower end of the half octave; a ninth of a small body."""
    limits = EdgeLimits(3.0, np.deg2rad(1.0), 0.03186, 100.0)
    assert limits.cell(5000.0) == 0.75
    assert np.deg2rad(1.0) / 6 * 200.0 / 2**0.5 < limits.cell(200.0) <= np.deg2rad(1.0) / 6 * 200.0
    assert EdgeLimits(3.0, np.deg2rad(1.0), 0.03186, 3.6).cell(5000.0) == pytest.approx(0.4)
    assert all(limits.longest_edge(d) <= 0.6 * 3.0 for d in np.geomspace(1.0, 2e4, 50))


def test_halves_cut_the_longest_edge() -> None:
    corners = np.random.default_rng(2).normal(size=(50, 3, 3))
    both = halves(corners)
    np.testing.assert_allclose(areas(both[:50]) + areas(both[50:]), areas(corners))
    assert (longest_edges(both) <= np.tile(longest_edges(corners), 2)).all()


def test_a_line_is_extended_to_the_whole_triangle() -> None:
    """Any line x / p + y / q = 1 in shares of both edges: it crosses the small triangle's edges where y or x is a third of the
    inset."""
    inset, third = 0.05, 0.05 / 3.0
    p, q = np.random.default_rng(2).uniform(0.1, 0.9, size=(2, 100))
    crossing = (np.stack([p * (1.0 - third / q), q * (1.0 - third / p)]) - third) / (1.0 - inset)
    np.testing.assert_allclose(line_through(crossing, inset), [p, q], rtol=1e-12)


def test_of_edges_that_are_equal_but_for_rounding_the_first_is_cut() -> None:
    """A triangle with two equal legs, turned by angles that round them differently, is halved alike."""
    np.testing.assert_array_equal(first_largest(np.array([[1.0, 2.0 - 1e-12, 3.0], [1.0 + 1e-12, 2.0, 1.0]])), [0, 0, 0])
    np.testing.assert_array_equal(first_largest(np.array([[1.0, 2.0], [1.0 + 1e-5, 1.9]])), [1, 0])
    triangle = np.array([[[0.0, 0.0, 0.0], [2.0, 3.0, 0.0], [4.0, 0.0, 0.0]]])
    parts = []
    for angle in np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 50):
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        parts.append(halves(halves(triangle @ turn.T)) @ turn)
    assert max(float(np.abs(part - parts[0]).max()) for part in parts) < 1e-12
