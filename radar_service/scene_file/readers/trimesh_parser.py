"""Parses STL, PLY and GLB by trimesh, which only this module imports.

trimesh receives bytes, never a path, so it cannot open a file that a mesh refers to (materials, buffers, textures).
"""

import io
import warnings
from typing import Any

import numpy as np

from radar_service.scene_file.readers.file_format import Triangles, check_range, refusals


def trimesh_triangles(kind: str, content: bytes, location: str) -> Triangles:
    """Returns the triangles of all geometry in a file, after the file's own transforms. Raises SceneError.

    kind: the format, as trimesh names it.
    """
    import trimesh  # here, because it takes a third of the start-up time

    with refusals(kind, location), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about materials and normals, which are not read
        scene = trimesh.load_scene(
            io.BytesIO(content), file_type=kind, process=False, skip_materials=True, group_material=False
        )
        parts = [p for p in scene.dump(concatenate=False) if isinstance(p, trimesh.Trimesh)]
        vertices = [np.asarray(part.vertices, dtype=np.float64) for part in parts]
        faces = [np.asarray(part.faces, dtype=np.int64) for part in parts]
    if not faces:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    for points, triangles in zip(vertices, faces, strict=True):
        check_range(points, triangles, location)
    if len(faces) == 1:
        return vertices[0], faces[0]
    starts = np.cumsum([0, *map(len, vertices)])
    joined = np.concatenate([triangles + start for triangles, start in zip(faces, starts[:-1], strict=True)])
    return np.concatenate(vertices), joined


def exported_box(kind: str, **options: Any) -> bytes:
    """Returns a box as a file of a format, as trimesh names it and with its options."""
    import trimesh

    exported = trimesh.creation.box().export(file_type=kind, **options)
    return exported if isinstance(exported, bytes) else str(exported).encode()
