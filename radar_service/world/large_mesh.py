"""Meshes with millions of triangles: slices of them, marks of positions, and whether they are closed, without sorted edges."""

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats
from radar_service.world.body import Mesh

MAX_JUDGED, SLICES = 300_000, 16  # triangles that remarks judge, some 3 s of processor time; slices that have as many in all
FACTOR = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits without a pattern: 2^64 over the golden ratio
Marks = NDArray[np.uint64]


def mesh_sample(mesh: Mesh) -> Mesh:
    """Returns a mesh of at most MAX_JUDGED triangles as it is; of a larger one as many, in slices across its longest axis."""
    if len(mesh.faces) <= MAX_JUDGED:
        return mesh
    axis, size = int(np.ptp(mesh.vertices, axis=0).argmax()), MAX_JUDGED // SLICES
    order = np.argsort(mesh.vertices[mesh.faces[:, 0], axis])
    first = np.linspace(0, len(order) - size, SLICES).astype(np.int64)
    return mesh.part(order[(first[:, None] + np.arange(size)).ravel()])


def outward_winding(mesh: Mesh) -> int:
    """Returns the side of its triangles that is outside if all of a mesh is closed: 1 the one their winding faces, -1 the other.

    0 where a part may be open. Each edge of a closed mesh runs both ways equally often, so marks of all edges, with the sign of
    their direction, add up to 0.
    """
    marks, total = row_marks(mesh.vertices), 0
    for i in range(3):
        begin, end = marks[mesh.faces[:, i]], marks[mesh.faces[:, i - 2]]
        edge, rises = _mixed(begin ^ end), begin < end
        total += int(edge[rises].sum()) - int(edge[~rises].sum())
    if total % 2**64:
        return 0
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return int(np.sign(np.einsum("ij,ij->", a, np.cross(b, c))))


def row_marks(rows: Floats) -> Marks:
    """Returns 64 bits (N,) for each of rows (N, K), the same for equal rows, whatever the sign of 0.

    Of 10 million different rows two have the same in 1 of 400,000 cases.
    """
    total = np.zeros(len(rows), dtype=np.uint64)
    for column in rows.T:
        total = _mixed(total ^ (column + 0.0).view(np.uint64))
    return total


def _mixed(values: Marks) -> Marks:
    """Whole numbers (N,) with all of their bits mixed, different ones differently."""
    spread = (values ^ (values >> np.uint64(29))) * FACTOR
    return np.asarray(spread ^ (spread >> np.uint64(32)))
