"""PLY files: their header is checked here, trimesh parses them."""

from functools import partial

from radar_service.scene_file.readers.file_format import Format, Triangles, check_face_count
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world import SceneError

PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8,
             "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4,
             "float64": 8}  # fmt: skip


def _check_ply(content: bytes, location: str) -> None:
    """Raises SceneError if the PLY header is invalid, or declares more elements than the file can hold."""
    header, end, body = content[:65536].partition(b"end_header")
    if not end:
        raise SceneError(f"{location}: the PLY header does not end; export the file again")
    row_bytes, needed, kind, count = 0, 0, b"", 0
    for line in [*header.splitlines(), b"element end 0"]:
        words = line.split()
        if words[:1] == [b"format"] and len(words) > 1:
            kind = words[1]
        elif words[:1] == [b"element"]:
            needed += count * row_bytes
            if len(words) != 3 or not words[2].isdigit():
                raise SceneError(
                    f"{location}: the PLY header has {line[:60]!r}; a count from 0 is needed: export the file again"
                )
            row_bytes, count = 0, int(words[2][:18])
            if words[1] == b"face":
                check_face_count(count, location)
        elif words[:1] == [b"property"]:
            row_bytes += 2 if kind == b"ascii" else _ply_bytes(words, location)
    if needed > len(content):
        raise SceneError(
            f"{location}: the PLY header declares at least {needed} bytes, the file has {len(content)}; export it again"
        )


def _ply_bytes(words: list[bytes], location: str) -> int:
    """Returns the minimum size [bytes] of a property: an empty list has only its count."""
    kind = words[2 if words[1:2] == [b"list"] else 1 :][:1]
    name = kind[0].decode("ascii", "replace") if kind else ""
    if name not in PLY_SIZES:
        raise SceneError(
            f'{location}: the PLY header has a property of the unknown type "{name[:20]}"; export the file again'
        )
    return PLY_SIZES[name]


FORMAT = Format[Triangles](
    "ply", lambda content: content.startswith((b"ply\n", b"ply\r")), partial(trimesh_triangles, "ply"),
    lambda: (exported_box("ply"), exported_box("ply", encoding="ascii")), _check_ply,
)  # fmt: skip
