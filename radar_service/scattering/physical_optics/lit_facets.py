"""Which facets of a body each leg lights: on which side, and how much of them past all shadows.

Shadows are found on coarse facets, which are cut finely for the phase afterwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg, LegRays
from radar_service.scattering.physical_optics.corner_samples import CornerSamples
from radar_service.scattering.physical_optics.facets import areas, centroids
from radar_service.scattering.physical_optics.patches import concave_sides
from radar_service.scattering.physical_optics.shadow_edges import (
    SMALLEST,
    sampled,
    visible_parts,
    visible_share,
)
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.world.body import Mesh

SAME_NORMAL, SAME_OFFSET = 1e-4, 1e-3  # planes that differ by less, the latter in m, count as one


class Planes(NamedTuple):
    """Of the triangles (F,) of a mesh: a point (F, 3) [m], the unit normal (F, 3), 0 where there is no area, where other parts of
    the mesh rise before its front and its back (F, 2), and the number of the plane (F,), one for all triangles in it; and the
    area of the whole mesh [m^2]."""

    point: Floats
    normal: Floats
    may_rebounce: Flags
    number: Indices
    area: float

    @classmethod
    def of(cls, mesh: Mesh) -> "Planes":
        """The planes of a mesh."""
        point, normal, area = triangle_frames(mesh)
        offset = np.einsum("ij,ij->i", point, normal)[:, None]
        alike = np.round(np.concatenate([normal / SAME_NORMAL, offset / SAME_OFFSET], axis=1)) + 0.0
        number = np.unique(alike, axis=0, return_inverse=True)[1].reshape(-1)
        return cls(point, normal, concave_sides(mesh), number, float(area.sum()))

    def rotated(self, rotation: Floats) -> "Planes":
        """The planes of the same mesh rotated by a matrix (3, 3)."""
        return self._replace(point=self.point @ rotation.T, normal=self.normal @ rotation.T)


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
        """Returns both sets of triangles as one, the others last."""
        names = [field.name for field in fields(self)]
        return replace(self, **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names})


@dataclass(frozen=True)
class LitFacets:
    """Facets (M,) that some of L legs light.

    corner: (3, M) index of each corner in `points`.
    points: (V, 3) in the body's frame [m].
    edges: (3, 3, M) along the edges, by axis and by the opposite corner [m].
    area: (M,) [m^2].
    normal: (3, M) of the mesh's triangle, by axis.
    triangle: (M,) of the mesh.
    cell: (M,) size of the cells in which their fields are summed [m].
    side, share: (M, L) as of `Surface`.
    rays: of each leg at the centroids.
    lengths: of each leg to the points (V,) [m].
    """

    corner: Indices
    points: Floats
    edges: Floats
    area: Floats
    normal: Floats
    triangle: Indices
    cell: Floats
    side: NDArray[np.int8]
    share: Floats
    rays: tuple[LegRays, ...]
    lengths: tuple[Floats, ...]

    @property
    def point_cell(self) -> Floats:
        """The size of the cells at the points (V,) [m]."""
        size = np.empty(len(self.points))
        size[self.corner] = self.cell
        return size


def lit_surface(
    surface: Surface, legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8], samples: CornerSamples
) -> Surface:
    """The triangles that any of the legs reaches, cut at the edges of all shadows.

    outside: (F,) as from `outward_side`; the inner side of a closed body is never lit; samples: of the coarse facets.
    """
    side = _lit_sides(legs, planes, outside).take(surface.triangle, axis=0)
    for number, leg in enumerate(legs):
        side[_dark(surface, side[:, number], leg), number] = 0
    lit = replace(surface, side=side).chosen(np.flatnonzero(side.any(axis=1)))
    columns = [_first_shares(lit, lit.side[:, number], leg, planes, samples) for number, leg in enumerate(legs)]
    lit = replace(lit, share=np.stack(columns, axis=1))
    for number, leg in enumerate(legs):
        lit = _past_others(_past_shadows(lit, number, leg, planes.area), number, leg)
    return lit.chosen(np.flatnonzero((lit.share > 0.0).any(axis=1)))


def _lit_sides(legs: Sequence[BodyLeg], planes: Planes, outside: NDArray[np.int8]) -> NDArray[np.int8]:
    """Which side (F, L) of each triangle of the mesh each leg lights: that on which the antenna lies, or its mirror image."""
    sides = []
    for leg in legs:
        rays = leg.rays(planes.point)
        side = -np.sign(np.einsum("ij,ij->i", planes.normal, rays.direction) + rays.tilt * planes.normal[:, 2])
        sides.append(np.where(rays.arrives & (side * outside >= 0.0), side, 0.0))
    return np.stack(sides, axis=1).astype(np.int8)


def _dark(surface: Surface, side: NDArray[np.int8], leg: BodyLeg) -> Indices:
    """Triangles on the lit side (M,) that a shadow of another body covers: no ray looks for the body's own there."""
    if leg.others is None or not len(leg.others):
        return np.zeros(0, dtype=np.int64)
    lit = np.flatnonzero(side)
    return lit[leg.others.dark(surface.corners.take(lit, axis=0), leg.on_map)]


def _first_shares(lit: Surface, side: NDArray[np.int8], leg: BodyLeg, planes: Planes, samples: CornerSamples) -> Floats:
    """The share (M,) of each triangle that a leg reaches, by a few samples; NaN where these differ and it is to be cut."""
    share, corners, triangle = np.zeros(len(lit)), lit.corners, lit.triangle
    searched = planes.may_rebounce[triangle, np.where(side > 0, 0, 1)]
    common = lit.facet >= 0
    small = areas(corners) < SMALLEST * planes.area
    plain, uncut, others = (
        np.flatnonzero((side != 0) & some) for some in (~searched, searched & common, searched & ~common)
    )
    if len(plain):
        share[plain] = leg.visible(centroids(corners.take(plain, axis=0)), triangle[plain])
    if len(uncut):
        flags = samples.flags(lit.facet[uncut], corners[uncut], triangle[uncut], leg.visible)
        share[uncut] = visible_share(flags, small[uncut])
    if len(others):
        flags = sampled(corners[others], triangle[others], leg.visible)
        share[others] = visible_share(flags, small[others])
    return share


def _past_shadows(lit: Surface, number: int, leg: BodyLeg, area: float) -> Surface:
    """The same triangles with the share that this leg reaches; those that the edge of a shadow crosses are cut."""
    mixed = np.isnan(lit.share[:, number])
    if not mixed.any():
        return lit
    crossed = np.flatnonzero(mixed)
    parts = visible_parts(lit.corners[crossed], lit.triangle[crossed], leg.visible, area, leg.edges)
    result = lit.parts(parts.corners, crossed[parts.origin])
    result.share[:, number] = parts.share
    return lit.chosen(np.flatnonzero(~mixed)).joined(result)


def _past_others(lit: Surface, number: int, leg: BodyLeg) -> Surface:
    """The same triangles, cut at the shadows of other bodies, in which this leg reaches nothing."""
    reached = np.flatnonzero(lit.share[:, number] > 0.0)
    if leg.others is None or not len(leg.others) or not len(reached):
        return lit
    corners, origin, bright = leg.others.cut(lit.corners[reached], leg.on_map)
    if not len(origin):
        return lit
    parts = lit.parts(corners, reached[origin])
    parts.share[~bright, number] = 0.0
    return lit.chosen(np.setdiff1d(np.arange(len(lit)), reached[origin], assume_unique=False)).joined(parts)
