"""Reads the triangles of a Wavefront OBJ file from its `v` and `f` lines.

All other lines are ignored, so no file that an OBJ file refers to is opened.
"""

import re

import numpy as np

from radar_service.numerics import Indices, spans
from radar_service.scene_file.readers.file_format import Format, Triangles
from radar_service.scene_file.readers.trimesh_parser import exported_box
from radar_service.world import SceneError

MAX_VERTICES = 2**31


def obj_triangles(content: bytes, location: str) -> Triangles:
    """Returns vertices (V, 3) in units of the file, and triangles (F, 3). Raises SceneError with the line."""
    coordinates: list[bytes] = []
    corners: list[bytes] = []
    faces: list[tuple[int, int, int]] = []  # line, corners, vertices before it
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
            corners += words[1:]
            faces.append((number, len(words) - 1, count))
    try:
        vertices = np.array(coordinates, dtype="S32").astype(np.float64).reshape(-1, 3)
    except ValueError as error:
        raise SceneError(f"{location}: {error} in a vertex; export the file again") from None
    return vertices, _fans(corners, np.array(faces, dtype=np.int64).reshape(-1, 3), location)


def _fans(corners: list[bytes], faces: Indices, location: str) -> Indices:
    """Returns the triangles (F, 3) of faces, as numbers of vertices from 0: of each its fan about its first corner.

    corners: words, of one face after the other; faces: (P, 3) line, number of corners, and of vertices before it, from which
    negative numbers count back. Raises SceneError.
    """
    size = faces[:, 1]
    try:
        number = np.array([int(word.partition(b"/")[0]) for word in corners], dtype=np.int64)
    except (ValueError, OverflowError):
        raise _first_error(corners, faces, location) from None
    index = np.where(number > 0, number - 1, np.repeat(faces[:, 2], size) + number)
    if (size < 3).any() or (number == 0).any() or (number > MAX_VERTICES).any() or (index < 0).any():
        raise _first_error(corners, faces, location)
    end = np.cumsum(size)
    face, second = spans(end - size + 1, end - 1)
    return index[np.stack([(end - size)[face], second, second + 1], axis=1)]


def _first_error(corners: list[bytes], faces: Indices, location: str) -> SceneError:
    """Returns the error of the first face that is none."""
    end = 0
    for line, size, count in faces.tolist():
        words, end = corners[end : end + size], end + size
        try:
            polygon = [int(word.partition(b"/")[0]) for word in words]
        except ValueError:
            reason = f"a face needs vertex numbers, not {words[:4]!r}; export the file again"
            return SceneError(f"{location}, line {line}: {reason}")
        if len(polygon) < 3 or 0 in polygon or max(polygon) > MAX_VERTICES:
            reason = "a face needs three or more vertices, numbered from 1 in the order of the file; export it again"
            return SceneError(f"{location}, line {line}: {reason}")
        if min(polygon) < -count:
            reason = "a face counts back beyond the first vertex; export the file again"
            return SceneError(f"{location}, line {line}: {reason}")
    raise AssertionError("no face is wrong")


def _is_obj(content: bytes) -> bool:
    """Whether it is text with lines of vertices or faces, and neither JSON nor XML."""
    start = content[:4096]
    if b"\0" in start or re.match(rb"\s*[{\[<]", start):
        return False
    return re.search(rb"^[ \t]*(v|f)[ \t]", content[: 2**20], re.MULTILINE) is not None


FORMAT = Format[Triangles]("obj", _is_obj, obj_triangles, lambda: (exported_box("obj"),), is_plain_text=True)
