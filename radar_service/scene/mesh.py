"""Mesh files to triangles: OBJ (by `obj`), STL, PLY and GLB (by trimesh, which nothing else imports).

trimesh is given bytes, never a path, so that nothing a file refers to (materials, buffers, textures) is ever opened.
What a file declares is checked before (`mesh_file`), what came out of it is checked after.
"""

import io
import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.error import SceneError
from radar_service.scene.mesh_file import check_content
from radar_service.scene.obj import obj_triangles
from radar_service.scene.world import Mesh

Floats = NDArray[np.float64]
Faces = NDArray[np.int64]

MAX_FILE_BYTES = 200 * 2**20
MAX_FACES = 5_000_000
REACH = 2e6  # m, as for any coordinate of a scene


class LoadedMesh(NamedTuple):
    """A usable mesh, and what was found odd about it: sentences without a subject."""

    mesh: Mesh
    findings: tuple[str, ...]


def mesh_from_bytes(content: bytes, name: str, place: str, scale: float = 1.0, up: str = "z") -> LoadedMesh:
    """The triangles of a mesh file's `content`, in metres and z up.

    name: the file's name, whose ending says the format; place: for messages. scale: metres per unit of the file.
    up: "y" maps (x, y, z) to (x, -z, y). Raises SceneError where the file is not a mesh that can be used.
    """
    kind = check_content(content, name, place)
    vertices, faces = obj_triangles(content, place) if kind == "obj" else _parse(content, kind, place)
    if len(faces) == 0:
        raise SceneError(f"{place}: no triangles in it; a mesh needs at least one with an area: export it again")
    _check_range(vertices, faces, place)
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices).all(axis=1)).sum())
        raise SceneError(f"{place}: {count} vertices are not finite numbers; correct the file")
    vertices = vertices * scale
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    if len(vertices) and np.abs(vertices).max() > REACH:
        raise SceneError(
            f"{place}: a vertex lies {np.abs(vertices).max():g} m from the mesh's origin; at most {REACH:g}: set scale"
        )
    return _tidied(vertices, faces, place)


def _parse(content: bytes, kind: str, place: str) -> tuple[Floats, Faces]:
    """Vertices (V, 3) and faces (F, 3) of all geometry in the file, placed by the file's own transforms."""
    import trimesh  # here: it would take a third of every start

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about materials and odd normals, which are not read
            scene = trimesh.load_scene(
                io.BytesIO(content), file_type=kind, process=False, skip_materials=True, group_material=False
            )
            parts = [p for p in scene.dump(concatenate=False) if isinstance(p, trimesh.Trimesh)]
            vertices = [np.asarray(part.vertices, dtype=np.float64) for part in parts]
            faces = [np.asarray(part.faces, dtype=np.int64) for part in parts]
    except Exception as fault:  # a parser fed with arbitrary bytes raises whatever it likes
        raise SceneError(f"{place}: not readable as {kind.upper()} ({_short(fault)}); export it again") from None
    if not faces:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    for points, triangles in zip(vertices, faces, strict=True):
        _check_range(points, triangles, place)
    starts = np.cumsum([0, *map(len, vertices)])
    joined = np.concatenate([triangles + start for triangles, start in zip(faces, starts[:-1], strict=True)])
    return np.concatenate(vertices), joined


def _check_range(vertices: Floats, faces: Faces, place: str) -> None:
    if len(faces) and (vertices.ndim != 2 or vertices.shape[1] != 3):
        raise SceneError(f"{place}: its vertices are not points in space; export it again")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise SceneError(
            f"{place}: faces refer to vertices {int(faces.min())} to {int(faces.max())}, but there are only "
            f"{len(vertices)} (counted from 0); export it again"
        )


def _short(fault: Exception) -> str:
    text = " ".join(str(fault).split())
    return f"{type(fault).__name__}: {text[:120]}" if text else type(fault).__name__


def _tidied(vertices: Floats, faces: Faces, place: str) -> LoadedMesh:
    """Without faces that have no area or stand there twice; vertices that no face uses are dropped too."""
    if len(faces) > MAX_FACES:
        raise SceneError(f"{place}: {len(faces)} triangles; at most {MAX_FACES}: simplify the mesh")
    points, where = _unique_rows(vertices)
    welded = where[faces]
    a, b, c = points[welded].transpose(1, 0, 2)
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.sqrt(np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
    # rounding of float64 coordinates moves a cross product by about longest x 1e-16 x distance from the origin
    sound = doubled_area > 4e-16 * longest * (np.abs(points).max() + longest)
    if not sound.any():
        raise SceneError(f"{place}: none of its {len(faces)} triangles has an area; export it again")
    kept = np.flatnonzero(sound)
    first = _first_of_each(welded[kept])
    findings = []
    if len(kept) < len(faces):
        findings.append(f"{len(faces) - len(kept)} triangles without area dropped")
    if len(first) < len(kept):
        findings.append(f"{len(kept) - len(first)} duplicate triangles dropped")
    kept = kept[first]
    findings.extend(_soundness(welded[kept]))
    used, compact = np.unique(faces[kept], return_inverse=True)
    return LoadedMesh(Mesh(vertices[used], compact.reshape(-1, 3).astype(np.int64)), tuple(findings))


def _unique_rows(rows: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """The distinct rows, and for each row where it went; bytes compare, so sorting is by one key and fast."""
    plain = np.ascontiguousarray(rows + 0.0)  # -0.0 and 0.0 are one place
    key = plain.view(np.dtype((np.void, plain.dtype.itemsize * plain.shape[1]))).ravel()
    _, first, where = np.unique(key, return_index=True, return_inverse=True)
    return plain[first], where.reshape(-1).astype(np.int64)


def _first_of_each(faces: Faces) -> NDArray[np.int64]:
    """Indices of the faces that are not copies of an earlier one; the same corners the other way round are no copy."""
    turn = np.argmin(faces, axis=1)
    rolled = np.take_along_axis(faces, (turn[:, None] + np.arange(3)) % 3, axis=1)
    order = np.lexsort(rolled.T[::-1])
    same = (np.diff(rolled[order], axis=0) == 0).all(axis=1)
    return np.sort(order[np.concatenate([[True], ~same])])


def _soundness(welded: Faces) -> list[str]:
    """What keeps the surface from being closed and wound one way, by counting each directed edge and its reverse."""
    start, end = welded.ravel(), np.roll(welded, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, edge, count = np.unique(low * (int(welded.max()) + 1) + high, return_inverse=True, return_counts=True)
    balance = np.bincount(edge.reshape(-1), weights=np.where(start < end, 1.0, -1.0))
    findings = []
    loose = int((count == 1).sum())
    if loose:
        findings.append(f"not watertight ({loose} open edges)")
    turned = int(((count == 2) & (balance != 0.0)).sum())
    if turned:
        findings.append(f"winding inconsistent across {turned} edges")
    crowded = int((count > 2).sum())
    if crowded:
        findings.append(f"{crowded} edges shared by more than two triangles")
    return findings
