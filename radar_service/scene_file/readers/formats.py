"""The formats of mesh files: the entry points `radar_service.readers`, each a Format or several, by the ending of their files.

Those of height maps are in `raster`.
"""

import re
import shlex
from collections.abc import Iterator
from contextlib import suppress
from pathlib import PurePosixPath
from typing import Any

from radar_service import plug_ins
from radar_service.scene_file.readers.file_format import Format
from radar_service.scene_file.readers.stl import cut_or_padded
from radar_service.world import SceneError

ASSIMP = "assimp export {} {} -tri makes an .obj of it"
OTHER_ENDINGS = {  # that are not read: why, and what to do; {} are the file and the one that is made of it
    **dict.fromkeys((".x", ".3ds", ".dae", ".fbx"), f"no reader of it is built in: {ASSIMP}"),
    ".gltf": "it keeps its data in other files: export it as .glb, which holds all, or " + ASSIMP,
    ".zip": "it packs other files: unpack it, and name the mesh inside",
}
OTHERS = (
    (b"\x89PNG", "PNG"), (b"\xff\xd8\xff", "JPEG"), (b"PK\x03\x04", "ZIP"), (b"\x1f\x8b", "gzip"), (b"%PDF", "PDF"),
    (b"\x7fELF", "a program"),
)  # fmt: skip


def formats_of(ending: str, location: str = "", group: str = "readers") -> tuple[Format[Any], ...]:
    """Returns the formats of files with that ending, without its dot. group: "rasters" for height maps. Raises SceneError."""
    try:
        part = plug_ins.load(group, ending)
        formats = part if isinstance(part, tuple) else (part,)
        with plug_ins.guarded(plug_ins.entry(group, ending)):
            assert all(isinstance(kind, Format) for kind in formats), "it is no Format"
    except plug_ins.PlugInError as error:
        raise SceneError(f"{location}: {error}") from None
    return formats


def examples(group: str) -> Iterator[tuple[str, bytes]]:
    """Yields names and contents of small files, of each format of a group whose reader works."""
    for ending in plug_ins.names(group):
        with suppress(Exception):  # of a stranger's reader: files of the others are read
            yield from [
                (f"example.{ending}", example) for kind in formats_of(ending, group=group) for example in kind.examples()
            ]


def own_formats() -> list[Format[Any]]:
    """Returns the formats of this package, in the order in which content is compared with them: the least particular one last."""
    endings = [ending for ending in plug_ins.names("readers") if plug_ins.is_own(plug_ins.entry("readers", ending))]
    return sorted((kind for ending in endings for kind in formats_of(ending)), key=lambda kind: kind.is_plain_text)


def format_of(content: bytes, name: str, location: str) -> Format[Any]:
    """Returns the format of a mesh file. name: of the file; location: key path for messages.

    Raises SceneError if the ending is unknown, its reader cannot be used, or the content has another format.
    """
    path = PurePosixPath(name)
    ending = path.suffix.lower()
    known = [f".{ending}" for ending in plug_ins.names("readers")]
    if ending in OTHER_ENDINGS and ending not in known:
        file, converted = (shlex.quote(f"{path.stem[:80]}{suffix}") for suffix in (path.suffix, ".obj"))
        reason = OTHER_ENDINGS[ending].format(file, converted)
        raise SceneError(f"{location}: {ending} is not read; {reason}")
    if ending not in known:
        raise SceneError(
            f'{location}: the ending "{ending[:20]}" is not one of {", ".join(known)}; convert the file to one of them'
        )
    if not content.strip():
        raise SceneError(f"{location}: the file is empty; export it again")
    formats = formats_of(ending[1:], location)
    detected = detected_format(content, formats)
    if detected not in formats:
        seen = detected if isinstance(detected, str) else detected.name
        raise SceneError(
            f"{location}: the file is not {ending[1:].upper()} as its ending says; it looks like {seen}: rename it or "
            "export it again"
        )
    return detected


def detected_format(content: bytes, formats: tuple[Format[Any], ...] = ()) -> Format[Any] | str:
    """Returns the mesh format that `content` looks like, of ours and of `formats`, or words for what it is instead."""
    for magic, other in OTHERS:
        if content.startswith(magic):
            return other
    own = own_formats()
    others = [kind for kind in formats if kind not in own]
    return next((kind for kind in (*others, *own) if kind.detect(content)), None) or _words(content)


def _words(content: bytes) -> str:
    """Words for content that has no format."""
    if b"\0" in content[:4096]:
        return cut_or_padded(content) or "binary data"
    return "JSON or XML" if re.match(rb"\s*[{\[<]", content[:4096]) else "text of another kind"
