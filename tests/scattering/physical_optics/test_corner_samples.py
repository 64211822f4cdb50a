"""Samples that facets share: each corner of a triangle's facets is asked for once."""

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.body_columns import body_columns
from radar_service.scattering.physical_optics.body_facets import BodyFacets, body_facets
from radar_service.scattering.physical_optics.corner_samples import MAX_INSET, renumbered
from radar_service.scattering.physical_optics.shadow_edges import sampled
from radar_service.world.shapes import box

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def made() -> tuple[BodyFacets, Floats, Floats]:
    """The facets of a box in several columns, and corners and normals of its triangles."""
    body = box(70.0, 9.0, 6.0)
    corners = body.vertices[body.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets = BodyFacets.joined([body_facets(column, 3.0, 0.8) for column in body_columns(body)])
    return facets, corners, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_samples_lie_on_their_triangle_close_to_the_corner() -> None:
    facets, corners, normal = made()
    samples, surface = facets.samples, facets.surface
    at_corner = samples.point[samples.corner.T]
    away = np.linalg.norm(at_corner - surface.corners, axis=2)
    assert 0.0 < away.max() <= MAX_INSET * 1.000001
    assert (samples.triangle[samples.corner] == surface.triangle).all()
    off = np.einsum("sx,sx->s", samples.point - corners[samples.triangle, 0], normal[samples.triangle])
    np.testing.assert_allclose(off, 0.0, atol=1e-12)


def test_flags_are_those_of_each_facet_by_itself_for_fewer_samples() -> None:
    """A shadow whose edge lies farther from every corner than the inset."""
    facets, _, _ = made()
    surface, asked = facets.surface, []

    def visible(points: Floats, triangle: Indices) -> NDArray[np.bool_]:
        asked.append(len(points))
        return np.asarray((points[:, 0] > 0.3217) ^ (triangle % 3 == 0))

    which = np.arange(len(surface))[::3]
    flags = facets.samples.flags(surface.facet[which], surface.corners[which], surface.triangle[which], visible)
    each = sampled(surface.corners[which], surface.triangle[which], visible)
    np.testing.assert_array_equal(flags, each)
    every = facets.samples.flags(surface.facet, surface.corners, surface.triangle, visible)
    assert every.any() and not every.all()
    assert asked[2] < 0.6 * 4 * len(surface)


def test_renumbered_indices_point_to_the_same() -> None:
    index = np.array([[7, 3], [3, 9]])
    used, again = renumbered(index, 10)
    np.testing.assert_array_equal(used, [3, 7, 9])
    np.testing.assert_array_equal(used[again], index)
