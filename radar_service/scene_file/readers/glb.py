"""GLB files: their chunks are checked here, their JSON by `gltf_check`; trimesh parses them."""

import json
import struct
from functools import partial

from radar_service.scene_file.readers.file_format import Format, Triangles, check_face_count
from radar_service.scene_file.readers.gltf_check import check_gltf
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world.error import SceneError

MAX_JSON_BYTES = 20 * 2**20


def _check_glb(content: bytes, location: str) -> None:
    """Raises SceneError if lengths disagree with the file, or the JSON declares more than the buffer holds."""
    if len(content) < 20 or struct.unpack_from("<II", content, 4) != (2, len(content)):
        raise SceneError(
            f"{location}: the header is not that of GLB version 2 with {len(content)} bytes; export the file again"
        )
    chunks: dict[bytes, tuple[int, int]] = {}
    at = 12
    while at + 8 <= len(content):
        size, kind = struct.unpack_from("<I4s", content, at)
        if at + 8 + size > len(content):
            raise SceneError(
                f"{location}: a chunk declares {size} bytes, {len(content) - at - 8} are left; export the file again"
            )
        chunks.setdefault(kind, (at + 8, size))
        at += 8 + size
    start, size = chunks.get(b"JSON", (0, 0))
    if not 0 < size <= MAX_JSON_BYTES:
        raise SceneError(
            f"{location}: the JSON chunk has {size} bytes; 1 to {MAX_JSON_BYTES} are allowed: export the file again"
        )
    try:
        tree = json.loads(content[start : start + size])
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{location}: the JSON is invalid ({str(error)[:100]}); export the file again") from None
    try:
        faces = check_gltf(tree, chunks.get(b"BIN\0", (0, 0))[1], location)
    except (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(
            f"{location}: the JSON is not glTF ({type(error).__name__}: {str(error)[:100]}); export it again"
        ) from None
    check_face_count(faces, location)


FORMAT = Format[Triangles](
    "glb", lambda content: content.startswith(b"glTF"), partial(trimesh_triangles, "glb"), lambda: (exported_box("glb"),),
    _check_glb,
)  # fmt: skip
