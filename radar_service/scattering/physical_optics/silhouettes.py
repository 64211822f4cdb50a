"""Silhouettes of triangles as the antenna sees them: where their shadows may end, but for those that other shadows cover."""

from typing import NamedTuple, Self

import numpy as np

from radar_service.kernels.library import kernels
from radar_service.numerics.types import Flags, Floats

ON_PLANE = 1e-6  # m from a plane within which points count as on it
SAME_POINT = 1e-5  # m within which corners of triangles are one
GRAZING = 1e-9  # rad outside a triangle up to which it covers a silhouette
ALONG = 1e-5  # rad off the side of a triangle up to which a silhouette lies along it: `SAME_POINT` from 0.5 m on
WIDER = 1e-8  # by which extents in a view are wider


class Extents(NamedTuple):
    """The lowest and the highest numbers (N, 2) aside and up of what lies in a `View`."""

    low: Floats
    high: Floats

    def overlap(self, other: Self) -> Flags:
        """Which of these (N,) and of others (M,) overlap (N, M)."""
        below = (self.low[:, None] <= other.high).all(axis=2)
        return np.asarray(below & (other.low <= self.high[:, None]).all(axis=2))


class View(NamedTuple):
    """What the antenna sees about a direction: unit vectors (3,) there, aside and up. Numbers aside and up are those at which
    there ahead is 1."""

    ahead: Floats
    aside: Floats
    up: Floats

    @classmethod
    def to(cls, points: Floats) -> Self:
        """The view about the middle of points (N, 3) at virtual positions."""
        (ahead,) = _unit(points.sum(axis=0)[None])
        upright = np.array([1.0, 0.0, 0.0]) if ahead[0] ** 2 + ahead[1] ** 2 < 1e-6 else np.array([0.0, 0.0, 1.0])
        (aside,) = _unit(np.cross(ahead, upright)[None])
        return cls(ahead, aside, np.cross(aside, ahead))

    def extents(self, directions: Floats, wider: float = 0.0) -> Extents:
        """Of what lies between directions (N, P, 3) each; without bounds where one of these does not point ahead."""
        ahead = directions @ self.ahead
        beside = ahead.min(axis=1, keepdims=True) <= 0.0
        at = np.stack([directions @ self.aside, directions @ self.up], axis=2) / np.where(ahead > 0.0, ahead, 1.0)[..., None]
        low, high = at.min(axis=1) - wider, at.max(axis=1) + wider
        return Extents(np.where(beside, -np.inf, low), np.where(beside, np.inf, high))


def ends(silhouettes: Floats) -> Floats:
    """Directions (E, 2, 3) of the ends of silhouettes by their planes (E, 4, 3)."""
    begin, end = np.cross(silhouettes[:, 1], silhouettes[:, 0]), np.cross(silhouettes[:, 0], silhouettes[:, 2])
    return np.stack([begin, end], axis=1)


def silhouettes(corners: Floats) -> tuple[Floats, Floats]:
    """Planes (E, 4, 3) and offsets (E, 4) [m] of edges of triangles (T, 3, 3) about the antenna at which a shadow may end: those
    from which all triangles lie on one side.

    The first plane leads through the antenna and the edge. The others bound what is behind the edge: they stand across the
    first one at both ends, and across the rays; their normals point to it.
    """
    if compiled := kernels():
        planes, offsets = np.empty((3 * len(corners), 4, 3)), np.empty((3 * len(corners), 4))
        count = compiled.run("silhouettes", len(corners), np.ascontiguousarray(corners), planes, offsets)
        return planes[:count], offsets[:count]
    points, number = np.unique(np.round(corners.reshape(-1, 3) / SAME_POINT), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    ends = np.sort(np.concatenate([number[:, [0, 1]], number[:, [1, 2]], number[:, [2, 0]]]), axis=1)
    third = corners[:, [2, 0, 1]].transpose(1, 0, 2).reshape(-1, 3)
    edge, index = np.unique(ends[:, 0] * len(points) + ends[:, 1], return_inverse=True)
    a, b = (points[end] * SAME_POINT for end in (edge // max(1, len(points)), edge % max(1, len(points))))
    normal = _unit(np.cross(a, b))
    side = np.einsum("ex,ex->e", normal[index], third)
    has_left, has_right = (
        np.bincount(index[flags], minlength=len(edge)) > 0 for flags in (side > ON_PLANE, side < -ON_PLANE)
    )
    ahead = _unit(a + b)
    nearest = np.minimum(np.einsum("ex,ex->e", a, ahead), np.einsum("ex,ex->e", b, ahead))
    plane = np.stack([normal, _unit(np.cross(normal, a)), _unit(np.cross(b, normal)), ahead], axis=1)
    offset = np.concatenate([np.zeros((len(a), 3)), nearest[:, None]], axis=1)
    ending = ~(has_left & has_right) & normal.any(axis=1)
    return plane[ending], offset[ending]


def is_covered(silhouette: Floats, shadows: Floats) -> bool:
    """Whether shadows lie on both sides of a silhouette all along it, where all of them lie before what it may cut.

    silhouette: planes (4, 3), as of `silhouettes`; shadows: planes (T, 4, 3) of triangles, as of `CastShadows`.
    """
    ((begin, end),) = ends(silhouette[None])
    start, stop = shadows[:, :3] @ begin, shadows[:, :3] @ end
    along = (np.abs(start) < ALONG) & (np.abs(stop) < ALONG)
    start, stop = start + GRAZING, stop + GRAZING
    crossing = np.divide(start, start - stop, out=np.zeros_like(start), where=start != stop)
    low = np.where(start < 0.0, crossing, 0.0).max(axis=1, initial=0.0)
    high = np.where(stop < 0.0, crossing, 1.0).min(axis=1, initial=1.0)
    within = np.flatnonzero((low < high) & ~along.any(axis=1) & ~((start < 0.0) & (stop < 0.0)).any(axis=1))
    reached = 0.0
    for number in within[np.argsort(low[within])].tolist():
        if low[number] > reached:
            return False
        reached = max(reached, float(high[number]))
    return reached >= 1.0


def _unit(vectors: Floats) -> Floats:
    """Vectors (N, 3) of length 1; those shorter than 1e-9 become 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 1e-9))
