"""Coarse and fine facets of a body."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_columns import body_columns
from radar_service.scattering.physical_optics.body_facets import SHADOW_EDGE, BodyFacets, body_facets, welded
from radar_service.scattering.physical_optics.facets import areas
from radar_service.world.shapes import box
from tests.scattering.physical_optics.test_facets import longest_edges


def made(length: float, edge: float) -> BodyFacets:
    parts = [body_facets(column, 3.0, edge) for column in body_columns(box(length, 8.0, 8.0))]
    return BodyFacets.joined(parts)


@pytest.mark.parametrize("length", [12.0, 100.0])
def test_fine_facets_make_up_the_coarse_ones(length: float) -> None:
    facets = made(length, 0.8)
    coarse = facets.surface
    assert longest_edges(coarse.corners).max() <= SHADOW_EDGE and longest_edges(facets.points[facets.fine.T]).max() <= 0.8
    fine = facets.cut(coarse)
    np.testing.assert_allclose(np.bincount(fine.origin, areas(fine.points[fine.corner.T])), areas(coarse.corners), rtol=1e-9)
    assert (coarse.facet == np.arange(len(coarse))).all()


def test_parts_are_cut_by_themselves() -> None:
    facets = made(12.0, 0.8)
    some = facets.surface.chosen(np.array([3, 0, 5]))
    parts = some.parts(some.corners * 1.0, np.arange(3))
    one, other = facets.cut(some), facets.cut(parts)
    sums = [np.bincount(cut.origin, areas(cut.points[cut.corner.T])) for cut in (one, other)]
    np.testing.assert_allclose(sums[0], sums[1], rtol=1e-9)
    assert longest_edges(other.points[other.corner.T]).max() <= 0.8


def test_each_point_is_there_once() -> None:
    """A box of 8 m in round numbers: corners of facets that meet are one point, in all and among some."""
    facets = made(8.0, 0.8)
    assert len(np.unique(facets.points, axis=0)) == len(facets.points) < facets.fine.size / 5
    some = facets.cut(facets.surface.chosen(np.array([0, 1, 7])))
    assert len(np.unique(some.points, axis=0)) == len(some.points) == len(np.unique(some.corner))
    corners = np.random.default_rng(1).integers(0, 40, size=(20_000, 3, 3)) / 8.0
    index, points = welded(corners)
    np.testing.assert_array_equal(points[index.T], corners)
    assert len(points) == len(np.unique(corners.reshape(-1, 3), axis=0))
