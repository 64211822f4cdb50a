"""The formats of mesh files. A new one is a file beside this one, which has FORMATS, and a line in MODULES.

Those of height maps are in `raster`.
"""

import re
import shlex
from importlib import import_module
from pathlib import PurePosixPath

from radar_service.scene_file.readers.file_format import Format, Triangles
from radar_service.scene_file.readers.stl import cut_or_padded
from radar_service.world.error import SceneError

MODULES = (  # in the order in which content is compared with them: the least particular one last
    "glb",
    "ply",
    "stl",
    "obj",
)
FORMATS: tuple[Format[Triangles], ...] = tuple(
    each for name in MODULES for each in import_module(f"radar_service.scene_file.readers.{name}").FORMATS
)
ENDINGS = tuple(dict.fromkeys(ending for each in reversed(FORMATS) for ending in each.endings))
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


def format_of(content: bytes, name: str, location: str) -> Format[Triangles]:
    """Returns the format of a mesh file. name: of the file; location: key path for messages.

    Raises SceneError if the ending is unknown or the content has another format.
    """
    path = PurePosixPath(name)
    ending = path.suffix.lower()
    if ending in OTHER_ENDINGS:
        file, converted = (shlex.quote(f"{path.stem[:80]}{suffix}") for suffix in (path.suffix, ".obj"))
        reason = OTHER_ENDINGS[ending].format(file, converted)
        raise SceneError(f"{location}: {ending} is not read; {reason}")
    if ending not in ENDINGS:
        raise SceneError(
            f'{location}: the ending "{ending[:20]}" is not one of {", ".join(ENDINGS)}; convert the file to one of them'
        )
    if not content.strip():
        raise SceneError(f"{location}: the file is empty; export it again")
    detected = detected_format(content)
    if isinstance(detected, str) or ending not in detected.endings:
        seen = detected if isinstance(detected, str) else detected.name
        raise SceneError(
            f"{location}: the file is not {ending[1:].upper()} as its ending says; it looks like {seen}: rename it or "
            "export it again"
        )
    return detected


def detected_format(content: bytes) -> Format[Triangles] | str:
    """Returns the mesh format that `content` looks like, or words for what it is instead."""
    for magic, other in OTHERS:
        if content.startswith(magic):
            return other
    return next((each for each in FORMATS if each.detect(content)), None) or _words(content)


def _words(content: bytes) -> str:
    """Words for content that has no format."""
    if b"\0" in content[:4096]:
        return cut_or_padded(content) or "binary data"
    return "JSON or XML" if re.match(rb"\s*[{\[<]", content[:4096]) else "text of another kind"
