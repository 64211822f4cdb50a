"""The facets of a body, coarse and fine: shadows are found on coarse ones, phases are integrated over fine ones."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.body_columns import BodyColumn
from radar_service.scattering.physical_optics.corner_samples import CornerSamples, renumbered
from radar_service.scattering.physical_optics.facets import cut_facets, cut_triangles
from radar_service.scattering.physical_optics.lit_facets import Surface
from radar_service.world.body import Mesh

SHADOW_EDGE = 4.0  # m; shadows are sampled at a pitch of 2 m at least


class FineFacets(NamedTuple):
    """Fine facets (K,) cut from triangles of a surface.

    origin: (K,) the triangle that each comes from.
    corner: (3, K) index of each corner in `points`; facets that meet share them.
    points: (V, 3) [m].
    """

    origin: Indices
    corner: Indices
    points: Floats


@dataclass(frozen=True)
class BodyFacets:
    """Coarse facets (M,) and the fine ones that they consist of (N,).

    surface: the coarse facets.
    fine: (3, N) index of the fine ones' corners in `points`, in the order of the coarse ones.
    points: (V, 3) [m].
    first: (M + 1,) index of the first fine one of each coarse one, and their number.
    samples: at the corners of the coarse ones.
    """

    surface: Surface
    fine: Indices
    points: Floats
    first: Indices
    samples: CornerSamples

    @classmethod
    def joined(cls, parts: "Sequence[BodyFacets]") -> "BodyFacets":
        """The facets of several parts of a body."""
        if len(parts) == 1:
            return parts[0]
        surface = parts[0].surface
        for part in parts[1:]:
            surface = surface.joined(part.surface)
        counts = np.concatenate([np.diff(part.first) for part in parts])
        surface = replace(surface, facet=np.arange(len(surface)))
        offset = _starts(np.array([len(part.points) for part in parts]))[:-1]
        fine = np.concatenate([part.fine + before for part, before in zip(parts, offset, strict=True)], axis=1)
        samples = CornerSamples.joined([part.samples for part in parts])
        return cls(surface, fine, np.concatenate([part.points for part in parts]), _starts(counts), samples)

    def rotated(self, rotation: Floats) -> "BodyFacets":
        """The facets of the same body rotated by a matrix (3, 3)."""
        surface = replace(self.surface, corners=self.surface.corners @ rotation.T)
        return replace(self, surface=surface, points=self.points @ rotation.T, samples=self.samples.rotated(rotation))

    def cut(self, surface: Surface) -> FineFacets:
        """The fine facets of triangles of the body."""
        uncut, parts = np.flatnonzero(surface.facet >= 0), np.flatnonzero(surface.facet < 0)
        facet = surface.facet[uncut]
        counts = self.first[facet + 1] - self.first[facet]
        begin = np.repeat(self.first[facet] - _starts(counts)[:-1], counts)
        used, corner = renumbered(self.fine.take(begin + np.arange(len(begin)), axis=1), len(self.points))
        cut, origin = cut_triangles(surface.corners[parts], surface.longest[parts])
        more, points = welded(cut)
        return FineFacets(
            np.concatenate([np.repeat(uncut, counts), parts[origin]]),
            np.concatenate([corner, more + len(used)], axis=1),
            np.concatenate([self.points.take(used, axis=0), points]),
        )


def body_facets(column: BodyColumn, cell: float, edge: float) -> BodyFacets:
    """The facets of a column, summed in cells of size `cell` [m]: coarse ones with edges of at most SHADOW_EDGE, fine ones with
    edges of at most `edge` [m]."""
    coarse, origin = cut_triangles(column.mesh.vertices[column.mesh.faces], SHADOW_EDGE)
    count = len(coarse)
    mesh = Mesh(coarse.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
    fine = cut_facets(mesh, edge)
    none = np.zeros((count, 0))
    sizes = np.full(count, cell)
    longest = np.full(count, edge * fine.enlargement)
    surface = Surface(coarse, column.triangle[origin], np.arange(count), sizes, longest, none.astype(np.int8), none)
    corner, points = welded(coarse)
    samples = CornerSamples.of(points, corner, origin, column.mesh.vertices[column.mesh.faces].mean(axis=1))
    samples = samples._replace(triangle=column.triangle[samples.triangle])
    return BodyFacets(surface, *welded(fine.corners), _starts(np.bincount(fine.triangle, minlength=count)), samples)


def welded(corners: Floats) -> tuple[Indices, Floats]:
    """Indices (3, M) of the corners of triangles (M, 3, 3) in points (V, 3), each of which is there once.

    Corners are the same where all their bits are: halves of an edge that two triangles share have the same middle.
    """
    number, points = np.empty((3, len(corners)), dtype=np.int64), np.empty((3 * len(corners) + 1, 3))
    return number, points[: KERNELS.welded(len(corners), np.ascontiguousarray(corners), number, points)]


def _starts(counts: Indices) -> Indices:
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
