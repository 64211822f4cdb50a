"""Frozen records of a radar and a fidelity as plain data for JSON, and back, exact to the bit.

A record becomes a mapping with its class under `type`, by a name that stays where its module moves; a number that JSON does not
have becomes its text. Lists come back as tuples, as these records have no lists.
"""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

from radar_service.recording.error import RecordingError

HOMES = ("radar_service.radar.", "radar_service.fidelity.")  # as files name them, of the classes that are made again
LEFT_OUT = ("type", "origin")  # of a record; earlier versions had an origin of the rotation, which spokes tell themselves
MOVED = {  # where a class is that files name as it was
    "radar_service.fidelity.Fidelity": "radar_service.records.fidelity.Fidelity",
    "radar_service.radar.structures.Structure": "radar_service.stages.structures.structure.Structure",
    "radar_service.radar.parameters.MultipleEchoes": "radar_service.stages.multiple_echoes.effect.MultipleEchoes",
}
EFFECTS = {"structures": (), "multiple": None}  # of a radar, that all files tell of among its fields; of others, none does


def plain(value: Any) -> Any:
    """Returns a record, or what its fields hold, as plain data."""
    if is_dataclass(value) and not isinstance(value, type):
        kind = type(value)
        return {"type": _name_of(kind), **{name: plain(held) for name, held in _contents(value).items()}}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return {"type": "float", "value": repr(value)}
    return value


def restored(value: Any) -> Any:
    """Returns what `plain` was given. Raises RecordingError for a class that is no record of a radar or a fidelity."""
    if isinstance(value, list):
        return tuple(restored(item) for item in value)
    if not isinstance(value, Mapping):
        return value
    content = {key: restored(item) for key, item in value.items() if key not in LEFT_OUT}
    if value.get("type") == "float":
        return float(content["value"])
    kind = _record_class(str(value.get("type")))
    if "effects" in {field.name for field in fields(kind)}:
        of_effects = {name: content.pop(name) for name in EFFECTS if name in content}
        content["effects"] = {name: held for name, held in of_effects.items() if held != EFFECTS[name]}
    try:
        return kind(**content)
    except TypeError as error:  # another version has other fields
        raise RecordingError(f"{value.get('type')}: {error}; read it with the version that recorded it") from None


def _contents(record: Any) -> dict[str, Any]:
    """What the fields of a record hold, by their names; EFFECTS in place of all effects."""
    contents = dict[str, Any]()
    for field in fields(record):
        held = getattr(record, field.name)
        is_effects = field.name == "effects"
        contents |= {name: held.get(name, EFFECTS[name]) for name in EFFECTS} if is_effects else {field.name: held}
    return contents


def _name_of(kind: type[Any]) -> str:
    """The name of a class in files."""
    here = f"{kind.__module__}.{kind.__qualname__}"
    return next((name for name, home in MOVED.items() if home == here), here)


def _record_class(name: str) -> type[Any]:
    module, _, last = MOVED.get(name, name).rpartition(".")
    if name.startswith(HOMES):
        try:
            kind = getattr(import_module(module), last)
        except (ImportError, AttributeError):
            kind = None
        if isinstance(kind, type) and is_dataclass(kind):
            return kind
    raise RecordingError(f"type: {name[:80]} is no record of a radar; read it with the version that recorded it")
