"""Rays against triangles in float64, without a tree: the specification's algorithm 1 as printed, and a scale-free one.

Both answer for every ray and every triangle, so they cost rays x triangles: they check Embree and do not replace it. Pairs of a
ray and a triangle serve `trace.box_tree`, which chooses them.
"""

from collections.abc import Callable

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.world import used_rows

Crossings = Callable[[Floats, Floats, Floats], Floats]

PRINTED_EPSILON = 1e-6  # the value of Moeller and Trumbore (1997); the specification prints only the symbol
MAX_PAIRS = 2**18  # ray-triangle pairs worked on at once: about 50 MB of temporaries


def printed_crossings(origin: Floats, direction: Floats, corners: Floats, epsilon: float = PRINTED_EPSILON) -> Floats:
    """Distance (M, F) of each ray to each triangle in lengths of `direction`, inf for a miss, by algorithm 1 as printed.

    origin: (3,) or (M, 3) [m]; direction: (M, 3); corners: (F, 3, 3) vertices of each triangle [m]. The absolute epsilon
    (line 5) drops every triangle of which twice the area seen along the ray is below 1e-6 m^2 (docs/specification.md, errata
    row 12). Source: docs/specification.md#algorithm-1 (Moeller and Trumbore 1997).
    """
    v0 = corners[:, 0]
    e1, e2 = corners[:, 1] - v0, corners[:, 2] - v0  # lines 1, 2
    h = np.cross(direction[:, None], e2)  # line 3
    a = np.einsum("fk,mfk->mf", e1, h)  # line 4
    parallel = np.abs(a) < epsilon  # line 5
    f = np.divide(1.0, a, out=np.zeros_like(a), where=~parallel & (a != 0))  # line 8
    s = np.atleast_2d(origin)[:, None] - v0  # line 9
    u = f * np.einsum("mfk,mfk->mf", np.broadcast_to(s, h.shape), h)  # line 10
    q = np.cross(s, e1)  # line 14
    v = f * np.einsum("mk,mfk->mf", direction, np.broadcast_to(q, h.shape))  # line 15
    t = f * np.einsum("fk,mfk->mf", e2, np.broadcast_to(q, h.shape))  # line 19
    inside = (u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (u + v <= 1.0)  # lines 11, 16
    return np.where(inside & ~parallel & (t > epsilon), t, np.inf)  # line 20


def watertight_crossings(origin: Floats, direction: Floats, corners: Floats) -> Floats:
    """The same by edge functions about the ray: no epsilon, so it works at any scale, and shared edges do not leak.

    Shapes as `printed_crossings`. Two triangles that share an edge compute the same products for it with opposite sign, so
    a ray is on one side or the other or on it, never beside both. Source: Woop, Benthin and Wald, JCGT 2 (2013).
    """
    return _watertight(corners[None] - np.broadcast_to(origin, direction.shape)[:, None, None], direction)


def watertight_pairs(origin: Floats, direction: Floats, corners: Floats) -> Floats:
    """The same for each ray and one triangle of its own: distances (M,). origin, direction: (M, 3); corners: (M, 3, 3)."""
    return _watertight((corners - origin[:, None])[:, None], direction)[:, 0]


def _watertight(moved: Floats, direction: Floats) -> Floats:
    """Distances (M, F) of rays (M, 3) to triangles, whose corners `moved` (M, F, 3, 3) are relative to the rays' origins."""
    x, y, along = _sheared(moved, direction)
    u = x[2] * y[1] - y[2] * x[1]
    v = x[0] * y[2] - y[0] * x[2]
    w = x[1] * y[0] - y[1] * x[0]
    same_side = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0))
    area = u + v + w
    t = np.divide(u * along[0] + v * along[1] + w * along[2], area, out=np.full_like(area, -1.0), where=area != 0)
    return np.where(same_side & (t > 0.0), t, np.inf)


def _sheared(moved: Floats, direction: Floats) -> tuple[Floats, Floats, Floats]:
    """Corners (M, F, 3, 3) seen along each ray: two coordinates across it and the depth in its lengths, each (3, M, F).

    Written element by element: a dot product may round differently from lane to lane, and then edges would leak.
    """
    depth = np.argmax(np.abs(direction), axis=1)
    corners = np.moveaxis(moved, (2, 3), (0, 1))
    rays = np.arange(len(direction))
    far, far_direction = corners[:, depth, rays], direction[rays, depth]
    across = []
    for turn in (1, 2):
        axis = (depth + turn) % 3
        slope = direction[rays, axis] / far_direction
        across.append(corners[:, axis, rays] - far * slope[:, None])
    return across[0], across[1], far / far_direction[:, None]


class TriangleList:
    """Triangles tested one by one, with the interface of `trace.embree.TriangleScene` and either of the two tests above."""

    def __init__(self, vertices: Floats, faces: Indices, crossings: Crossings = printed_crossings) -> None:
        used = used_rows(vertices, faces)
        self.centre: Floats = (used.min(axis=0) + used.max(axis=0)) / 2.0
        self.radius = float(np.linalg.norm(used - self.centre, axis=1).max())
        self._corners, self._crossings = vertices[faces], crossings

    def first_hit(self, origin: Floats, direction: Floats) -> Indices:
        """Index of the nearest triangle that each ray meets, -1 where none. origin (3,) or (M, 3), direction (M, 3)."""
        return self._nearest(origin, direction)[0]

    def hit_distance(self, triangle: Indices, origin: Floats, direction: Floats) -> Floats:
        """Where each ray (M,) meets the plane of its own triangle, in lengths of `direction`; inf where parallel."""
        corners = self._corners[triangle]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = np.einsum("ij,ij->i", normal, direction)
        toward = np.einsum("ij,ij->i", normal, corners[:, 0] - origin)
        distance: Floats = np.divide(toward, along, out=np.full(len(along), np.inf), where=along != 0)
        return distance

    def _nearest(self, origin: Floats, direction: Floats) -> tuple[Indices, Floats]:
        best = np.full(len(direction), np.inf)
        index = np.full(len(direction), -1, dtype=np.int64)
        rows = max(1, MAX_PAIRS // max(1, min(len(self._corners), MAX_PAIRS)))
        origins = np.broadcast_to(origin, direction.shape)
        for ray in range(0, len(direction), rows):
            some = slice(ray, ray + rows)
            for face in range(0, len(self._corners), MAX_PAIRS):
                t = self._crossings(origins[some], direction[some], self._corners[face : face + MAX_PAIRS])
                nearest = t.argmin(axis=1)
                distance = np.take_along_axis(t, nearest[:, None], axis=1)[:, 0]
                closer = distance < best[some]
                index[some] = np.where(closer, face + nearest, index[some])
                best[some] = np.where(closer, distance, best[some])
        return index, best
