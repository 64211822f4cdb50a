"""A tree of bounding boxes in numpy: the tracer for platforms without Embree, some hundred times slower and as right.

Triangles stand in the order of a space-filling curve (Morton 1966), so that neighbours in it are neighbours in space. Each box
encloses the next WIDTH of the level below. Rays go down level by level, all pairs of a ray and a box at once. Triangles are
those that Embree is given, in float32; each is tested in float64 by `moller_trumbore.watertight_pairs`.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from radar_service.numerics import Flags, Floats, Indices, Singles
from radar_service.trace.moller_trumbore import watertight_pairs
from radar_service.trace.tree_cache import Tree

WIDTH = 4  # boxes or triangles in a box
MAX_PAIRS = 2**15  # of rays and boxes worked on at once, which the L2 cache holds; twice or half as many are slower
MARGIN = 1e-7  # of the size of all triangles, on each box: far more than float64 rounds
TINY = 1e-300  # instead of 0 in a direction, so that 0 / 0 never occurs
BITS = 21  # of each coordinate in a place on the curve


class Boxes(NamedTuple):
    """Axis-aligned boxes (B,): their low and high corners (3, B)."""

    low: Floats
    high: Floats


class Pairs(NamedTuple):
    """Rays (P,) and boxes (P,) of a level that may meet. The last level is that of the triangles.

    enters: (P,) where each ray enters the box around these, in its lengths.
    """

    level: int
    ray: Indices
    box: Indices
    enters: Floats

    def chosen(self, which: Indices) -> "Pairs":
        """The pairs `which` (N,)."""
        return Pairs(self.level, self.ray.take(which), self.box.take(which), self.enters.take(which))


class BoxTree(Tree):
    """Triangles for ray tests, by a tree of boxes."""

    def __init__(self, vertices: Singles, faces: NDArray[np.int32]) -> None:
        """vertices (V, 3) and faces (F, 3)."""
        low, high = (bound(vertices[faces], axis=1).astype(np.float64) for bound in (np.min, np.max))
        self._order = curve_order((low + high) / 2.0)
        self._vertices, self._faces = vertices, faces[self._order]
        margin = MARGIN * float(np.max(high.max(axis=0) - low.min(axis=0)))
        low, high = low[self._order].T - margin, high[self._order].T + margin
        levels = [Boxes(np.ascontiguousarray(low), np.ascontiguousarray(high))]
        while levels[-1].low.shape[1] > WIDTH:
            levels.append(_enclosing(levels[-1]))
        self._levels = levels[::-1]  # from the root to the triangles

    @override
    def first_hit(self, origins: Singles, directions: Singles) -> Indices:
        """Of several triangles at the same distance it takes the one of the lowest index."""
        nearest, triangle = np.full(len(directions), np.inf), np.full(len(directions), -1, dtype=np.int64)
        for ray, index, distance in self._crossings(origins, directions, nearest):
            order = np.lexsort((index, distance, ray))
            ray, index, distance = ray[order], index[order], distance[order]
            best = np.flatnonzero(np.diff(ray, prepend=-1))
            ray, index, distance = ray[best], index[best], distance[best]
            closer = (distance < nearest[ray]) | ((distance == nearest[ray]) & (index < triangle[ray]))
            nearest[ray[closer]], triangle[ray[closer]] = distance[closer], index[closer]
        return triangle

    @override
    def occluded(self, origins: Singles, directions: Singles, reach: Singles) -> Flags:
        left = reach.astype(np.float64)
        occluded = np.zeros(len(directions), dtype=np.bool_)
        for ray, _, _ in self._crossings(origins, directions, left):
            occluded[ray], left[ray] = True, -1.0
        return occluded

    def _crossings(self, origins: Singles, directions: Singles, reach: Floats) -> Iterator[tuple[Indices, Indices, Floats]]:
        """Rays, triangles and distances (N,) of crossings within `reach` (M,), which the caller may shorten meanwhile."""
        origin, direction = origins.astype(np.float64), directions.astype(np.float64)
        lines = np.ascontiguousarray(origin.T), np.ascontiguousarray(1.0 / np.where(direction == 0.0, TINY, direction).T)
        rays, top = np.arange(len(direction)), self._levels[0].low.shape[1]
        left = [Pairs(0, np.repeat(rays, top), np.tile(np.arange(top), len(rays)), np.zeros(len(rays) * top))]
        while left:
            pairs = left.pop()
            if len(pairs.ray) > MAX_PAIRS:
                left += _far_and_near(pairs)
                continue
            pairs = self._entering(pairs, *lines, reach)
            if pairs.level + 1 < len(self._levels):
                left.append(self._children(pairs))
            elif len(pairs.ray):
                corners = self._vertices[self._faces[pairs.box]].astype(np.float64)
                distance = watertight_pairs(origin[pairs.ray], direction[pairs.ray], corners)
                hit = np.flatnonzero((distance <= reach[pairs.ray]) & (distance < np.inf))
                yield pairs.ray[hit], self._order[pairs.box[hit]], distance[hit]

    def _entering(self, pairs: Pairs, origin: Floats, inverse: Floats, reach: Floats) -> Pairs:
        """The pairs whose ray enters the box within its reach; origin and inverse direction of the rays (3, M)."""
        pairs = pairs.chosen(np.flatnonzero(pairs.enters <= reach.take(pairs.ray)))
        boxes = self._levels[pairs.level]
        enters, leaves = np.zeros(len(pairs.ray)), reach.take(pairs.ray)
        for axis in range(3):
            start, slope = origin[axis].take(pairs.ray), inverse[axis].take(pairs.ray)
            at_low = (boxes.low[axis].take(pairs.box) - start) * slope
            at_high = (boxes.high[axis].take(pairs.box) - start) * slope
            np.maximum(enters, np.minimum(at_low, at_high), out=enters)
            np.minimum(leaves, np.maximum(at_low, at_high), out=leaves)
        return pairs._replace(enters=enters).chosen(np.flatnonzero(enters <= leaves))

    def _children(self, pairs: Pairs) -> Pairs:
        count = self._levels[pairs.level + 1].low.shape[1]
        child = (pairs.box[:, None] * WIDTH + np.arange(WIDTH)).ravel()
        ray, enters = np.repeat(pairs.ray, WIDTH), np.repeat(pairs.enters, WIDTH)
        return Pairs(pairs.level + 1, ray, child, enters).chosen(np.flatnonzero(child < count))


def _far_and_near(pairs: Pairs) -> list[Pairs]:
    """Two halves. The nearer one comes last, so it is worked on first, and what it hits shortens rays of the other."""
    order, middle = np.argsort(pairs.enters, kind="stable"), len(pairs.ray) // 2
    return [pairs.chosen(order[middle:]), pairs.chosen(order[:middle])]


def _enclosing(boxes: Boxes) -> Boxes:
    """Boxes around each WIDTH of these in turn."""
    first = np.arange(0, boxes.low.shape[1], WIDTH)
    return Boxes(np.minimum.reduceat(boxes.low, first, axis=1), np.maximum.reduceat(boxes.high, first, axis=1))


def curve_order(points: Floats) -> Indices:
    """The order (N,) of points (N, 3) along the Morton curve through their bounding box."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    cells = ((points - low) / np.maximum(size, 1e-30) * (2**BITS - 1)).astype(np.uint64)
    return np.argsort(interleaved(cells), kind="stable")


def interleaved(cells: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Places (N,) of cells (N, 3), each coordinate below 2^BITS, on the Morton curve: their bits in turn."""
    x, y, z = (_spread_bits(cells[:, axis]) for axis in range(3))
    return np.asarray(x | (y << np.uint64(1)) | (z << np.uint64(2)))


def _spread_bits(value: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Two zeros after each of the lowest 21 bits."""
    steps = (
        (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249)
    )  # fmt: skip
    for shift, mask in steps:
        value = (value | (value << np.uint64(shift))) & np.uint64(mask)
    return value
