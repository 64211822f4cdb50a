"""A hash of all that a scene contains: two scenes with equal hashes give the same truth and the same spokes."""

import hashlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from radar_service.radar.parameters import Origin
from radar_service.scene.world import Scene


def scene_hash(scene: Scene) -> str:
    """Returns the SHA-256 of a scene's world, radar, platform, interference and errors, as hexadecimal digits.

    The key of its random numbers belongs to it. A field of a record that was added later says so in its metadata, as "added";
    while it has its default it adds nothing, so scenes that do not use it keep their hash.
    """
    digest = hashlib.sha256()
    errors = () if scene.errors is None else (scene.errors,)
    for part in (scene.world, scene.radar, scene.platform, scene.interference, *errors, *scene.random_key):
        _add(digest, part)
    return digest.hexdigest()


def _is_default(content: Any, default: Any) -> bool:
    """Whether a field has its default; arrays are not compared."""
    return content is default or (isinstance(content, str | tuple | Origin) and content == default)


def _add(digest: Any, value: Any) -> None:
    """Adds a value, whose type and size come first, so that neighbours cannot be mistaken for each other."""
    digest.update(f"{type(value).__qualname__}:".encode())
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        for field in fields(value):
            content = getattr(value, field.name)
            if "added" in field.metadata and _is_default(content, field.default):
                continue
            digest.update(f"{field.name}=".encode())
            _add(digest, content)
    elif isinstance(value, tuple | list):
        digest.update(f"{len(value)},".encode())
        for item in value:
            _add(digest, item)
    elif value is None or isinstance(value, bool | int | float | str):
        digest.update(f"{value!r};".encode())
    else:
        raise TypeError(f"a scene has a {type(value).__name__}, which has no hash yet")
