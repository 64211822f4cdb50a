"""A hash of all that a scene contains: two scenes with equal hashes give the same truth and the same spokes."""

import hashlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from radar_service.scene.world import Scene


def scene_hash(scene: Scene) -> str:
    """Returns the SHA-256 of a scene's world, radar, platform, interference and errors, as hexadecimal digits."""
    digest = hashlib.sha256()
    errors = () if scene.errors is None else (scene.errors,)
    for part in (scene.world, scene.radar, scene.platform, scene.interference, *errors):
        _add(digest, part)
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    """Adds a value, whose type and size come first, so that neighbours cannot be mistaken for each other."""
    digest.update(f"{type(value).__qualname__}:".encode())
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        for field in fields(value):
            digest.update(f"{field.name}=".encode())
            _add(digest, getattr(value, field.name))
    elif isinstance(value, tuple | list):
        digest.update(f"{len(value)},".encode())
        for item in value:
            _add(digest, item)
    elif value is None or isinstance(value, bool | int | float | str):
        digest.update(f"{value!r};".encode())
    else:
        raise TypeError(f"a scene has a {type(value).__name__}, which has no hash yet")
