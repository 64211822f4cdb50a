"""Properties of a mesh that are computed once: shared edges, concave sides, outward sides."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radar_service.world.body import Mesh

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

COPLANAR = 1e-6  # rad between normals: over a patch of 100 m a sag of 0.1 mm, a hundredth of a radian of two-way phase
LEVEL = 1e-4  # of the body's size: what rises less above a plane is the plane's own rounding or the sag of a fine mesh
SHEET = 1e-9  # of the volumes that its triangles could span: a closed part with less has only rounding, and is a sheet
DIRECTIONS = 512  # along which the outermost points of a body with more points are searched


def shared_edges(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of edges that coincide, edge i of triangle f (from its corner i to the next) as 3 f + i."""
    ends = np.sort(_welded_edges(mesh)[0], axis=1)
    order = np.lexsort(ends.T)
    same = (np.diff(ends[order], axis=0) == 0).all(axis=1)
    return order[:-1][same], order[1:][same]


def _welded_edges(mesh: Mesh) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Ends (3 F, 2) of all edges, coinciding vertices counted as one, and the triangle of each. There may be millions."""
    _, where = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)  # + 0.0: -0.0 and 0.0 are one position
    welded = where.reshape(-1).astype(np.int32)[mesh.faces]
    ends = np.stack([welded, np.roll(welded, -1, axis=1)], axis=2).reshape(-1, 2)
    return ends, np.repeat(np.arange(len(mesh.faces), dtype=np.int32), 3)


def _parts(ends: NDArray[np.int32], face: NDArray[np.int32], faces: int) -> tuple[NDArray[np.int64], int, NDArray[np.int32]]:
    """Numbers (3 F,) of edges, the same for those that coincide; how many parts there are, and of which each triangle is (F,)."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    edge, uses = np.unique(low.astype(np.int64) * (int(high.max()) + 1) + high, return_inverse=True, return_counts=True)[1:]
    order = np.argsort(edge, kind="stable")
    face_a, face_b = face[order[uses[edge[order]] == 2]].reshape(-1, 2).T
    links = coo_array((np.ones(len(face_a)), (face_a, face_b)), shape=(faces, faces))
    count, part = connected_components(links, directed=False)
    return edge, count, part


def outward_side(mesh: Mesh) -> NDArray[np.int8]:
    """(F,) which side of each triangle is outside: 1 the one its winding faces, -1 the other, 0 where both may be seen.

    Known for parts that are closed: each of their edges runs both ways equally often, and their volume has a sign. Triangles are
    of one part where an edge joins two of them alone, so a fin on a hull, or a crate against it, leaves the hull closed.
    """
    ends, face = _welded_edges(mesh)
    edge, count, part = _parts(ends, face, len(mesh.faces))
    key, place = np.unique(edge * count + part[face], return_inverse=True)
    balance = np.bincount(place, np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0))
    is_open = np.bincount(key % count, balance != 0.0, minlength=count) > 0
    a, b, c = (mesh.vertices[mesh.faces[:, i]] - mesh.vertices.mean(axis=0) for i in range(3))
    across = np.cross(b, c)
    volumes, sizes = np.einsum("ij,ij->i", a, across), np.linalg.norm(a, axis=1) * np.linalg.norm(across, axis=1)
    volume, rounding = (np.bincount(part, v, minlength=count) for v in (volumes, SHEET * sizes))
    side = np.where(is_open | (np.abs(volume) <= rounding), 0.0, np.sign(volume))
    return np.asarray(side[part], dtype=np.int8)


def faces_itself(rises: Flags, outside: NDArray[np.int8]) -> bool:
    """Whether parts of a mesh may face each other; arguments as from `concave_sides` and `outward_side`."""
    return bool((rises[:, 0] & (outside >= 0)).any() or (rises[:, 1] & (outside <= 0)).any())


def is_concave(mesh: Mesh) -> bool:
    """Whether parts of a mesh may face each other, as seen from where a wave may come."""
    return faces_itself(concave_sides(mesh), outward_side(mesh))


def concave_sides(mesh: Mesh) -> Flags:
    """(F, 2) whether any part of the body rises before the front and before the back of each triangle's plane."""
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-300)[:, None]
    outer = _outermost(np.unique(mesh.used_vertices, axis=0))
    own = np.einsum("ij,ij->i", normal, corners[:, 0])
    margin = LEVEL * float(np.linalg.norm(np.ptp(outer, axis=0)))
    result = np.zeros((len(normal), 2), dtype=np.bool_)
    for first in range(0, len(normal), 4096):
        part = slice(first, first + 4096)
        height = normal[part] @ outer.T - own[part, None]
        result[part, 0], result[part, 1] = height.max(axis=1) > margin, height.min(axis=1) < -margin
    return result


def _outermost(points: Floats) -> Floats:
    """The points (V, 3) themselves where they are few, else those outermost in many directions."""
    if len(points) <= DIRECTIONS:
        return points
    turn = np.arange(DIRECTIONS) * np.pi * (3.0 - np.sqrt(5.0))
    up = 1.0 - (2.0 * np.arange(DIRECTIONS) + 1.0) / DIRECTIONS
    level = np.sqrt(1.0 - up * up)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), up], axis=1)
    chosen = [np.argmax(directions[i : i + 8] @ points.T, axis=1) for i in range(0, DIRECTIONS, 8)]
    return np.asarray(points[np.unique(np.concatenate(chosen))])
