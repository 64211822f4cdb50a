"""Checks a mesh file before a parser reads it: its format by content, its declared counts against its size."""

import json
import re
import struct
from pathlib import PurePosixPath

from radar_service.scene_file.readers.gltf_check import check_gltf
from radar_service.world.error import SceneError

MAX_FACES = 5_000_000
MAX_JSON_BYTES = 20 * 2**20

ENDINGS = {".obj": "obj", ".stl": "stl", ".ply": "ply", ".glb": "glb"}
PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8,
             "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4,
             "float64": 8}  # fmt: skip
MAGIC = ((b"glTF", "glb"), (b"ply\n", "ply"), (b"ply\r", "ply"), (b"\x89PNG", "PNG"), (b"\xff\xd8\xff", "JPEG"),
         (b"PK\x03\x04", "ZIP"), (b"\x1f\x8b", "gzip"), (b"%PDF", "PDF"), (b"\x7fELF", "a program"))  # fmt: skip


def check_content(content: bytes, name: str, location: str) -> str:
    """Returns the format of a mesh file: obj, stl, stl_ascii, ply or glb.

    Raises SceneError if the ending is unknown, the content has another format, or it declares more than it holds.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending in (".gltf", ".dae", ".3ds", ".fbx", ".x", ".zip"):
        raise SceneError(
            f"{location}: {ending} is not supported, because it refers to other files or packs them; export it as .glb "
            "or .obj"
        )
    if ending not in ENDINGS:
        raise SceneError(
            f'{location}: the ending "{ending[:20]}" is not one of {", ".join(ENDINGS)}; convert the file to one of them'
        )
    if not content.strip():
        raise SceneError(f"{location}: the file is empty; export it again")
    kind, detected = ENDINGS[ending], detected_format(content)
    if kind != detected.removesuffix("_ascii"):
        raise SceneError(
            f"{location}: the file is not {kind.upper()} as its ending says; it looks like {detected}: rename it or "
            "export it again"
        )
    {"stl": _check_stl, "stl_ascii": _accept, "ply": _check_ply, "glb": _check_glb, "obj": _accept}[detected](
        content, location
    )
    return detected


def detected_format(content: bytes) -> str:
    """Returns the mesh format that `content` looks like, or words for what it is instead."""
    for magic, kind in MAGIC:
        if content.startswith(magic):
            return kind
    if _stl_size(content) == len(content):
        return "stl"  # tested before the word "solid", because binary files may begin with it too
    start = content[:4096]
    if re.match(rb"\s*solid\b", start) and b"facet" in content[:65536]:
        return "stl_ascii"
    if b"\0" in start:
        return (
            f"stl cut short or padded ({len(content)} bytes, not {_stl_size(content)})"
            if _nearly_stl(content)
            else "binary data"
        )
    if re.match(rb"\s*[{\[<]", start):
        return "JSON or XML"
    return "obj" if re.search(rb"^[ \t]*(v|f)[ \t]", content[: 2**20], re.MULTILINE) else "text of another kind"


def _stl_size(content: bytes) -> int:
    """Returns the size that a binary STL declares: 80 bytes of header, a count, 50 bytes per face."""
    return 84 + 50 * int(struct.unpack_from("<I", content, 80)[0]) if len(content) >= 84 else -1


def _nearly_stl(content: bytes) -> bool:
    return len(content) >= 84 and 0.5 < _stl_size(content) / len(content) < 2.0


def _accept(content: bytes, location: str) -> None:
    """Accepts text formats: they declare no counts, so the size of the file limits what a parser builds."""


def _check_stl(content: bytes, location: str) -> None:
    _check_faces((len(content) - 84) // 50, location)


def _check_faces(count: int, location: str) -> None:
    if count > MAX_FACES:
        raise SceneError(f"{location}: the mesh has {count} triangles; at most {MAX_FACES} are allowed: simplify it")


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
                _check_faces(count, location)
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
    _check_faces(faces, location)
