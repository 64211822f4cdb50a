"""Which facets of a body each leg lights: on which side, and how much of them past all shadows."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.shadow_edges import Parts, visible_parts
from radar_service.types import Flags, Floats, Indices


class Planes(NamedTuple):
    """Of the triangles (F,) of a mesh: a point (F, 3) [m], the unit normal (F, 3), 0 where there is no area, and where other
    parts of the mesh rise before its front and its back (F, 2)."""

    point: Floats
    normal: Floats
    may_rebounce: Flags


class LitFacets(NamedTuple):
    """Facets (M,) that some of L legs light.

    corners: (M, 3, 3) [m].
    centre: (M, 3), the centroid [m].
    normal: (M, 3) of the mesh's triangle.
    cell: (M,) size of the cells in which their fields are summed [m].
    triangle: (M,) of the mesh.
    side: (L, M) which side each leg lights: 1 the front, -1 the back, 0 none.
    share: (L, M) of the area that each leg reaches.
    rays: of each leg at the centroids.
    """

    corners: Floats
    centre: Floats
    normal: Floats
    cell: Floats
    triangle: Indices
    side: NDArray[np.int8]
    share: Floats
    rays: tuple[LegRays, ...]

    def chosen(self, which: Indices) -> "LitFacets":
        """The facets `which` (N,)."""
        columns = [column.take(which, axis=0) for column in (self.corners, self.centre, self.normal, self.cell)]
        by_leg = self.side[:, which], self.share[:, which], tuple(ray.chosen(which) for ray in self.rays)
        return LitFacets(*columns, self.triangle[which], *by_leg)

    def joined(self, other: "LitFacets") -> "LitFacets":
        """These facets, then the other ones."""
        names = ("corners", "centre", "normal", "cell")
        columns = [np.concatenate([getattr(self, name), getattr(other, name)]) for name in names]
        triangle = np.concatenate([self.triangle, other.triangle])
        side, share = np.concatenate([self.side, other.side], axis=1), np.concatenate([self.share, other.share], axis=1)
        rays = tuple(one.joined(more) for one, more in zip(self.rays, other.rays, strict=True))
        return LitFacets(*columns, triangle, side, share, rays)


def lit_facets(
    corners: Floats, triangle: Indices, cell: Floats, legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8]
) -> LitFacets:
    """The facets (M, 3, 3) on triangles (M,) that any of the legs reaches, cut at the edges of all shadows.

    outside: (F,) as from `outward_side`; the inner side of a closed body is never lit.
    """
    lit = _facing(corners, triangle, cell, legs, planes, outside)
    lit = lit.chosen(np.flatnonzero(lit.side.any(axis=0)))
    for number, leg in enumerate(legs):
        lit = _past_shadows(lit, number, leg, legs, planes)
    return lit.chosen(np.flatnonzero((lit.share > 0.0).any(axis=0)))


def _facing(
    corners: Floats, triangle: Indices, cell: Floats, legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8]
) -> LitFacets:
    centre, normal = corners.mean(axis=1), planes.normal.take(triangle, axis=0)
    rays = tuple(leg.rays(centre) for leg in legs)
    side = np.stack([_lit_side(ray, normal, outside.take(triangle)) for ray in rays])
    return LitFacets(corners, centre, normal, cell, triangle, side, (side != 0).astype(np.float64), rays)


def _lit_side(rays: LegRays, normal: Floats, outside: NDArray[np.int8]) -> NDArray[np.int8]:
    side = -np.sign(np.einsum("ij,ij->i", normal, rays.direction) + rays.tilt * normal[:, 2])
    return np.asarray(np.where(rays.arrives & (side * outside >= 0.0), side, 0.0), dtype=np.int8)


def _past_shadows(lit: LitFacets, number: int, leg: BodyLeg, legs: Sequence[BodyLeg], planes: Planes) -> LitFacets:
    """The same facets with the share that this leg reaches; those that a shadow crosses are cut."""
    share = lit.share.copy()
    facing = lit.side[number] != 0
    searched = leg.crowded | planes.may_rebounce[lit.triangle, np.where(lit.side[number] > 0, 0, 1)]
    plain, crossed = np.flatnonzero(facing & ~searched), np.flatnonzero(facing & searched)
    share[number, plain] = leg.visible(lit.centre.take(plain, axis=0), lit.triangle[plain])
    whole, parts = visible_parts(lit.corners[crossed], lit.triangle[crossed], leg.visible, leg.crowded)
    share[number, crossed] = whole
    lit = lit._replace(share=share)
    if not len(parts.origin):
        return lit
    return lit.chosen(np.flatnonzero(~np.isnan(share[number]))).joined(_parts(lit, number, crossed, parts, legs))


def _parts(lit: LitFacets, number: int, crossed: Indices, parts: Parts, legs: Sequence[BodyLeg]) -> LitFacets:
    origin = crossed[parts.origin]
    share = lit.share[:, origin]
    share[number] = parts.share
    centre = parts.corners.mean(axis=1)
    rays = tuple(leg.rays(centre) for leg in legs)
    inherited = lit.normal[origin], lit.cell[origin], lit.triangle[origin], lit.side[:, origin]
    return LitFacets(parts.corners, centre, *inherited, share, rays)
