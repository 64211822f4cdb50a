"""The triangles of a Wavefront OBJ file: its `v` and `f` lines and nothing else, so that nothing it refers to is ever read.

Groups, materials, normals and texture coordinates say nothing that a radar sees.
"""

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.error import SceneError

Floats = NDArray[np.float64]
Faces = NDArray[np.int64]


MAX_VERTICES = 2**31


def obj_triangles(content: bytes, place: str) -> tuple[Floats, Faces]:
    """Vertices (V, 3) and faces (F, 3); polygons become fans. Raises SceneError naming the line that is wrong."""
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
                    f"{place}, line {number}: a vertex of {len(words) - 1} numbers; it needs x, y and z: export it again"
                )
            coordinates += words[1:4]
            count += 1
        elif words[0] == b"f":
            corners += _fan(words[1:], count, f"{place}, line {number}")
    try:
        vertices = np.array(coordinates, dtype="S32").astype(np.float64).reshape(-1, 3)
    except ValueError as fault:
        raise SceneError(f"{place}: {fault} in a vertex; export it again") from None
    return vertices, np.array(corners, dtype=np.int64).reshape(-1, 3)


def _fan(words: list[bytes], count: int, place: str) -> list[int]:
    """Indices from 0 of the triangles of one face; negative ones count back from the `count` vertices read so far."""
    try:
        polygon = [int(word.partition(b"/")[0]) for word in words]
    except ValueError:
        raise SceneError(f"{place}: a face needs vertex numbers, not {words[:4]!r}; export it again") from None
    if len(polygon) < 3 or 0 in polygon or max(polygon) > MAX_VERTICES:
        raise SceneError(f"{place}: a face needs three or more vertices, numbered from 1 as they come; export it again")
    places = [k - 1 if k > 0 else count + k for k in polygon]
    if min(places) < 0:
        raise SceneError(f"{place}: a face counts back beyond the first vertex; export it again")
    if len(places) == 3:
        return places
    return [k for a, b in zip(places[1:], places[2:], strict=False) for k in (places[0], a, b)]
