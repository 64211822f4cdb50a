"""JSON Schemas of the channels of a recording, which viewers need to plot their fields."""

import types
from dataclasses import fields, is_dataclass
from typing import Any, Union, get_args, get_origin, get_type_hints

from radar_service.records import Crossing, Snapshot
from radar_service.stages.registry import own_effects
from radar_service.world import KEYS, Command

NAMES: dict[type, str] = {float: "number", int: "integer", str: "string", bool: "boolean", type(None): "null"}


def schema_of(kind: Any) -> dict[str, Any]:
    """Returns the schema of a type that records have: a number, a text, an optional one, a tuple, or a record."""
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        properties = {field.name: schema_of(hints[field.name]) for field in fields(kind) if field.name != "effects"}
        return {"type": "object", "properties": properties}
    if get_origin(kind) in (Union, types.UnionType):
        return {"anyOf": [schema_of(member) for member in get_args(kind)]}
    if get_origin(kind) is tuple:
        return {"type": "array", "items": schema_of(get_args(kind)[0])}
    return {"type": NAMES[kind]}


def truth_schema() -> dict[str, Any]:
    """Returns the schema of the truth's lines; a header has other fields, and effects of other packages have more."""
    either = {**schema_of(Snapshot)["properties"], **schema_of(Crossing)["properties"]}
    either |= {
        effect.name: schema_of(effect.crossing_record) for effect in own_effects() if is_dataclass(effect.crossing_record)
    }
    properties = {"type": {"enum": ["header", "crossing", "snapshot"]}, **either}
    return {"title": "radar_service.Truth", "type": "object", "properties": properties, "required": ["type"]}


def scene_schema(with_sources: bool) -> dict[str, Any]:
    """Returns the schema of the scene's messages. with_sources: whether they have the table of sources."""
    more = {"sources": {"type": "object"}} if with_sources else {}
    return SCENE | {"properties": SCENE["properties"] | more}


SCENE: dict[str, Any] = {
    "title": "radar_service.Scene",
    "type": "object",
    "properties": {
        "format": {"type": "integer"},
        "epoch": {"type": "string"},
        "log_offset": {"type": "number", "description": "log time of the epoch less its simulated time [s]"},
        "seed": {"type": "integer"},
        "noise_power": {"type": "number", "description": "of a range cell [W]"},
        **{
            name: {"type": "object"}
            for name in ("outline", "radar", "cells", "fidelity", "plan", "document", "files", "truth_header", "controls")
        },
    },
    "required": ["format", "epoch"],
}

COMMAND: dict[str, Any] = {
    "title": "radar_service.Command",
    "type": "object",
    "properties": {
        "epoch": {"type": "string", "description": "the name of the epoch whose spokes follow it"},
        "spoke": {"type": "integer", "description": "the first one that follows it"},
        "time": {"type": "number"},
        "body": {"type": ["string", "null"], "description": "null is own ship"},
        **{name: schema_of(get_args(kind)[0]) for name, kind in get_type_hints(Command).items() if name in KEYS},
        "by": {"type": "string", "description": "what sent it: rest, poses or nmea"},
    },
    "required": ["spoke", "time"],
}

# Names and meaning of the fields: https://docs.foxglove.dev/docs/sdk/schemas/compressed-image
COMPRESSED_IMAGE: dict[str, Any] = {
    "title": "foxglove.CompressedImage",
    "type": "object",
    "properties": {
        "timestamp": {
            "title": "time",
            "type": "object",
            "properties": {
                "sec": {"type": "integer", "minimum": 0},
                "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
            },
        },
        "frame_id": {"type": "string"},
        "data": {"type": "string", "contentEncoding": "base64"},
        "format": {"type": "string"},
    },
    "required": ["timestamp", "frame_id", "data", "format"],
}
