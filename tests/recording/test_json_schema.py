"""The schemas describe what the channels hold."""

import json
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.json_schema import COMPRESSED_IMAGE, SCENE, schema_of, truth_schema
from radar_service.records.truth import Crossing


@pytest.mark.parametrize(("channel", "schema"), [("scene", SCENE), ("truth", truth_schema()), ("ppi", COMPRESSED_IMAGE)])
def test_every_message_fits_its_schema(channel: str, schema: dict[str, object], recording: Path) -> None:
    table = ChunkTable(recording)
    lines = [json.loads(message.data) for message in table.messages(f"/radar/0/{channel}")]
    assert len(lines) >= {"scene": 1, "truth": 7, "ppi": 3}[channel]
    for line in lines:
        Draft202012Validator(schema).validate(line)


def test_a_schema_knows_the_types_of_a_record() -> None:
    properties = schema_of(Crossing)["properties"]
    assert properties["range"] == {"type": "number"} and properties["scan"] == {"type": "integer"}
    assert properties["position"] == {"type": "array", "items": {"type": "number"}}
    assert properties["mmsi"] == {"anyOf": [{"type": "integer"}, {"type": "null"}]}
    assert properties["own_ship"]["properties"]["heading"] == {"type": "number"}
    assert not Draft202012Validator(truth_schema()).is_valid({"type": "crossing", "range": "far"})
