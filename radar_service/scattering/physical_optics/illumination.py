"""What legs reach of a body, as traced at one pose, and the same at another pose near by, without a ray.

Which facets are lit, where shadows end on them, where they are cut, which tubes count and where these hit is kept, in the body's
own frame. Fields, lengths, the waterline and where tubes are projected to are computed anew. So that there is something to cut
at the waterline, bodies are traced a little higher than they float (`lift`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.corner_samples import renumbered
from radar_service.scattering.physical_optics.lit_facets import LitFacets, Planes
from radar_service.scattering.physical_optics.own_shadows import UPRIGHT
from radar_service.scattering.physical_optics.ray_tubes import Launch, RayTubes, by_axis, dot
from radar_service.scattering.physical_optics.triangle_cuts import AT_LEVEL, above_water
from radar_service.scattering.physical_optics.tube_tracing import GRAZING


class KeptTubes(NamedTuple):
    """Tubes (M,) that leave by one leg and return by another.

    ways: how many of the two go by the sea, as the path is numbered. out, back: numbers of the legs.
    corners: (3, 3, M) on the first surface, by corner and axis, in the body's own frame [m].
    chain: as of `RayTubes`. share, cell: as of `Launch`. factor: (M,) how often each counts, with what its surfaces reflect.
    """

    ways: int
    out: int
    back: int
    corners: Floats
    chain: Indices
    share: Floats
    cell: Floats
    factor: Floats

    @classmethod
    def of(cls, tubes: RayTubes, planes: Planes, lean: Floats | None, ways: int, back: int, factor: Floats) -> Self:
        """Tubes where they end, all by one leg out; lean: of the frame that they are in."""
        out = int(tubes.launch.leg[tubes.launched[0]]) if len(tubes) else 0
        corners = _launch_corners(tubes, planes)
        corners = corners if lean is None else np.einsum("ki,ckm->cim", lean, corners)
        share, cell = tubes.launch.share.take(tubes.launched), tubes.launch.cell.take(tubes.launched)
        return cls(ways, out, back, corners, tubes.chain, share, cell, factor)

    def traced(
        self, planes: Planes, lean: Floats | None, legs: Sequence[BodyLeg], polarization: str, water: float
    ) -> RayTubes:
        """The tubes where they end, for legs at another pose. water: height of the sea [m]: those count whose middles
        leave and end above it."""
        leg, count = legs[self.out], self.corners.shape[2]
        corners, middle = np.empty((3, 3, count)), np.empty((count, 3))
        turn = UPRIGHT if lean is None else np.ascontiguousarray(lean)
        KERNELS.turned_corners(count, np.ascontiguousarray(self.corners), turn, corners, middle)
        rays, share = leg.rays(middle), np.array(self.share)
        vectors, length = np.empty((6, 3, count)), np.empty(count)
        bounces, last = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
        taken = map(np.ascontiguousarray, (self.chain, planes.point, planes.normal, *rays[1:5], rays.length))
        KERNELS.kept_tubes(
            count,
            len(self.chain),
            polarization == "h",
            water,
            *taken,
            middle,
            corners,
            share,
            *vectors,
            length,
            bounces,
            last,
        )
        outward, polarized, centre, normal, direction, field = vectors
        launch = self._launch(outward, polarized, share)
        return RayTubes(
            launch, np.arange(count), corners, centre, normal, last, direction, field, length, by_axis(middle), rays.length,
            bounces, self.chain,
        )  # fmt: skip

    def _launch(self, outward: Floats, polarized: Floats, share: Floats) -> Launch:
        """Where the tubes start; arguments: the first columns of `Launch`, and the share."""
        count, first = len(share), self.chain[0]
        return Launch(outward, polarized, np.full(count, self.out), share, self.cell, np.zeros(count), first, first)


@dataclass(frozen=True)
class Illumination:
    """What legs reach of a body, in its own frame.

    points: (V, 3) [m]; corner, triangle, cell, side, share: as of `LitFacets`. tubes: those that count.
    """

    points: Floats
    corner: Indices
    triangle: Indices
    cell: Floats
    side: NDArray[np.int8]
    share: Floats
    tubes: tuple[KeptTubes, ...]

    @classmethod
    def of(cls, lit: LitFacets, lean: Floats | None, tubes: Sequence[KeptTubes]) -> Self:
        """Of lit facets in a frame that leans by `lean`."""
        points = lit.points if lean is None else lit.points @ lean
        return cls(points, lit.corner, lit.triangle, lit.cell, lit.side, lit.share, tuple(tubes))

    def facets(self, planes: Planes, lean: Floats | None, legs: Sequence[BodyLeg], water: float) -> LitFacets:
        """The lit facets above the sea, whose height is `water` [m], for legs at another pose."""
        points = self.points if lean is None else self.points @ lean.T
        origin, corner, points = _above_water(points, self.corner, water)
        triangle, cell = self.triangle.take(origin), self.cell.take(origin)
        side, share = self.side.take(origin, axis=0), self.share.take(origin, axis=0)
        return lit_facets(points, corner, triangle, cell, side, share, planes, legs)


def lift(vertices: Floats, position: Floats, rotation: Floats) -> float:
    """By how much a body must be lifted, as it is at the first of K instants, so that whatever is above the sea at any of the
    others is above it then [m]; 0 for one that the sea does not wet.

    vertices: (V, 3) in its own frame; position: (K, 3) and rotation: (K, 3, 3) map_from_body at each instant.
    """
    ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    box = np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)
    height = position[:, 2] + box @ rotation[:, 2].T
    return 0.0 if height.min() > 0.0 else max(0.0, float((height - height[:, :1]).max()))


def _above_water(points: Floats, corner: Indices, water: float) -> tuple[Indices, Indices, Floats]:
    """The parts of facets with corners (3, M) among points (V, 3) that rise above the sea: the facet that each comes from (N,),
    its corners (3, N), and the points that these are among. Those of parts of a facet are new."""
    dry, crossed = _dry_and_crossed(points, corner, water - AT_LEVEL)
    if len(dry) == corner.shape[1]:
        return dry, corner, points
    parts, origin = above_water(points[corner[:, crossed].T], water)
    used, dry_corner = renumbered(corner[:, dry], len(points))
    new = len(used) + np.arange(3 * len(parts)).reshape(-1, 3).T
    corners = np.concatenate([dry_corner, new], axis=1)
    return np.concatenate([dry, crossed[origin]]), corners, np.concatenate([points[used], parts.reshape(-1, 3)])


def _dry_and_crossed(points: Floats, corner: Indices, level: float) -> tuple[Indices, Indices]:
    """Which facets have no corner below a level [m], and which have some; arguments as of `_above_water`."""
    count, crossings = corner.shape[1], np.zeros(1, dtype=np.int64)
    dry, crossed = np.empty((2, count), dtype=np.int64)
    taken = np.ascontiguousarray(points), np.ascontiguousarray(corner)
    return dry[: KERNELS.dry_facets(count, *taken, level, dry, crossed, crossings)], crossed[: crossings[0]]


def lit_facets(
    points: Floats, corner: Indices, triangle: Indices, cell: Floats, side: NDArray[np.int8], share: Floats, planes: Planes,
    legs: Sequence[BodyLeg],
) -> LitFacets:  # fmt: skip
    """Facets with the rays of legs; arguments as of `LitFacets`."""
    edges, centre, area = _shapes(points, corner)
    rays, lengths = tuple(leg.rays(centre) for leg in legs), tuple(leg.length(points) for leg in legs)
    normal = by_axis(planes.normal).take(triangle, axis=1)
    return LitFacets(corner, points, edges, area, normal, triangle, cell, side, share, rays, lengths)


def _shapes(points: Floats, corner: Indices) -> tuple[Floats, Floats, Floats]:
    """Edges (3, 3, M) as of `LitFacets`, centroids (M, 3) [m], and areas (M,) [m^2] of facets."""
    count = corner.shape[1]
    shapes = np.empty((3, 3, count)), np.empty((count, 3)), np.empty(count)
    KERNELS.facet_shapes(count, np.ascontiguousarray(points), np.ascontiguousarray(corner), *shapes)
    return shapes


def _launch_corners(tubes: RayTubes, planes: Planes) -> Floats:
    """Corners (3, 3, M) of tubes projected back to the first surface: each reflection is its own inverse."""
    corners, direction = tubes.corners, tubes.direction
    for number in range(len(tubes.chain) - 1, 0, -1):
        on = np.flatnonzero(tubes.chain[number] >= 0)
        if not len(on):
            continue
        triangle = tubes.chain[number - 1, on]
        normal = by_axis(planes.normal.take(triangle, axis=0))
        travel = _travel(corners[:, :, on], planes, triangle, normal, direction[:, on])
        corners = _with(corners, on, corners[:, :, on] + travel[:, None] * direction[:, on])
        turned = direction[:, on] - 2.0 * dot(normal, direction[:, on]) * normal
        direction = _with(direction, on, turned)
    return corners


def _travel(corners: Floats, planes: Planes, triangle: Indices, normal: Floats, direction: Floats) -> Floats:
    """How far corners (3, 3, M) are from planes of triangles (M,) along directions (3, M), signed (3, M) [m]."""
    point = by_axis(planes.point.take(triangle, axis=0))
    along = dot(normal, direction)
    along = np.where(np.abs(along) < GRAZING, np.copysign(GRAZING, along), along)
    return np.asarray((dot(point, normal) - dot(corners.transpose(1, 0, 2), normal[:, None])) / along)


def _with(values: Floats, on: Indices, changed: Floats) -> Floats:
    """Values (..., M) with others in columns `on`."""
    result = values.copy()
    result[..., on] = changed
    return result
