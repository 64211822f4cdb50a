"""Samples at the corners of coarse facets, by which shadows are found first. Facets of one triangle share them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facets import centroids
from radar_service.scattering.physical_optics.shadow_edges import INSET, Visible

MAX_INSET = 5e-3  # m; that of a facet of 4 m, the longest


class CornerSamples(NamedTuple):
    """Samples (S,) at the corners of facets (M,).

    point: (S, 3) in the body's frame, drawn a little from a triangle's edges to its centroid [m].
    triangle: (S,) of the mesh.
    corner: (3, M) the sample at each corner.
    """

    point: Floats
    triangle: Indices
    corner: Indices

    @classmethod
    def of(cls, points: Floats, corner: Indices, triangle: Indices, centre: Floats) -> "CornerSamples":
        """The samples of facets (M,).

        points: (V, 3) [m], each there once; corner: (3, M) index of each corner in them; triangle: (M,) that each facet was cut
        from; centre: (F, 3) of these triangles [m].
        """
        key = corner + len(points) * triangle
        used, index = np.unique(key, return_inverse=True)
        owner, point = used // len(points), points[used % len(points)]
        inward = centre[owner] - point
        length = np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-12)
        return cls(point + inward * np.minimum(INSET, MAX_INSET / length), owner, index.reshape(3, -1))

    @classmethod
    def joined(cls, parts: "Sequence[CornerSamples]") -> "CornerSamples":
        """The samples of several parts of a body."""
        first = np.cumsum([0, *(len(part.triangle) for part in parts)])
        corner = [part.corner + before for part, before in zip(parts, first[:-1], strict=True)]
        point, triangle = (np.concatenate(column) for column in zip(*((p.point, p.triangle) for p in parts), strict=True))
        return cls(point, triangle, np.concatenate(corner, axis=1))

    def rotated(self, rotation: Floats) -> "CornerSamples":
        """The samples of the same body rotated by a matrix (3, 3)."""
        return self._replace(point=self.point @ rotation.T)

    def flags(self, facet: Indices, corners: Floats, triangle: Indices, visible: Visible) -> Flags:
        """Which corners and which centroid (N, 4) of facets (N,) are visible.

        facet: (N,) their numbers; corners: (N, 3, 3) [m]; triangle: (N,) of the mesh.
        """
        index = self.corner.take(facet, axis=1)
        used, index = renumbered(index, len(self.triangle))
        points = np.concatenate([self.point.take(used, axis=0), centroids(corners)])
        seen = visible(points, np.concatenate([self.triangle.take(used), triangle]))
        return np.concatenate([seen[index], seen[None, len(used) :]]).T


def renumbered(index: Indices, count: int) -> tuple[Indices, Indices]:
    """The indices (U,) below `count` that occur in `index`, rising, and the position of each index among them."""
    place, used, number = (
        np.empty(count, dtype=np.int64),
        np.empty(count, dtype=np.int64),
        np.empty(index.size, dtype=np.int64),
    )
    total = KERNELS.renumbered(index.size, count, np.ascontiguousarray(index).reshape(-1), place, used, number)
    return used[:total], number.reshape(index.shape)
