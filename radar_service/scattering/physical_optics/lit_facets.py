"""Which facets of a body each leg lights: on which side, and how much of them past all shadows.

Shadows are found on coarse facets, which are cut finely for the phase afterwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.patches import concave_sides
from radar_service.scattering.physical_optics.shadow_edges import Parts, visible_parts
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Mesh
from radar_service.types import Flags, Floats, Indices

SAME_NORMAL, SAME_OFFSET = 1e-4, 1e-3  # planes that differ by less, the latter in m, count as one


class Planes(NamedTuple):
    """Of the triangles (F,) of a mesh: a point (F, 3) [m], the unit normal (F, 3), 0 where there is no area, where other parts of
    the mesh rise before its front and its back (F, 2), and the number of the plane (F,), one for all triangles in it."""

    point: Floats
    normal: Floats
    may_rebounce: Flags
    number: Indices

    @classmethod
    def of(cls, mesh: Mesh) -> "Planes":
        """The planes of a mesh."""
        point, normal, _ = triangle_frames(mesh)
        offset = np.einsum("ij,ij->i", point, normal)[:, None]
        alike = np.round(np.concatenate([normal / SAME_NORMAL, offset / SAME_OFFSET], axis=1)) + 0.0
        return cls(point, normal, concave_sides(mesh), np.unique(alike, axis=0, return_inverse=True)[1].reshape(-1))


@dataclass(frozen=True)
class Surface:
    """Triangles (M,) of a body's surface.

    corners: (M, 3, 3) [m].
    triangle: (M,) of the mesh.
    facet: (M,) the coarse facet that each is as a whole, -1 for parts of one.
    cell: (M,) size of the cells in which their fields are summed [m].
    longest: (M,) the longest edge that the phase allows [m].
    side: (M, L) which side each of L legs lights: 1 the front, -1 the back, 0 none.
    share: (M, L) of the area that each leg reaches.
    """

    corners: Floats
    triangle: Indices
    facet: Indices
    cell: Floats
    longest: Floats
    side: NDArray[np.int8]
    share: Floats

    def __len__(self) -> int:
        return len(self.triangle)

    def chosen(self, which: Indices) -> Self:
        """The triangles `which` (N,)."""
        return replace(self, **{field.name: getattr(self, field.name).take(which, axis=0) for field in fields(self)})

    def parts(self, corners: Floats, origin: Indices) -> Self:
        """Parts (N, 3, 3) of the triangles `origin` (N,)."""
        return replace(self.chosen(origin), corners=corners, facet=np.full(len(origin), -1))

    def joined(self, other: Self) -> Self:
        """These triangles, then the other ones."""
        names = [field.name for field in fields(self)]
        return replace(self, **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names})


@dataclass(frozen=True)
class LitFacets:
    """Facets (M,) that some of L legs light.

    corner: (3, M) index of each corner in `points`.
    points: (V, 3) in the body's frame [m].
    corners: (M, 3, 3) [m].
    centre: (M, 3), the centroid [m].
    normal: (M, 3) of the mesh's triangle.
    triangle: (M,) of the mesh.
    cell: (M,) size of the cells in which their fields are summed [m].
    side, share: (M, L) as of `Surface`.
    rays: of each leg at the centroids.
    lengths: of each leg to the points (V,) [m].
    surface: the triangles that they are cut from.
    """

    corner: Indices
    points: Floats
    corners: Floats
    centre: Floats
    normal: Floats
    triangle: Indices
    cell: Floats
    side: NDArray[np.int8]
    share: Floats
    rays: tuple[LegRays, ...]
    lengths: tuple[Floats, ...]
    surface: Surface

    @property
    def point_cell(self) -> Floats:
        """The size of the cells at the points (V,) [m]."""
        size = np.empty(len(self.points))
        size[self.corner] = self.cell
        return size


def lit_surface(surface: Surface, legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8]) -> Surface:
    """The triangles that any of the legs reaches, cut at the edges of all shadows.

    outside: (F,) as from `outward_side`; the inner side of a closed body is never lit.
    """
    side = _lit_sides(surface, legs, planes, outside)
    lit = replace(surface, side=side, share=(side != 0).astype(np.float64))
    lit = lit.chosen(np.flatnonzero(side.any(axis=1)))
    for number, leg in enumerate(legs):
        lit = _past_shadows(lit, number, leg, planes)
    return lit.chosen(np.flatnonzero((lit.share > 0.0).any(axis=1)))


def _lit_sides(surface: Surface, legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8]) -> NDArray[np.int8]:
    centre, normal = surface.corners.mean(axis=1), planes.normal.take(surface.triangle, axis=0)
    outer = outside.take(surface.triangle)
    sides = []
    for leg in legs:
        rays = leg.rays(centre)
        side = -np.sign(np.einsum("ij,ij->i", normal, rays.direction) + rays.tilt * normal[:, 2])
        sides.append(np.where(rays.arrives & (side * outer >= 0.0), side, 0.0))
    return np.stack(sides, axis=1).astype(np.int8)


def _past_shadows(lit: Surface, number: int, leg: BodyLeg, planes: Planes) -> Surface:
    """The same triangles with the share that this leg reaches; those that the edge of a shadow crosses are cut."""
    share, side = lit.share.copy(), lit.side[:, number]
    searched = leg.crowded | planes.may_rebounce[lit.triangle, np.where(side > 0, 0, 1)]
    plain, crossed = np.flatnonzero((side != 0) & ~searched), np.flatnonzero((side != 0) & searched)
    share[plain, number] = leg.visible(lit.corners.take(plain, axis=0).mean(axis=1), lit.triangle[plain])
    whole, parts = visible_parts(lit.corners[crossed], lit.triangle[crossed], leg.visible, leg.crowded, leg.thin)
    share[crossed, number] = whole
    lit = replace(lit, share=share)
    if not len(parts.origin):
        return lit
    return lit.chosen(np.flatnonzero(~np.isnan(share[:, number]))).joined(_parts(lit, number, crossed, parts))


def _parts(lit: Surface, number: int, crossed: Indices, parts: Parts) -> Surface:
    result = lit.parts(parts.corners, crossed[parts.origin])
    share = result.share.copy()
    share[:, number] = parts.share
    return replace(result, share=share)
