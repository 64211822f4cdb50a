"""The document of a scene and the hashes of its files, as a recording keeps them."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from radar_service.scene.error import SceneError
from radar_service.scene.files.scene_file import model_and_folder
from radar_service.stream.source import SceneOrder

FILE_KEYS = ("mesh", "heightmap", "track")  # of a scene, that name a file


def scene_document(order: SceneOrder) -> tuple[dict[str, Any] | None, dict[str, str | None]]:
    """Returns the scene of an order as its file has it, and the SHA-256 of each file that it names, by its name.

    The rate of rotation is that of the order. The document is None where the scene's file has gone; so is the hash of a file.
    """
    try:
        model, folder = model_and_folder(order.source, None)
    except SceneError:
        return None, {}
    document: dict[str, Any] = model.model_dump(mode="json", exclude_unset=True)
    if order.rpm is not None:
        document["radar"] = _at_rpm(document.get("radar", {}), order)
    return document, {name: _hash(folder, name) for name in sorted(set(_file_names(document)))}


def _at_rpm(radar: Any, order: SceneOrder) -> Any:
    """The table, or the tables of several radars, with the rate of rotation of an order for the radar that it names."""
    if isinstance(radar, dict):
        return radar | {"rpm": order.rpm}
    names = [each.get("id") for each in radar]
    number = 0 if order.radar is None else names.index(order.radar)
    return [each | ({"rpm": order.rpm} if k == number else {}) for k, each in enumerate(radar)]


def _file_names(part: Any) -> Iterator[str]:
    if isinstance(part, dict):
        for key, value in part.items():
            if key in FILE_KEYS and isinstance(value, str):
                yield value
            yield from _file_names(value)
    elif isinstance(part, list):
        for item in part:
            yield from _file_names(item)


def _hash(folder: Path | None, name: str) -> str | None:
    try:
        return hashlib.sha256(((folder or Path()) / name).read_bytes()).hexdigest()
    except OSError:
        return None
