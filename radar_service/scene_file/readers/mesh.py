"""Reads mesh files as triangles: OBJ by `obj`; STL, PLY and GLB by trimesh, which only this module imports.

trimesh receives bytes, never a path, so it cannot open a file that a mesh refers to (materials, buffers, textures).
`mesh_check` checks the declared counts before; this module checks the triangles after.
"""

import io
import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics.constants import MAX_COORDINATE
from radar_service.scene_file.readers.flat_copies import Edges, flat_copies, numbered_edges
from radar_service.scene_file.readers.mesh_check import MAX_FACES, check_content
from radar_service.scene_file.readers.obj import obj_triangles
from radar_service.world.body import Mesh
from radar_service.world.error import SceneError

Floats = NDArray[np.float64]
Faces = NDArray[np.int64]

MAX_FILE_BYTES = 200 * 2**20


class LoadedMesh(NamedTuple):
    """A usable mesh, and its defects in words without a subject, for warnings."""

    mesh: Mesh
    findings: tuple[str, ...]


def mesh_from_bytes(content: bytes, name: str, location: str, scale: float = 1.0, up: str = "z") -> LoadedMesh:
    """Returns the triangles of a mesh file's `content`, in metres and z up.

    name: the file's name, whose ending gives the format. location: key path for messages. scale: metres per unit of the
    file. up: "y" maps (x, y, z) to (x, -z, y). Raises SceneError if the file has no usable mesh.
    """
    kind = check_content(content, name, location)
    vertices, faces = obj_triangles(content, location) if kind == "obj" else _parse(content, kind, location)
    if len(faces) == 0:
        raise SceneError(f"{location}: the file has no triangles; a mesh needs at least one with an area: export it again")
    _check_range(vertices, faces, location)
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices).all(axis=1)).sum())
        raise SceneError(f"{location}: {count} vertices are not finite numbers; correct the file")
    vertices = vertices * scale
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    if len(vertices) and np.abs(vertices).max() > MAX_COORDINATE:
        raise SceneError(
            f"{location}: a vertex is {np.abs(vertices).max():g} m from the mesh's origin; at most "
            f"{MAX_COORDINATE:g} m are allowed: correct scale"
        )
    return _cleaned(vertices, faces, location)


def _parse(content: bytes, kind: str, location: str) -> tuple[Floats, Faces]:
    """Returns vertices (V, 3) and faces (F, 3) of all geometry in the file, after the file's own transforms."""
    import trimesh  # here, because it takes a third of the start-up time

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about materials and normals, which are not read
            scene = trimesh.load_scene(
                io.BytesIO(content), file_type=kind, process=False, skip_materials=True, group_material=False
            )
            parts = [p for p in scene.dump(concatenate=False) if isinstance(p, trimesh.Trimesh)]
            vertices = [np.asarray(part.vertices, dtype=np.float64) for part in parts]
            faces = [np.asarray(part.faces, dtype=np.int64) for part in parts]
    except Exception as error:  # parsers of arbitrary bytes raise any exception
        raise SceneError(
            f"{location}: the file is not readable as {kind.upper()} ({_error_text(error)}); export it again"
        ) from None
    if not faces:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    for points, triangles in zip(vertices, faces, strict=True):
        _check_range(points, triangles, location)
    starts = np.cumsum([0, *map(len, vertices)])
    joined = np.concatenate([triangles + start for triangles, start in zip(faces, starts[:-1], strict=True)])
    return np.concatenate(vertices), joined


def _check_range(vertices: Floats, faces: Faces, location: str) -> None:
    if len(faces) and (vertices.ndim != 2 or vertices.shape[1] != 3):
        raise SceneError(f"{location}: the vertices are not points in space; export the file again")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise SceneError(
            f"{location}: faces refer to vertices {int(faces.min())} to {int(faces.max())}, but there are only "
            f"{len(vertices)} (counted from 0); export the file again"
        )


def _error_text(error: Exception) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:120]}" if text else type(error).__name__


def _cleaned(vertices: Floats, faces: Faces, location: str) -> LoadedMesh:
    """Returns the mesh without duplicate or empty faces and unused vertices. Raises SceneError if no face is left."""
    if len(faces) > MAX_FACES:
        raise SceneError(f"{location}: the mesh has {len(faces)} triangles; at most {MAX_FACES} are allowed: simplify it")
    points, index = _unique_rows(vertices)
    welded = index[faces]
    a, b, c = points[welded].transpose(1, 0, 2)
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.sqrt(np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
    # rounding of float64 coordinates moves a cross product by about longest x 1e-16 x distance from the origin
    valid = doubled_area > 4e-16 * longest * (np.abs(points).max() + longest)
    if not valid.any():
        raise SceneError(f"{location}: none of the {len(faces)} triangles has an area; export the file again")
    kept = np.flatnonzero(valid)
    first = _unique_faces(welded[kept])
    findings = []
    if len(kept) < len(faces):
        findings.append(f"{len(faces) - len(kept)} triangles without area dropped")
    if len(first) < len(kept):
        findings.append(f"{len(kept) - len(first)} duplicate triangles dropped")
    kept = kept[first]
    edges = numbered_edges(welded[kept])
    copies = flat_copies(points, welded[kept], edges)
    if len(copies):
        findings.append(f"{len(copies)} triangles of faces dropped that repeat others, cut differently")
        kept = np.delete(kept, copies)
        edges = numbered_edges(welded[kept])
    findings.extend(_surface_defects(edges))
    used, compact = np.unique(faces[kept], return_inverse=True)
    return LoadedMesh(Mesh(vertices[used], compact.reshape(-1, 3).astype(np.int64)), tuple(findings))


def _unique_rows(rows: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Returns the distinct rows, and for each row its index in them. Sorting compares bytes, so one fast key is enough."""
    plain = np.ascontiguousarray(rows + 0.0)  # + 0.0: -0.0 and 0.0 are the same coordinate
    key = plain.view(np.dtype((np.void, plain.dtype.itemsize * plain.shape[1]))).ravel()
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    return plain[first], index.reshape(-1).astype(np.int64)


def _unique_faces(faces: Faces) -> NDArray[np.int64]:
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
