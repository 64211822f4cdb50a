"""Truth files: JSON Lines with a header, and for each scan its crossings and a snapshot of all bodies at its end.

SI units and radians, bearings clockwise from true north; the keys are the fields of `records.truth.Crossing` and
`records.truth.Snapshot`. Each line has a `type`: header, crossing or snapshot. Absent values are null.

The hash of a scene is of all that it contains: two scenes with equal hashes give the same truth and the same spokes.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from radar_service.records import Crossing, Snapshot
from radar_service.world import Scene

SCHEMA = 1  # version of these keys


def scene_hash(scene: Scene) -> str:
    """Returns the SHA-256 of a scene's world, radar, platform, effects and errors, as hexadecimal digits.

    The key of its random numbers belongs to it. A field of a record that was added later says so in its metadata, as "added";
    while it has its default it adds nothing, so scenes that do not use it keep their hash. Nor does one that says "derived", as
    it follows from others.
    """
    digest = hashlib.sha256()
    errors = () if scene.errors is None else (scene.errors,)
    effects = dict(scene.effects)
    interference = effects.pop("interference", ())  # which every hash had before effects had names
    for part in (scene.world, scene.radar, scene.platform, interference, *errors, *scene.random_key):
        _add(digest, part)
    _add_named(digest, effects)
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    """Adds a value, whose type and size come first, so that neighbours cannot be mistaken for each other."""
    digest.update(f"{type(value).__qualname__}:".encode())
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        for field in fields(value):
            content = getattr(value, field.name)
            if isinstance(content, Mapping):
                _add_named(digest, content)
                continue
            given = content is not field.default
            if given and isinstance(content, str | float | tuple):  # arrays are not compared
                given = content != field.default
            if "derived" in field.metadata or "added" in field.metadata and not given:
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


def _add_named(digest: Any, records: Mapping[str, Any]) -> None:
    """Adds records by their names, in the order in which effects add; none adds nothing."""
    for name, record in records.items():
        digest.update(f"{name}=".encode())
        _add(digest, record)


def header(scene: Scene, seed: int, fidelity: str) -> dict[str, Any]:
    """Returns the first line of a truth file. The same scene, seed and fidelity give the same truth."""
    radar = scene.radar
    return {
        "type": "header", "schema": SCHEMA, "version": version("radar-service"), "scene": scene.name,
        "scene_hash": scene_hash(scene), "seed": seed, "fidelity": fidelity,
        "radars": [
            {"id": scene.radar_id, "azimuths": radar.azimuths, "rotation_period": radar.rotation_period, "bins": radar.bins,
             "range_first": radar.range_step / 2.0, "range_step": radar.range_step, "beamwidth": radar.beamwidth,
             "frequency": radar.frequency},
        ],
    }  # fmt: skip


def truth_lines(crossings: Iterable[Crossing], snapshot: Snapshot) -> list[str]:
    """Returns the lines of one scan."""
    return [truth_line(crossing.as_dict()) for crossing in crossings] + [truth_line(snapshot.as_dict())]


def truth_line(content: Mapping[str, Any]) -> str:
    """Returns the line of a header, a crossing or a snapshot."""
    return json.dumps(content, allow_nan=False) + "\n"
