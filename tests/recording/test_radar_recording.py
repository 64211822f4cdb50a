"""The channels of a radar as another program finds them."""

import base64
import hashlib
import io
import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from PIL import Image

import radar_service as rs
from radar_service import wire
from radar_service.recording.radar_recording import RadarRecording, scene_document
from radar_service.recording.recording_file import RecordingFile
from radar_service.service.scene_request import SceneRequest
from radar_service.service.spokes import Epoch, RadarInfo
from radar_service.spoke_source import SpokeSourceFault, TruthLine
from radar_service.truth.truth_file import scene_hash
from tests.recording.scenes import AZIMUTHS, MOVING, simulator
from tests.service.fake import FakeEngine, scene


def messages(path: Path, topic: str) -> list[bytes]:
    with path.open("rb") as stream:
        return [m.data for _, _, m in make_reader(stream).iter_messages(topics=[topic], log_time_order=False)]


def test_the_feed_channel_has_the_messages_of_a_feed(recording: Path) -> None:
    hello, *rest = [wire.unpack(data) for data in messages(recording, "/radar/0/feed")]
    made = simulator()
    assert hello["type"] == "hello" and hello["encoding"]["name"] == "c64" and hello["radar"]["azimuths"] == AZIMUTHS
    assert {message["epoch"] for message in rest} == {hello["epoch"]}
    fields = np.concatenate([wire.samples(message) for message in rest])
    assert fields.tobytes() == np.concatenate([made.scan().field for _ in range(3)]).tobytes()
    headings = np.concatenate([message["heading_rad"] for message in rest])
    np.testing.assert_array_equal(wire.turn_from_radians(headings), np.concatenate([m["heading"] for m in rest]))


def test_pictures_are_those_of_a_viewer(recording: Path) -> None:
    pictures = [json.loads(data) for data in messages(recording, "/radar/0/ppi")]
    assert [picture["format"] for picture in pictures] == ["png"] * 3
    assert [picture["timestamp"]["sec"] for picture in pictures] == [1, 3, 5]  # ends of scans of 1.818 s
    image = Image.open(io.BytesIO(base64.b64decode(pictures[1]["data"])))
    assert image.size == (600, 600) and np.asarray(image.convert("RGB")).std() > 1  # it shows something


def test_log_times_go_on_where_simulated_time_starts_again(tmp_path: Path) -> None:
    engine = FakeEngine(scene())
    with RecordingFile(tmp_path / "a.mcap") as file:
        recording = RadarRecording(file, "0", False)
        for time in (0.0, 7.0, 3.0, 7.5):
            recording.open_epoch(RadarInfo("0", "r", Epoch(f"{time}", engine, None), time, {"pace": {}}, False))
    offsets = [json.loads(data)["log_offset"] for data in messages(tmp_path / "a.mcap", "/radar/0/scene")]
    assert offsets == [0.0, 0.0, 4.0, 4.0]


class WithoutTruth(FakeEngine):
    def truth_lines(self, scan: int | None) -> list[TruthLine]:
        raise SpokeSourceFault("gone")


def test_a_truth_that_is_not_to_be_had_is_left_out(tmp_path: Path) -> None:
    with RecordingFile(tmp_path / "a.mcap") as file:
        recording = RadarRecording(file, "0", True)
        recording.open_epoch(RadarInfo("0", "r", Epoch("e", WithoutTruth(scene()), None), 0.0, {"pace": {}}, True))
    assert messages(tmp_path / "a.mcap", "/radar/0/truth") == []
    assert json.loads(messages(tmp_path / "a.mcap", "/radar/0/scene")[0])["truth_header"] is None


def test_the_document_gives_the_same_scene_again(tmp_path: Path) -> None:
    (path := tmp_path / "scene.json").write_text(json.dumps(MOVING))
    document, files = scene_document(SceneRequest(path))
    assert document is not None and files == {}
    assert scene_hash(rs.load_scene(json.loads(json.dumps(document)))) == scene_hash(rs.load_scene(MOVING))


def test_the_rate_of_rotation_is_that_of_the_order() -> None:
    document, _ = scene_document(SceneRequest(MOVING, rpm=12.5))
    assert document is not None and document["radar"]["rpm"] == 12.5 and document["radar"]["azimuths"] == 64


@pytest.mark.parametrize(("radar", "rpms"), [("pier", [24, 12.5]), (None, [12.5, 48])])
def test_of_several_radars_the_rate_is_that_of_the_one_that_is_named(radar: str | None, rpms: list[float]) -> None:
    tables = [MOVING["radar"] | {"id": "bow", "rpm": 24}, MOVING["radar"] | {"id": "pier", "rpm": 48}]
    document, _ = scene_document(SceneRequest(MOVING | {"radar": tables}, rpm=12.5, radar=radar))
    assert document is not None and [table["rpm"] for table in document["radar"]] == rpms


def test_the_range_scale_of_a_set_is_that_of_the_order() -> None:
    radars = [{"set": "furuno-1824c", "id": "bow"}, {"set": "furuno-1824c", "id": "pier", "height_m": 9}]
    document, _ = scene_document(SceneRequest({"radar": radars}, range_m=1852.0, radar="pier"))
    assert document is not None and document["radar"] == [radars[0], radars[1] | {"range_max_m": 1852.0}]


def test_files_have_hashes(tmp_path: Path) -> None:
    (tmp_path / "ship.stl").write_bytes(b"solid")
    bodies = [{"name": name, "mesh": file} for name, file in (("a", "ship.stl"), ("b", "gone.stl"), ("c", "ship.stl"))]
    (path := tmp_path / "scene.json").write_text(json.dumps({"name": "s", "body": bodies}))
    _, files = scene_document(SceneRequest(path))
    assert files == {"gone.stl": None, "ship.stl": hashlib.sha256(b"solid").hexdigest()}


def test_a_scene_whose_file_has_gone_has_no_document(tmp_path: Path) -> None:
    assert scene_document(SceneRequest(tmp_path / "gone.json")) == (None, {})
