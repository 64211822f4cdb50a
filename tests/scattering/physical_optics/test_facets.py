"""Cutting meshes: nothing lost, nothing too long, never too many."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.fidelity import Fidelity
from radar_service.plan.plan import plan_for
from radar_service.scattering.physical_optics.facets import MAX_FACETS, cut_facets, far_field_edge
from radar_service.scattering.physical_optics.optical_body import longest_edge, optical_body
from radar_service.scene.shapes import box, sphere
from tests.scenes import scene

Floats = NDArray[np.float64]


def areas(corners: Floats) -> Floats:
    return np.asarray(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2)


def longest_edges(corners: Floats) -> Floats:
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1))


def test_facets_cover_every_triangle_and_are_short_enough() -> None:
    mesh = box(90.0, 13.0, 18.0)
    cut = cut_facets(mesh, np.full(len(mesh.faces), 2.0), 2.0)
    assert longest_edges(cut.corners).max() <= 2.0
    np.testing.assert_allclose(np.bincount(cut.triangle, areas(cut.corners)), areas(mesh.vertices[mesh.faces]), rtol=1e-12)
    np.testing.assert_allclose(cut.centre, cut.corners.mean(axis=1), atol=1e-12)
    assert cut.enlargement == 1.0


def test_tubes_are_finer_only_where_requested() -> None:
    mesh = box(10.0, 10.0, 10.0)
    tube = np.where(np.arange(len(mesh.faces)) == 3, 0.4, 2.0)
    cut = cut_facets(mesh, tube, 2.0)
    assert longest_edges(cut.corners[cut.triangle == 3]).max() <= 0.4
    assert longest_edges(cut.corners[cut.triangle != 3]).min() > 1.0


def test_too_many_facets_are_enlarged() -> None:
    """A 300 m ship at close quarters: the bound holds, and `enlargement` is how much longer the edges are."""
    mesh = box(300.0, 50.0, 40.0)
    cut = cut_facets(mesh, np.full(len(mesh.faces), 0.4), 0.4, max_facets=5000)
    assert len(cut) <= 5000 and cut.enlargement > 4.0
    assert longest_edges(cut.corners).max() <= 0.4 * cut.enlargement
    assert areas(cut.corners).sum() == pytest.approx(areas(mesh.vertices[mesh.faces]).sum(), rel=1e-12)


def test_tubes_have_a_budget_of_their_own() -> None:
    mesh = box(30.0, 30.0, 30.0)
    plain, fine = (
        cut_facets(mesh, np.full(len(mesh.faces), 2.0), 2.0),
        cut_facets(mesh, np.full(len(mesh.faces), 0.01), 2.0, max_tubes=7000),
    )
    assert len(plain) < len(fine) <= len(plain) + 7000
    assert fine.enlargement == 1.0


def test_a_mesh_finer_than_the_bound_is_taken_as_it_is() -> None:
    mesh = sphere(1.0)
    assert len(cut_facets(mesh, np.full(len(mesh.faces), 5.0), 5.0, max_facets=10)) == len(mesh.faces)


def test_the_plan_reports_enlarged_facets() -> None:
    """300 x 50 x 40 m: at 1000 m the facets are as short as requested. At 60 m they would be too many, and the plan says so."""
    giant = {"name": "giant", "shape": "box", "length_m": 300, "width_m": 50, "height_m": 40, "scattering": "optics"}
    description = {}
    for north in (1150, 210):
        made = scene([{**giant, "position_m": [0, north, 0]}])
        description[north] = plan_for(made, Fidelity("test")).choices[-1].how
        body = optical_body(made.bodies[0], made.radar, 3)
        cut = body.facets_of(longest_edge(north - 150.0, body.max_edge, body.wave.wavelength))
        assert len(cut) <= MAX_FACETS
        assert (cut.enlargement > 1.0) == ("longer than they should be" in description[north])
    assert "longer than they should be" in description[210] and "longer" not in description[1150]


def test_far_field_edge_bends_the_path_by_an_eighth_of_a_turn() -> None:
    """k (D/2)^2 / R = pi / 4 of two-way phase half an edge off."""
    edge = far_field_edge(500.0, 0.03186)
    assert 2 * np.pi / 0.03186 * (edge / 2) ** 2 / 500.0 == pytest.approx(np.pi / 4)
