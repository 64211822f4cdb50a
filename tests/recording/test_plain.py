"""Records as plain data and back."""

import json
from dataclasses import replace
from math import inf
from typing import Any

import pytest

from radar_service.recording import RecordingError
from radar_service.recording.plain import plain, restored
from radar_service.records.fidelity import PRESETS
from tests.scenes import radar

MAST = [{"bearing_deg": 0, "distance_m": 3, "width_m": 0.2}]


@pytest.mark.parametrize(
    "record",
    [*PRESETS.values(), radar(),
     radar(structure=MAST, multiple_echoes={"own_rcs_dbsm": 30}), radar(structure=MAST),
     radar(pattern="taylor", blind_sectors_deg=[[10, 20.1], [80, 90]], beamwidth_deg=3.3),
     radar(pattern=[[0, 0], [3, -3], [10, -30]], beamwidth_deg=6)],
)  # fmt: skip
def test_a_record_comes_back_to_the_bit(record: object) -> None:
    assert restored(json.loads(json.dumps(plain(record), allow_nan=False))) == record


def types_in(value: Any) -> set[str]:
    """The names of all classes in plain data."""
    if isinstance(value, dict):
        return {value["type"], *(name for part in value.values() for name in types_in(part))} if "type" in value else set()
    return {name for part in value for name in types_in(part)} if isinstance(value, list) else set()


def test_files_of_other_versions_name_the_classes_as_this_one_does() -> None:
    """Whatever module they are in: a recording is read by later versions."""
    assert types_in(plain(PRESETS["balanced"])) == {"radar_service.fidelity.Fidelity"}
    assert types_in(plain(radar(pattern="taylor", tilt_deg=1))) == {
        "radar_service.radar.parameters.Radar", "radar_service.radar.patterns.Taylor",
    }  # fmt: skip
    behind = plain(radar(structure=MAST, multiple_echoes={"own_rcs_dbsm": 30}))
    assert [*behind][-5:] == ["structures", "multiple", "label_floor", "integration", "scales"]
    assert types_in([behind["structures"], behind["multiple"]]) == {
        "radar_service.radar.structures.Structure", "radar_service.radar.parameters.MultipleEchoes", "float",
    }  # fmt: skip
    assert plain(radar())["structures"] == [] and plain(radar())["multiple"] is None


def test_an_origin_of_the_rotation_that_earlier_versions_recorded_is_left_out() -> None:
    origin = {"type": "radar_service.radar.parameters.Origin", "time": 7.5, "scan": 3}
    assert restored(plain(radar()) | {"origin": origin}) == radar()


def test_only_records_of_radars_are_made() -> None:
    for kind in ("subprocess.Popen", "radar_service.radar.parameters.horizon", "radar_service.radar.nothing.X", ""):
        with pytest.raises(RecordingError, match="is no record of a radar"):
            restored({"type": kind, "args": "x"})


def test_fields_of_another_version_are_named() -> None:
    with pytest.raises(RecordingError, match="colour.*read it with the version that recorded it"):
        restored(plain(PRESETS["fast"]) | {"colour": 1})


def test_infinity_has_a_place_in_json() -> None:
    assert plain(replace(PRESETS["fast"], beam_extent=inf))["beam_extent"] == {"type": "float", "value": "inf"}
