"""Flat pieces of a mesh that lie on one another: the same face twice, cut into triangles along other lines.

Both reflect, 6 dB too much. Such pieces have the same boundary, so they are found without the geometry of their overlap. A piece
is made of triangles that continue each other across edges which nothing else meets in their plane.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radar_service.numerics.types import Flags, Floats, Indices

Faces = Indices

FLAT = (
    1e-3  # m, of a piece off its plane: two pieces so flat are within 2 mm, where neither shadows the other (trace.occluder)
)
MAX_BEND = 0.05  # rad between triangles of one piece, however small
MAX_SEARCHED = 1_000_000  # triangles: 3 s of processor time; `check` tells of doubled layers in larger meshes too


class Edges(NamedTuple):
    """The edges of triangles, edge i of triangle f as 3 f + i.

    number: (3 F,) the same for edges with the same ends.
    forward: (3 F,) whether it runs from the end of the lower index.
    uses: (E,) of each number.
    """

    number: Indices
    forward: Flags
    uses: Indices


def numbered_edges(faces: Faces) -> Edges:
    """Returns the edges of faces (F, 3)."""
    begin, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    forward, key = begin < end, np.minimum(begin, end) * (int(faces.max()) + 1) + np.maximum(begin, end)
    del begin, end  # of millions of triangles they take as much memory as the sort
    _, number, uses = np.unique(key, return_inverse=True, return_counts=True)
    return Edges(number.ravel(), forward, uses)


def flat_copies(points: Floats, faces: Faces, edges: Edges) -> Indices:
    """Returns the indices of the triangles of each flat piece that has the same boundary as an earlier one, wound either way.

    points: (V, 3) [m], each position once; faces: (F, 3), no two with the same corners; edges: of them.
    """
    if len(faces) > MAX_SEARCHED or not _may_overlap(points, faces, edges):
        return np.zeros(0, dtype=np.int64)
    line, side = _lines_at_edges(points, faces, edges)
    order = np.lexsort((side, line))
    across = (np.diff(line[order]) == 0) & (np.diff(side[order].astype(np.int8)) != 0)
    linked = np.flatnonzero(across & (np.bincount(line)[line[order][:-1]] == 2))
    face, next_face = order[linked] // 3, order[linked + 1] // 3
    links = coo_array((np.ones(len(face)), (face, next_face)), shape=(len(faces), len(faces)))
    count, label = connected_components(links, directed=False)
    piece = label.astype(np.int64)
    copied = _repeats_boundary(edges.number, np.repeat(piece, 3), count) & _is_flat(points, faces, piece, count)
    return np.flatnonzero(copied[piece])


def _may_overlap(points: Floats, faces: Faces, edges: Edges) -> bool:
    """Whether an edge has more than two triangles, or two of which one is folded back onto the other.

    Normals that turn with the direction of the edge add up over it: to twice the sine of half the bend, 2 where they are folded.
    """
    if (edges.uses > 2).any():
        return True
    a, b, c = points[faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    turned = np.where(edges.forward, 1.0, -1.0)
    total = [np.bincount(edges.number, turned * np.repeat(part, 3)) for part in normal.T]
    return bool((np.sum(np.square(total), axis=0) > (2.0 * np.cos(MAX_BEND / 2.0)) ** 2).any())


def _lines_at_edges(points: Floats, faces: Faces, edges: Edges) -> tuple[Faces, Flags]:
    """For each edge (3 F,) of a triangle: the number of the line across the edge along which the triangle lies, and on which side
    of the edge it does. Triangles that continue each other, or lie on each other, have one line."""
    begin, end, third = faces.ravel(), np.roll(faces, -1, axis=1).ravel(), np.roll(faces, -2, axis=1).ravel()
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    along = points[high] - points[low]
    along /= np.linalg.norm(along, axis=1)[:, None]
    away = points[third] - points[low]
    away -= np.einsum("ij,ij->i", away, along)[:, None] * along
    height = np.linalg.norm(away, axis=1)
    first = np.zeros(len(edges.uses), dtype=np.int64)
    first[edges.number] = np.arange(len(third))
    reference = (away / height[:, None])[first[edges.number]]
    sine = np.einsum("ij,ij->i", np.cross(along, reference), away)
    angle = np.arctan2(sine, np.einsum("ij,ij->i", reference, away))
    side, turn = np.divmod(angle + MAX_BEND, np.pi)  # so that the line of the reference is not where turns begin anew
    slack = np.minimum(FLAT / height, MAX_BEND)
    order = np.lexsort((turn, edges.number))
    near = np.diff(turn[order]) <= np.minimum(slack[order][1:], slack[order][:-1])
    line = np.zeros_like(order)
    line[order] = np.cumsum(np.append(False, ~near | (np.diff(edges.number[order]) != 0)))
    return line, side == 0.0


def _repeats_boundary(edge: Faces, piece: Faces, count: int) -> Flags:
    """Which pieces (count,) have the same edges once as an earlier piece. edge, piece: of each edge of each triangle (3 F,)."""
    key, uses = np.unique(piece * (int(edge.max()) + 1) + edge, return_counts=True)
    owner, border = np.divmod(key[uses == 1], int(edge.max()) + 1)
    mark = np.random.default_rng(0).integers(2**63, size=int(edge.max()) + 1)  # of an edge: sums of them tell sets apart
    total, number = np.zeros(count, dtype=np.int64), np.bincount(owner, minlength=count)
    np.add.at(total, owner, mark[border])
    _, first, same = np.unique(np.stack([total, number], axis=1), axis=0, return_index=True, return_inverse=True)
    return np.asarray((first[same.ravel()] != np.arange(count)) & (number > 0))


def _is_flat(points: Floats, faces: Faces, piece: Faces, count: int) -> Flags:
    """Which pieces (count,) lie within FLAT of the plane of their largest triangle."""
    a, b, c = points[faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    order = np.lexsort((area, piece))
    largest = order[np.append(np.diff(piece[order]) != 0, True)][piece]
    off = np.einsum("fki,fi->fk", points[faces] - a[largest][:, None], normal[largest] / area[largest][:, None])
    result = np.zeros(count)
    np.maximum.at(result, piece, np.abs(off).max(axis=1))
    return result <= FLAT
