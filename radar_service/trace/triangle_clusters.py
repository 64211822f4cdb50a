"""The triangles of a mesh in clusters and groups of clusters, to find the few that a test in space concerns."""

from collections.abc import Callable

import numpy as np

from radar_service.numerics import Flags, Floats, Indices, ResultCache
from radar_service.trace.box_tree import Boxes, curve_order
from radar_service.world import Mesh

CLUSTER, GROUP = 16, 64  # triangles in a cluster, clusters in a group: the boxes of a million triangles take 12 MB
KEPT = 256  # answers to questions
Test = Callable[[Floats], Flags]  # whether the hulls of points (N, P, 3) in the body's frame may concern a question


class TriangleClusters:
    """The triangles of a mesh, in its own frame. Neighbours in the list of triangles should be neighbours in space.

    is_ground: whether the body is land that is not built. kept: triangles that others have chosen, by their question.
    """

    def __init__(self, mesh: Mesh, is_ground: bool = False) -> None:
        self.is_ground = is_ground
        self.kept: ResultCache[bytes, Floats] = ResultCache(KEPT)
        self._vertices, self._faces = mesh.vertices, mesh.faces
        corners = [mesh.vertices[mesh.faces[:, k]].T for k in range(3)]
        fine = _enclosing(np.minimum.reduce(corners), np.maximum.reduce(corners), CLUSTER)
        self._order = curve_order((fine.low + fine.high).T / 2.0)
        clusters = Boxes(fine.low[:, self._order], fine.high[:, self._order])
        groups = _enclosing(*clusters, GROUP)
        self._clusters, self._groups = box_corners(clusters), box_corners(groups)
        self.box: Floats = box_corners(_enclosing(*groups, max(1, len(self._groups))))[0]  # corners (8, 3) around all

    def __len__(self) -> int:
        return len(self._faces)

    @property
    def corners(self) -> Floats:
        """All of them (T, 3, 3) [m]."""
        return np.asarray(self._vertices[self._faces])

    def chosen(self, concerns: Test) -> Floats:
        """The triangles (T, 3, 3) [m] that pass a test. The hull of any set must pass it that has one in it that does."""
        group = np.arange(len(self._groups))
        if len(group) > 1:
            group = group[concerns(self._groups)]
        cluster = _members(group, GROUP, len(self._order))
        cluster = cluster[concerns(self._clusters[cluster])]
        corners = self._vertices[self._faces[_members(self._order[cluster], CLUSTER, len(self._faces))]]
        return np.asarray(corners[concerns(corners)])


def _members(group: Indices, size: int, count: int) -> Indices:
    """The members of groups (N,) of so many, of `count` in all."""
    member = (group[:, None] * size + np.arange(size)).ravel()
    return member[member < count]


def _enclosing(low: Floats, high: Floats, size: int) -> Boxes:
    """Boxes around each `size` boxes of corners (3, N) in turn."""
    first = np.arange(0, low.shape[1], size)
    return Boxes(np.minimum.reduceat(low, first, axis=1), np.maximum.reduceat(high, first, axis=1))


def box_corners(boxes: Boxes) -> Floats:
    """The corners (N, 8, 3) of boxes."""
    ends = np.stack(boxes)
    axes = np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")
    return np.stack([ends[end.ravel(), axis].T for axis, end in enumerate(axes)], axis=2)
