"""What a mesh file claims, before anything is built from it."""

from pathlib import PurePosixPath

from radar_service.scene.error import SceneError

FORMATS = ("obj", "stl", "ply", "glb")


def check_content(content: bytes, name: str, place: str) -> str:
    """The format of a mesh file, by its ending."""
    kind = PurePosixPath(name).suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise SceneError(
            f'{place}: "{name:.200}" does not end in {", ".join("." + k for k in FORMATS)}; convert it to one of them'
        )
    return kind
