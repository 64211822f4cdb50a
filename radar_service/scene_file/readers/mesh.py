"""Reads mesh files as triangles. Their format checks what they declare and parses them (`formats`); the rest is checked here."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from radar_service.numerics import MAX_COORDINATE, Flags, Floats, Indices
from radar_service.scene_file.readers.file_format import (
    Faces,
    FileBody,
    Format,
    LoadedBody,
    check_face_count,
    check_range,
    refusals,
)
from radar_service.scene_file.readers.formats import examples, format_of
from radar_service.world import Mesh, SceneError, row_marks

FLAT = 1e-3  # m, of a piece off its plane: of two within 2 mm neither shadows the other (trace.occluder)
MAX_BEND = 0.05  # rad between triangles of one piece, however small
MAX_SEARCHED = 1_000_000  # triangles: 3 s of processor time; `check` tells of doubled layers in larger meshes too
MAX_FILE_BYTES = 200 * 2**20
MAX_BODIES = 1000  # in a file
TRIANGLES = 2**18  # at a time


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
    from scipy.sparse import coo_array  # here: few meshes have doubled layers, and it would slow every start
    from scipy.sparse.csgraph import connected_components

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


@dataclass(frozen=True)
class MeshFile:
    """A mesh file that is to be read. scale: metres per unit of the file, up: its axis, by default those of its format."""

    max_bodies: ClassVar[int] = MAX_BODIES
    placed: ClassVar[bool] = False

    content: bytes
    name: str
    location: str
    scale: float | None = None
    up: str | None = None

    def read(self) -> tuple[LoadedBody, ...]:
        """Returns its bodies, in metres and z up.

        `up` "y" maps (x, y, z) to (x, -z, y). Raises SceneError if the file has no usable mesh.
        """
        kind = format_of(self.content, self.name, self.location)
        unit, up = kind.unit if self.scale is None else self.scale, self.up or kind.up
        parts = _parsed(kind, self.content, self.location)
        if not 1 <= len(parts) <= MAX_BODIES:
            raise SceneError(f"{self.location}: the file has {len(parts)} bodies; 1 to {MAX_BODIES} are allowed: divide it")
        check_face_count(sum(len(part.faces) for part in parts), self.location)
        return tuple(_loaded(parts, unit, up, self.location) for _ in range(len(parts)))

    @classmethod
    def examples(cls) -> Iterator["MeshFile"]:
        """Returns a small file of each format whose reader works."""
        return (cls(content, name, "example") for name, content in examples("readers"))


def _loaded(parts: list[FileBody], unit: float, up: str, location: str) -> LoadedBody:
    """Takes the first of some bodies away and returns it, cleaned. unit: metres per unit. Raises SceneError."""
    vertices, faces, name, position = parts.pop(0)
    if len(faces) == 0:
        raise SceneError(f"{location}: the file has no triangles; a mesh needs at least one with an area: export it again")
    check_range(vertices, faces, location)
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices).all(axis=1)).sum())
        raise SceneError(f"{location}: {count} vertices are not finite numbers; correct the file")
    vertices, place = _in_metres(vertices, unit, up), _in_metres(np.array([position]), unit, up)[0]
    if len(vertices) and np.abs(vertices).max() > MAX_COORDINATE:
        raise SceneError(
            f"{location}: a vertex is {np.abs(vertices).max():g} m from the mesh's origin; at most "
            f"{MAX_COORDINATE:g} m are allowed: correct scale"
        )
    points, index = _unique_rows(vertices)
    welded = index[faces]
    del vertices, faces, index  # of an STL, six times as large as what is left
    return _cleaned(points, welded, location)._replace(name=name, position=place if place.any() else None)


def _in_metres(points: Floats, unit: float, up: str) -> Floats:
    """Returns points (N, 3) of a file in metres and z up."""
    points = points if unit == 1.0 else points * unit
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1) if up == "y" else points


def _parsed(kind: Format[Any], content: bytes, location: str) -> list[FileBody]:
    """Returns what a file of this format holds, once it is checked. Raises SceneError."""
    with refusals(kind.name, location):
        kind.check(content, location)
        parsed = kind.parse(content, location)
        parts = parsed if isinstance(parsed, list) else [FileBody(*parsed)]
        return [FileBody(np.asarray(v, float), np.asarray(f, np.int64), str(name), at) for v, f, name, at in parts]


def _cleaned(points: Floats, faces: Faces, location: str) -> LoadedBody:
    """Returns the mesh without duplicate or empty faces and unused vertices. Raises SceneError if no face is left.

    points: (V, 3) [m], each position once.
    """
    valid = _have_area(points, faces)
    if not valid.any():
        raise SceneError(f"{location}: none of the {len(faces)} triangles has an area; export the file again")
    kept = np.flatnonzero(valid)
    first = _unique_faces(faces[kept])
    findings = []
    if len(kept) < len(faces):
        findings.append(f"{len(faces) - len(kept)} triangles without area dropped")
    if len(first) < len(kept):
        findings.append(f"{len(kept) - len(first)} duplicate triangles dropped")
    kept = kept[first]
    edges = numbered_edges(faces[kept])
    copies = flat_copies(points, faces[kept], edges)
    if len(copies):
        findings.append(f"{len(copies)} triangles of faces dropped that repeat others, cut differently")
        kept = np.delete(kept, copies)
        edges = numbered_edges(faces[kept])
    findings.extend(_surface_defects(edges))
    return LoadedBody(Mesh(points, faces).part(kept), tuple(findings))


def _have_area(points: Floats, faces: Faces) -> Flags:
    """Which triangles (F,) have an area beyond rounding."""
    valid, farthest = np.empty(len(faces), dtype=np.bool_), float(np.abs(points).max())
    for first in range(0, len(faces), TRIANGLES):
        part = slice(first, first + TRIANGLES)
        a, b, c = points[faces[part]].transpose(1, 0, 2)
        doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        longest = np.sqrt(np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
        # rounding of float64 coordinates moves a cross product by about longest x 1e-16 x distance from the origin
        valid[part] = doubled_area > 4e-16 * longest * (farthest + longest)
    return valid


def _unique_rows(rows: Floats) -> tuple[Floats, Indices]:
    """Returns the distinct rows in the order in which they first occur, and for each row its index in them."""
    _, first, index = np.unique(row_marks(rows), return_index=True, return_inverse=True)
    if any((column[first][index] != column).any() for column in rows.T):  # two rows share a mark
        _, first, index = np.unique(rows + 0.0, axis=0, return_index=True, return_inverse=True)  # -0.0 and 0.0 are one place
    order = np.argsort(first)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return rows[first[order]], number[index.reshape(-1)]


def _unique_faces(faces: Faces) -> Indices:
    """Returns indices of the faces that do not repeat an earlier one, wound either way.

    Two triangles back to back are one sheet: each reflects on both sides, so both together would have four times its power.
    """
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T[::-1])
    same = (np.diff(corners[order], axis=0) == 0).all(axis=1)
    return np.sort(order[np.concatenate([[True], ~same])])


def _surface_defects(edges: Edges) -> list[str]:
    """Returns in words why the surface is not closed or not wound one way; counts each directed edge and its reverse."""
    count, balance = edges.uses, np.bincount(edges.number, weights=np.where(edges.forward, 1.0, -1.0))
    findings = []
    open_edges = int((count == 1).sum())
    if open_edges:
        findings.append(f"not watertight ({open_edges} open edges)")
    reversed_edges = int(((count == 2) & (balance != 0.0)).sum())
    if reversed_edges:
        findings.append(f"winding inconsistent across {reversed_edges} edges")
    shared_edges = int((count > 2).sum())
    if shared_edges:
        findings.append(f"{shared_edges} edges shared by more than two triangles")
    return findings
