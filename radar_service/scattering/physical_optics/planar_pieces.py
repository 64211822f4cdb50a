"""Convex planar pieces of a mesh: coplanar triangles joined, and their outlines cut into few convex polygons.

A mesh that cuts its planes otherwise has the same pieces. They are one-sided: a surface that may be seen from both sides has two.
Triangles are joined where an edge joins them, and they lie within 0.5 mm and 2 mrad of the largest one. The kernel says how
outlines are cut, and which patches stay triangles.
"""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Floats, Indices
from radar_service.trace import interleaved
from radar_service.world import Mesh

ORDER_BITS = 10  # of each coordinate along the curve by which pieces are sorted
# By bounces, over a sea by four paths: medians of the kernel alone for five hulls of 209 to 272 pieces, coaster, freighter and
# tanker (870 to 2,582) at 4 to 12 azimuths from 1.5 km, on one busy core of 2026; single ones from 0.5 to 1.9 of these
PIECE_SECONDS = {1: 5.8e-6, 2: 11e-6, 3: 18e-6}
FEW_PIECES = 1000  # up to them an aspect takes as long as there are pieces, beyond as the power 1.5 of them
AT_ONCE = 2**18  # pieces that are put in order together: some 50 MB


@dataclass(frozen=True)
class PlanarPieces:
    """Pieces (P,) of a mesh in its frame.

    corner: (C, 3) of all pieces, counterclockwise as seen from where they scatter [m].
    first: (P + 1,) corner of each piece, and the end of the last.
    normal: (P, 3), of unit length.
    patch: (P,) number of the plane that each is a part of: pieces of one do not hide each other.
    """

    corner: Floats
    first: Indices
    normal: Floats
    patch: Indices

    def __post_init__(self) -> None:
        assert self.first.shape == (len(self) + 1,) and self.patch.shape == (len(self),) and self.corner.shape[1:] == (3,)

    def __len__(self) -> int:
        return len(self.normal)

    @classmethod
    def of(cls, mesh: Mesh, outside: NDArray[np.int8]) -> Self:
        """The pieces of a mesh; outside: (F,) as from `outward_side`. Raises MemoryError."""
        corner, first, normal, patch, side = _joined(mesh, outside)
        piece = np.concatenate([np.flatnonzero(side >= 0), np.flatnonzero(side <= 0)])
        turned = np.arange(len(piece)) >= np.count_nonzero(side >= 0)
        middle = np.add.reduceat(corner, first[:-1]) / np.diff(first)[:, None] if len(first) > 1 else np.zeros((0, 3))
        order = np.argsort(_along_curve(middle)[piece], kind="stable")
        piece, turned = piece[order], turned[order]
        begin = np.concatenate([[0], np.cumsum(np.diff(first)[piece])])
        corners = np.empty((begin[-1], 3))
        for low in range(0, len(piece), AT_ONCE):
            part = slice(low, low + AT_ONCE)
            size = np.diff(first)[piece[part]]
            within = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
            within = np.where(np.repeat(turned[part], size), np.repeat(size - 1, size) - within, within)
            corners[begin[low] : begin[low] + len(within)] = corner[np.repeat(first[piece[part]], size) + within]
        facing = normal[piece]
        facing[turned] *= -1.0
        return cls(corners, begin, facing, 2 * patch[piece] + turned)

    @property
    def spans(self) -> Floats:
        """Sides (P, 3) [m] of the box about all pieces of the patch of each."""
        _, patch = np.unique(self.patch, return_inverse=True)
        low, high = np.full((len(self), 3), np.inf), np.full((len(self), 3), -np.inf)
        of_corner = np.repeat(patch, np.diff(self.first))
        np.minimum.at(low, of_corner, self.corner)
        np.maximum.at(high, of_corner, self.corner)
        return np.asarray((high - low)[patch])

    def rotated(self, rotation: Floats) -> Self:
        """The same pieces rotated about the origin by a matrix (3, 3)."""
        return replace(self, corner=self.corner @ rotation.T, normal=self.normal @ rotation.T)


def _joined(mesh: Mesh, outside: NDArray[np.int8]) -> tuple[Floats, Indices, Floats, Indices, NDArray[np.int8]]:
    """Corners, firsts, normals and patches of pieces, and which side of each is outside."""
    faces = len(mesh.faces)
    corner, first = np.empty((3 * faces, 3)), np.empty(faces + 1, dtype=np.int64)
    normal, patch, side = np.empty((faces, 3)), np.empty(faces, dtype=np.int64), np.empty(faces, dtype=np.int8)
    taken = map(np.ascontiguousarray, (mesh.vertices, mesh.faces, outside))
    count = KERNELS.planar_pieces(len(mesh.vertices), faces, *taken, corner, first, normal, patch, side)
    if 2 * count < faces:  # else what is left over is not worth a second copy
        corner, first, normal = corner[: first[count]].copy(), first[: count + 1].copy(), normal[:count].copy()
    return corner[: first[count]], first[: count + 1], normal[:count], patch[:count], side[:count]


def _along_curve(middle: Floats) -> NDArray[np.uint64]:
    """Where points (P, 3) lie along a curve on which neighbours are near each other (Morton 1966)."""
    low = middle.min(axis=0, initial=np.inf)
    extent = max(float((middle.max(axis=0, initial=-np.inf) - low).max(initial=0.0)), 1e-9) if len(middle) else 1.0
    return interleaved(((middle - low) / extent * (2**ORDER_BITS - 1)).astype(np.uint64))


def aspect_seconds(pieces: int, bounces: int) -> float:
    """The predicted time [s] of an aspect by planes of a mesh of so many pieces, on one core. No choice depends on it."""
    return PIECE_SECONDS[min(bounces, 3)] * pieces * math.sqrt(max(1.0, pieces / FEW_PIECES))
