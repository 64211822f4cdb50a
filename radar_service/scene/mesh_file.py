"""What a mesh file is and claims, before anything is built from it: formats by content, counts against bytes."""

import json
import re
import struct
from pathlib import PurePosixPath

from radar_service.scene.error import SceneError
from radar_service.scene.gltf_check import check_gltf

MAX_FACES = 5_000_000
MAX_JSON_BYTES = 20 * 2**20

ENDINGS = {".obj": "obj", ".stl": "stl", ".ply": "ply", ".glb": "glb"}
PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8,
             "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4,
             "float64": 8}  # fmt: skip
MAGIC = ((b"glTF", "glb"), (b"ply\n", "ply"), (b"ply\r", "ply"), (b"\x89PNG", "PNG"), (b"\xff\xd8\xff", "JPEG"),
         (b"PK\x03\x04", "ZIP"), (b"\x1f\x8b", "gzip"), (b"%PDF", "PDF"), (b"\x7fELF", "a program"))  # fmt: skip


def check_content(content: bytes, name: str, place: str) -> str:
    """The format of a mesh file: obj, stl, stl_ascii, ply or glb.

    Raises SceneError where the ending is unknown, the content is something else, or claims more than it holds.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending in (".gltf", ".dae", ".3ds", ".fbx", ".x", ".zip"):
        raise SceneError(
            f"{place}: {ending} is not read, for it refers to other files or packs them; export it as .glb or .obj"
        )
    if ending not in ENDINGS:
        raise SceneError(f'{place}: its ending "{ending[:20]}" is none of {", ".join(ENDINGS)}; convert it to one of them')
    if not content.strip():
        raise SceneError(f"{place}: is empty; export it again")
    kind, found = ENDINGS[ending], sniffed(content)
    if kind != found.removesuffix("_ascii"):
        raise SceneError(f"{place}: is not {kind.upper()} as its ending says but looks like {found}; rename or export it")
    {"stl": _check_stl, "stl_ascii": _accept, "ply": _check_ply, "glb": _check_glb, "obj": _accept}[found](content, place)
    return found


def sniffed(content: bytes) -> str:
    """What `content` looks like: a mesh format, or the name of something else."""
    for magic, kind in MAGIC:
        if content.startswith(magic):
            return kind
    if _stl_size(content) == len(content):
        return "stl"  # before the word "solid", with which binary files begin too
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
    """The size that a binary STL says it has: 80 bytes of header, a count, 50 bytes a face."""
    return 84 + 50 * int(struct.unpack_from("<I", content, 80)[0]) if len(content) >= 84 else -1


def _nearly_stl(content: bytes) -> bool:
    return len(content) >= 84 and 0.5 < _stl_size(content) / len(content) < 2.0


def _accept(content: bytes, place: str) -> None:
    """Text says what it holds line by line, so its size bounds what is built from it."""


def _check_stl(content: bytes, place: str) -> None:
    _check_faces((len(content) - 84) // 50, place)


def _check_faces(count: int, place: str) -> None:
    if count > MAX_FACES:
        raise SceneError(f"{place}: {count} triangles; at most {MAX_FACES}: simplify the mesh")


def _check_ply(content: bytes, place: str) -> None:
    """Raises SceneError where a PLY header is broken, or its elements cannot fit into what follows it."""
    header, end, body = content[:65536].partition(b"end_header")
    if not end:
        raise SceneError(f"{place}: its PLY header does not end; export it again")
    row_bytes, needed, kind, count = 0, 0, b"", 0
    for line in [*header.splitlines(), b"element end 0"]:
        words = line.split()
        if words[:1] == [b"format"] and len(words) > 1:
            kind = words[1]
        elif words[:1] == [b"element"]:
            needed += count * row_bytes
            if len(words) != 3 or not words[2].isdigit():
                raise SceneError(f"{place}: its PLY header says {line[:60]!r}; a count from 0 is needed: export it again")
            row_bytes, count = 0, int(words[2][:18])
            if words[1] == b"face":
                _check_faces(count, place)
        elif words[:1] == [b"property"]:
            row_bytes += 2 if kind == b"ascii" else _ply_bytes(words, place)
    if needed > len(content):
        raise SceneError(
            f"{place}: its PLY header promises at least {needed} bytes, the file has {len(content)}; export it again"
        )


def _ply_bytes(words: list[bytes], place: str) -> int:
    """The least bytes that a property takes: an empty list has only its count."""
    kind = words[2 if words[1:2] == [b"list"] else 1 :][:1]
    name = kind[0].decode("ascii", "replace") if kind else ""
    if name not in PLY_SIZES:
        raise SceneError(f'{place}: its PLY header has a property of type "{name[:20]}", which is unknown; export it again')
    return PLY_SIZES[name]


def _check_glb(content: bytes, place: str) -> None:
    """Raises SceneError where lengths disagree with the file, or its JSON claims what the buffer does not hold."""
    if len(content) < 20 or struct.unpack_from("<II", content, 4) != (2, len(content)):
        raise SceneError(f"{place}: not GLB version 2 of {len(content)} bytes as its header should say; export it again")
    chunks: dict[bytes, tuple[int, int]] = {}
    at = 12
    while at + 8 <= len(content):
        size, kind = struct.unpack_from("<I4s", content, at)
        if at + 8 + size > len(content):
            raise SceneError(f"{place}: a chunk claims {size} bytes, {len(content) - at - 8} are left; export it again")
        chunks.setdefault(kind, (at + 8, size))
        at += 8 + size
    start, size = chunks.get(b"JSON", (0, 0))
    if not 0 < size <= MAX_JSON_BYTES:
        raise SceneError(f"{place}: its JSON chunk has {size} bytes; 1 to {MAX_JSON_BYTES} are allowed: export it again")
    try:
        tree = json.loads(content[start : start + size])
    except (ValueError, RecursionError) as fault:
        raise SceneError(f"{place}: its JSON is broken ({str(fault)[:100]}); export it again") from None
    try:
        faces = check_gltf(tree, chunks.get(b"BIN\0", (0, 0))[1], place)
    except (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError) as fault:
        if isinstance(fault, SceneError):
            raise
        raise SceneError(
            f"{place}: its JSON is not glTF ({type(fault).__name__}: {str(fault)[:100]}); export it again"
        ) from None
    _check_faces(faces, place)
