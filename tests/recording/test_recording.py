"""A recording in process: the spokes, scans and truth of the simulator that it was made of, to the bit."""

import errno
import json
from dataclasses import replace
from itertools import islice
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

import radar_service as rs
from radar_service import wire
from radar_service.__main__ import main
from radar_service.commands.record import record_scans
from radar_service.display.video import Controls
from radar_service.recording import Recording, RecordingError, read
from radar_service.recording.chunk_table import ChunkTable, epochs_of, radars_with_epoch, recorded_radars
from radar_service.recording.json_schema import COMPRESSED_IMAGE, SCENE, schema_of, truth_schema
from radar_service.recording.plain import plain, restored
from radar_service.recording.radar_recording import RadarRecording
from radar_service.recording.recording_file import RecordingFile
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.fidelity import PRESETS
from radar_service.records.spokes import Spoke
from radar_service.records.truth import Crossing
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world.commands import CommandLog
from tests.limits import full_disk
from tests.recording.scenes import AZIMUTHS, MOVING, SEED, recorded, simulator
from tests.scenes import radar
from tests.service.fake import FakeEngine, labels_of, scene


def test_blocks_spokes_and_scans_are_those_of_the_simulator(recording: Path) -> None:
    result, made = read(recording), simulator()
    for stored, expected in zip(result.blocks(), made.blocks(3), strict=True):
        for name, value in vars(expected).items():
            np.testing.assert_array_equal(getattr(stored, name), value, err_msg=name)
        assert stored.field.dtype == expected.field.dtype and stored.power.dtype == expected.power.dtype
    made.skip_to(0)
    for one, other in zip(result.spokes(), made.spokes(3), strict=True):
        assert isinstance(one, Spoke) and (one.number, one.azimuth) == (other.number, other.azimuth)
    made.skip_to(0)
    assert [scan.field.tobytes() for scan in result.scans()] == [made.scan().field.tobytes() for _ in range(3)]


def test_labels_and_powers_are_those_of_the_simulator(labelled_recording: Path, recording: Path) -> None:
    result, made = read(labelled_recording), simulator()
    made.request_sources(True, (256, 257))
    assert result.sources.names == made.label_names == result.label_names
    for stored, expected in zip(result.spokes(), made.spokes(3), strict=True):
        assert stored.labels is not None and stored.powers is not None
        assert expected.labels is not None and expected.powers is not None
        assert stored.labels.dtype == np.uint32 and stored.labels.tobytes() == expected.labels.tobytes()
        assert {number: power.tobytes() for number, power in stored.powers.items()} == {
            number: power.tobytes() for number, power in expected.powers.items()
        }
        assert stored.field.tobytes() == expected.field.tobytes()
    late = next(read(labelled_recording, start=2.3).spokes())
    (expected,) = [spoke for spoke in result.spokes() if spoke.number == late.number]
    assert late.time >= 2.3 and late.labels is not None and late.labels.tobytes() == expected.labels.tobytes()  # type: ignore[union-attr]
    result.skip_to(2)
    assert next(result.spokes()).scan == 2
    plain = read(recording)
    assert next(plain.spokes()).labels is None and plain.label_names == {}
    with pytest.raises(ValueError, match="labels: the recording has none; record them with --labels, or leave labels out"):
        plain.sources.check(SourceRequest(labels=True))


def test_labels_change_nothing_else_of_a_recording(labelled_recording: Path, recording: Path) -> None:
    def feed(path: Path) -> list[dict[str, object]]:
        return [
            {key: value for key, value in wire.unpack(message.data).items() if key not in ("epoch", "clocks")}
            for message in ChunkTable(path).messages("/radar/0/feed")
        ]

    plain, labelled = feed(recording), feed(labelled_recording)
    assert plain[1:] == labelled[1:] and "sources" not in plain[0]
    assert "/radar/0/sources" not in ChunkTable(recording).channels


def test_each_epoch_has_its_own_labels(tmp_path: Path) -> None:
    """Both epochs lie in one chunk, and both count from 0."""
    engine = FakeEngine(scene())
    engine.request_sources(labels=True)
    with RecordingFile(tmp_path / "a.mcap") as file:
        recording = RadarRecording(file, "0", False, SourceRequest(labels=True))
        for name, number in (("first", 0), ("second", 7)):
            controls = {"pace": {"state": "run", "factor": "max"}}
            epoch = Epoch(name, engine, None)
            recording.open_epoch(RadarInfo("0", "r", epoch, 0.1 * number, controls, False))
            recording.send(SpokeBatch(epoch, 0, engine.block(number, 5), Controls()))
    for k, number in enumerate((0, 7)):
        (block,) = read(tmp_path / "a.mcap", epoch=k).blocks()
        np.testing.assert_array_equal(block.labels, labels_of(number + np.arange(5), len(block.range)))


def test_spokes_whose_labels_are_missing_are_an_error(labelled_recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = read(labelled_recording)
    monkeypatch.setattr(result, "_source_messages", lambda: iter(()))
    with pytest.raises(RecordingError, match="sources: those of spoke 0 are missing; copy the file again"):
        next(result.spokes())


def test_the_attributes_are_those_of_the_simulator(recording: Path) -> None:
    result, made = read(recording), simulator()
    assert result.scene.radar == made.scene.radar and result.scene.origin == made.scene.origin
    for name in ("seed", "fidelity", "noise_power", "range_step"):
        assert getattr(result, name) == getattr(made, name)
    assert result.range.tobytes() == made.range.tobytes()
    assert result.info.plan.keys() == made.plan.as_dict().keys()
    assert result.info.plan["arithmetic"] == made.plan.arithmetic
    assert result.record["document"]["body"][0]["name"] == "a"
    assert "two ships" in repr(result)
    result.close()
    assert len(list(result.spokes())) == 3 * AZIMUTHS


@pytest.mark.parametrize("fidelity", ["documented", "fast"])
def test_power_that_is_not_the_square_of_the_field_is_recorded_too(fidelity: str, tmp_path: Path) -> None:
    result, made = read(recorded(tmp_path / "one.mcap", 1, fidelity)), simulator(fidelity)
    (stored,), expected = result.scans(), made.scan()
    assert stored.field.tobytes() == expected.field.tobytes() and stored.power.tobytes() == expected.power.tobytes()


def test_reading_starts_at_a_time_and_at_a_scan(recording: Path) -> None:
    whole = list(read(recording).spokes())
    for start in (0.0, whole[70].time, whole[70].time - 1e-6, whole[-1].time, whole[-1].time + 1.0):
        got = [spoke.number for spoke in read(recording, start=start).spokes()]
        assert got == [spoke.number for spoke in whole if spoke.time >= start]
    result = read(recording)
    result.skip_to(2)
    assert next(result.spokes()).number == 2 * AZIMUTHS


def test_blocks_have_the_size_that_is_requested(recording: Path) -> None:
    assert [len(block) for block in islice(read(recording).blocks(size=24), 4)] == [24, 24, 16, 24]


def test_the_truth_of_each_scan_is_read(recording: Path) -> None:
    result, made = read(recording), simulator()
    for scan in range(3):
        records = [*made.crossings(scan), made.snapshot(scan)]
        assert [json.loads(line.text) for line in result.truth_lines(scan)] == [
            json.loads(json.dumps(record.as_dict())) for record in records
        ]
    assert len(list(result.crossings())) == sum(len(result.truth_lines(scan)) for scan in range(3)) >= 6
    assert json.loads(result.truth_lines(None)[0].text)["scene_hash"] == made.truth_header()["scene_hash"]
    assert result.truth_lines(7) == []


def test_the_truth_of_every_instant_was_not_recorded(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(SpokeSourceFault, match="the truth of beam crossings"):
        read(recording).truth(1.0)
    silent = read(recorded(tmp_path / "silent.mcap", 1, with_truth=False))
    assert silent.truth_lines(None) == silent.truth_lines(0) == [] and not list(silent.crossings())


def test_what_the_recording_lacks_is_named(recording: Path) -> None:
    with pytest.raises(RecordingError, match='radar: the recording has no "north"; it has 0'):
        read(recording, radar="north")
    with pytest.raises(RecordingError, match="epoch: 1 is not in .* which has 1 of radar 0"):
        read(recording, epoch=1)


def test_epochs_and_gaps_are_kept_apart(tmp_path: Path) -> None:
    """Two epochs, the second with a shorter display range; in the first a gap within a scan."""
    engine = FakeEngine(scene())
    with RecordingFile(tmp_path / "two.mcap") as file:
        recording = RadarRecording(file, "1", True)
        for name, reach, numbers in (("first", None, (0, 5, 16, 24)), ("second", 100.0, (0, 5, 10))):
            epoch = Epoch(name, engine, reach)
            recording.open_epoch(RadarInfo("1", "one", epoch, 0.0, {"pace": {}}, True))
            for first in numbers:
                recording.send(SpokeBatch(epoch, first, engine.block(first, 5), Controls()))
                if first == 5 and name == "first":
                    recording.skip(name, 10, 6, "the engine was started again")
    one, two = Recording(tmp_path / "two.mcap", "1"), Recording(tmp_path / "two.mcap", "1", 1)
    assert one.epochs == two.epochs == 2
    assert [(block.first, len(block)) for block in one.blocks(size=32)] == [(0, 10), (16, 5), (24, 5)]
    assert [block.first for block in two.blocks()] == [0] and len(two.range) == 10
    np.testing.assert_array_equal(next(two.blocks()).power, engine.block(0, 15).power[:, :10])
    assert two.record["log_offset"] > 0 and [scan.number for scan in one.scans()] == [0, 1]
    assert np.isnan(next(one.scans()).time).sum() == 24 - 15


def test_commands_of_an_epoch_that_opens_within_a_scan_are_its_own(tmp_path: Path) -> None:
    """Both epochs share a chunk of the file, and the later one begins with all commands so far."""
    scene = {**MOVING, "own_ship": {**MOVING["own_ship"], "steerable": {}}}
    steered = rs.Simulator(rs.load_scene(scene), "fast", SEED)
    steered.command(spoke=3, course_deg=90)
    log = CommandLog(steered.scene.steerable, steered.commands)
    blocks = steered.blocks(scans=1, size=8)
    with RecordingFile(tmp_path / "a.mcap") as file:
        recording = RadarRecording(file, "0", False)
        for name, range_max in (("one", None), ("two", 100.0)):
            epoch = Epoch(name, steered, range_max, log)
            recording.open_epoch(RadarInfo("0", "one", epoch, 0.0, {"pace": {}}, True))
            recording.send(SpokeBatch(epoch, 0, next(blocks), Controls()))
            log.add(steered.command(spoke=40, speed_kn=3))
    first, second = (Recording(tmp_path / "a.mcap", epoch=number) for number in (0, 1))
    assert [command.spoke for command in first.commands] == [3]
    assert [command.spoke for command in second.commands] == [3, 40]


def test_commands_are_recorded_and_the_engine_gives_the_same_bytes_with_them(tmp_path: Path) -> None:
    """What the recording holds makes a simulator again: document, fidelity, seed and commands, some of them while it runs."""
    scene = {**MOVING, "own_ship": {**MOVING["own_ship"], "steerable": {}}}
    steered = rs.Simulator(rs.load_scene(scene), "balanced", SEED)
    steered.command(spoke=20, course_deg=90, turn_rate_deg_s=3)
    steered.command(spoke=100, speed_kn=15)
    path = tmp_path / "steered.mcap"
    with RecordingFile(path) as file:
        record_scans(RadarRecording(file, "0", False), steered, scene, 3, False)
    result = read(path)
    assert [command.as_dict() for command in result.commands] == [command.as_dict() for command in steered.commands]
    again = rs.Simulator(rs.load_scene(result.record["document"]), result.fidelity, result.seed, commands=result.commands)
    for scan in result.scans():
        assert scan.field.tobytes() == again.scan().field.tobytes()
    assert read(recorded(tmp_path / "plain.mcap", 1)).commands == ()


# json_schema: the schemas describe what the channels hold.
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


# mcap_library: without the package `mcap` a clear error, and everything else works: tests/terminal/test_extras.py.


# error: the error of a recording is a ValueError, and reading is what the package exports.
def test_the_error_is_a_value_error() -> None:
    assert issubclass(RecordingError, ValueError)
    assert read is Recording


# chunk_table: the epochs of a recording.
def written(path: Path, *scenes: dict[str, object]) -> ChunkTable:
    """A file with the scenes of a radar and nothing else, each in a chunk of its own."""
    with RecordingFile(path) as file:
        file.channel("/radar/west/feed", "msgpack")
        write = file.channel("/radar/west/scene", "json")
        for scene in scenes:
            write(0.0, 0.0, json.dumps(scene).encode())
            file.flush()
    return ChunkTable(path)


def test_an_epoch_reaches_into_the_chunk_of_the_next(tmp_path: Path) -> None:
    table = written(tmp_path / "a.mcap", {"format": 1, "epoch": "x"}, {"format": 1, "epoch": "y"})
    assert recorded_radars(table) == ["west"]
    assert [(epoch.name, list(epoch.chunks)) for epoch in epochs_of(table, "west")] == [("x", [0, 1]), ("y", [1])]


def test_another_format_is_refused(tmp_path: Path) -> None:
    table = written(tmp_path / "a.mcap", {"format": 2, "epoch": "x"})
    with pytest.raises(RecordingError, match="format: 2 is not 1; read it with the version that recorded it"):
        epochs_of(table, "west")


def test_another_radar_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match='has no "0"; it has west'):
        epochs_of(written(tmp_path / "a.mcap", {"format": 1, "epoch": "x"}), "0")


def test_a_radar_whose_epoch_was_cut_off_is_left_out(tmp_path: Path) -> None:
    with RecordingFile(path := tmp_path / "two.mcap") as file:
        writers = {}
        for radar in ("east", "west"):
            file.channel(f"/radar/{radar}/feed", "msgpack")
            writers[radar] = file.channel(f"/radar/{radar}/scene", "json")
        for radar, epoch in (("east", "x"), ("west", "x"), ("west", "y")):
            writers[radar](0.0, 0.0, json.dumps({"format": 1, "epoch": epoch}).encode())
            file.flush()
    table = ChunkTable(path)
    assert [radars_with_epoch(table, number) for number in range(3)] == [["east", "west"], ["west"], ["east", "west"]]
    path.write_bytes(path.read_bytes()[: table.chunks[1].offset])
    cut = ChunkTable(path)
    assert recorded_radars(cut) == ["east", "west"] and radars_with_epoch(cut, 0) == ["east"]


# plain: records as plain data and back.
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


# recording_file: the file: what other readers of MCAP find in it, and what happens where the disk refuses.
def test_another_reader_finds_channels_times_and_messages(tmp_path: Path) -> None:
    with RecordingFile(tmp_path / "a.mcap") as file:
        plain, described = file.channel("/x", "msgpack"), file.channel("/y", "json", {"title": "Y", "type": "object"})
        plain(1.5, 0.5, b"one")
        described(2.0, 1.0, b"{}")
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        got = [
            (schema and schema.name, channel.topic, m.log_time, m.publish_time, m.data)
            for schema, channel, m in reader.iter_messages()
        ]
        assert reader.get_header().profile == "radar-service"
    assert got == [(None, "/x", 1_500_000_000, 500_000_000, b"one"), ("Y", "/y", 2_000_000_000, 1_000_000_000, b"{}")]


def test_a_full_disk_names_the_file_and_closing_says_no_more(tmp_path: Path) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    with RecordingFile(path) as file:
        write = file.channel("/x", "msgpack")
        with pytest.raises(OSError, match="No space left on device") as caught:
            write(0.0, 0.0, bytes(2**20))
            file.flush()
        assert caught.value.errno == errno.ENOSPC and caught.value.filename == str(path)


def test_the_command_tells_a_limit_of_file_sizes_and_the_rest_opens(
    tmp_path: Path, one_target: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As a full disk: a file may have 300 kB."""
    with full_disk(300_000):
        assert main(["record", str(one_target), "--scans", "9", "-o", str(tmp_path / "a.mcap")]) == 2
    assert f"{tmp_path / 'a.mcap'}: File too large" in capsys.readouterr().err
    spokes = len(list(read(tmp_path / "a.mcap").spokes()))
    assert spokes and spokes % 60 == 0
