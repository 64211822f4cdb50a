"""Coarse and fine facets of a body."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.blocks import blocks
from radar_service.scattering.physical_optics.body_facets import SHADOW_EDGE, BodyFacets, body_facets
from radar_service.scattering.physical_optics.path_fields import areas
from radar_service.scene.shapes import box
from tests.scattering.physical_optics.test_facets import longest_edges


def made(length: float, edge: float) -> BodyFacets:
    parts = [body_facets(block, 3.0, edge, np.full(len(block.triangle), edge), 0) for block in blocks(box(length, 8.0, 8.0))]
    return BodyFacets.joined(parts)


@pytest.mark.parametrize("length", [12.0, 100.0])
def test_fine_facets_make_up_the_coarse_ones(length: float) -> None:
    facets = made(length, 0.8)
    coarse = facets.surface
    assert longest_edges(coarse.corners).max() <= SHADOW_EDGE and longest_edges(facets.fine).max() <= 0.8
    corners, origin = facets.cut(coarse)
    np.testing.assert_allclose(np.bincount(origin, areas(corners)), areas(coarse.corners), rtol=1e-9)
    assert (coarse.facet == np.arange(len(coarse))).all()


def test_parts_are_cut_by_themselves() -> None:
    facets = made(12.0, 0.8)
    some = facets.surface.chosen(np.array([3, 0, 5]))
    parts = some.parts(some.corners * 1.0, np.arange(3))
    one, other = facets.cut(some), facets.cut(parts)
    np.testing.assert_allclose(np.bincount(one[1], areas(one[0])), np.bincount(other[1], areas(other[0])), rtol=1e-9)
    assert longest_edges(other[0]).max() <= 0.8
