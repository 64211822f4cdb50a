"""Reads the triangles of a Wavefront OBJ file from its `v` and `f` lines.

All other lines are ignored, so no file that an OBJ file refers to is opened.
"""

import re

import numpy as np

from radar_service.scene_file.readers.file_format import Format, Triangles
from radar_service.scene_file.readers.trimesh_parser import exported_box
from radar_service.world.error import SceneError

MAX_VERTICES = 2**31


def obj_triangles(content: bytes, location: str) -> Triangles:
    """Returns vertices (V, 3) in units of the file, and triangles (F, 3). Raises SceneError with the line."""
    coordinates: list[bytes] = []
    corners: list[int] = []
    count = 0
    for number, line in enumerate(content.replace(b"\\\r\n", b"  \n").replace(b"\\\n", b" ").split(b"\n"), start=1):
        words = line.split()
        if not words:
            continue
        if words[0] == b"v":
            if len(words) < 4:
                raise SceneError(
                    f"{location}, line {number}: a vertex has {len(words) - 1} numbers; it needs x, y and z: export the "
                    "file again"
                )
            coordinates += words[1:4]
            count += 1
        elif words[0] == b"f":
            corners += _fan(words[1:], count, f"{location}, line {number}")
    try:
        vertices = np.array(coordinates, dtype="S32").astype(np.float64).reshape(-1, 3)
    except ValueError as error:
        raise SceneError(f"{location}: {error} in a vertex; export the file again") from None
    return vertices, np.array(corners, dtype=np.int64).reshape(-1, 3)


def _fan(words: list[bytes], count: int, location: str) -> list[int]:
    """Returns indices from 0 of the triangles of one face; negative numbers count back from the `count` vertices so far."""
    try:
        polygon = [int(word.partition(b"/")[0]) for word in words]
    except ValueError:
        raise SceneError(f"{location}: a face needs vertex numbers, not {words[:4]!r}; export the file again") from None
    if len(polygon) < 3 or 0 in polygon or max(polygon) > MAX_VERTICES:
        raise SceneError(
            f"{location}: a face needs three or more vertices, numbered from 1 in the order of the file; export it again"
        )
    indices = [k - 1 if k > 0 else count + k for k in polygon]
    if min(indices) < 0:
        raise SceneError(f"{location}: a face counts back beyond the first vertex; export the file again")
    if len(indices) == 3:
        return indices
    return [k for a, b in zip(indices[1:], indices[2:], strict=False) for k in (indices[0], a, b)]


def _is_obj(content: bytes) -> bool:
    """Whether it is text with lines of vertices or faces, and neither JSON nor XML."""
    start = content[:4096]
    if b"\0" in start or re.match(rb"\s*[{\[<]", start):
        return False
    return re.search(rb"^[ \t]*(v|f)[ \t]", content[: 2**20], re.MULTILINE) is not None


FORMATS = (
    Format[Triangles](
        name="obj",
        endings=(".obj",),
        detect=_is_obj,
        parse=obj_triangles,
        examples=lambda: (exported_box("obj"),),
    ),
)
