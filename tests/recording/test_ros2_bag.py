"""A ROS 2 bag, read by the definitions that it holds itself: reflectors and own ship against the truth."""

import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from radar_service.__main__ import main
from radar_service.recording.recording_file import RecordingFile
from radar_service.recording.ros2_bag import PROFILE, Ros2Bag
from tests.ports.reflectors import START, batches, crossings, radar_of, simulator

SIZES = {"int32": "i", "uint32": "I", "float32": "f", "float64": "d"}


class Reader:
    """Reads a message of CDR by the text of its definition."""

    def __init__(self, text: str, content: bytes) -> None:
        assert content[:4] == b"\0\1\0\0"
        first, *others = text.split("=" * 80 + "\n")
        self._types = {"": first.splitlines()}
        for other in others:
            name, *fields = other.splitlines()
            self._types[name.removeprefix("MSG: ").split("/")[-1]] = fields
        self._content, self._at = content[4:], 0
        self.message = self._record("")
        assert self._at == len(self._content)

    def _record(self, name: str) -> dict[str, Any]:
        return {field.split()[1]: self._value(field.split()[0]) for field in self._types[name.split("/")[-1]]}

    def _value(self, kind: str) -> Any:
        if kind.endswith("]"):
            base, count = kind[:-1].split("[")
            return [self._value(base) for _ in range(int(count) if count else self._value("uint32"))]
        if kind == "string":
            size = self._value("uint32")
            self._at += size
            return self._content[self._at - size : self._at - 1].decode()
        if kind not in SIZES:
            return self._record(kind)
        size = struct.calcsize(SIZES[kind])
        self._at += -self._at % size + size
        return struct.unpack_from(f"<{SIZES[kind]}", self._content, self._at - size)[0]


def test_reflectors_and_own_ship_stand_where_the_truth_has_them(tmp_path: Path) -> None:
    source = simulator()
    radar = radar_of(source)
    with RecordingFile(tmp_path / "bag.mcap", profile=PROFILE) as file:
        bag = Ros2Bag(file)
        bag.open_epoch(radar)
        for batch in batches(radar, source):
            bag.send(batch)
    got: dict[str, list[dict[str, Any]]] = {}
    with (tmp_path / "bag.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        for schema, channel, message in reader.iter_messages():
            assert schema is not None and (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            got.setdefault(channel.topic, []).append(Reader(schema.data.decode(), message.data).message)
    angles = np.concatenate(
        [s["angle_start"] + s["angle_increment"] * np.arange(len(s["intensities"])) for s in got["/radar/data"]]
    )
    image = np.array([ray["echoes"] for sector in got["/radar/data"] for ray in sector["intensities"]])
    first, last = got["/radar/data"][0]["range_min"], got["/radar/data"][0]["range_max"]
    ranges = np.linspace(first, last, image.shape[1])
    assert len(angles) == 720 and np.allclose(ranges, source.range, atol=1e-3)
    for crossing in crossings(source):
        near = abs(ranges - crossing["range"]) < 30.0
        ray, cell = np.unravel_index(np.argmax(np.where(near, image, -1.0)), image.shape)
        assert abs(ranges[cell] - crossing["range"]) <= source.range_step / 2 + 1e-3
        assert abs(math.remainder(angles[ray] + crossing["relative_bearing"], 2 * math.pi)) < math.pi / 720 + 1e-3
    truth, odometry, tf = source.truth(0.0).own_ship, got["/odom"][-1], got["/tf"][0]["transforms"]
    yaw = 2.0 * math.atan2(tf[0]["transform"]["rotation"]["z"], tf[0]["transform"]["rotation"]["w"])
    assert math.remainder(math.pi / 2 - truth.heading - yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert [(each["header"]["frame_id"], each["child_frame_id"]) for each in tf] == [
        ("map", "base_link"),
        ("base_link", "radar"),
    ]
    assert tf[1]["transform"]["translation"]["z"] == 10.0
    assert odometry["twist"]["twist"]["angular"]["z"] == pytest.approx(math.radians(3.0))  # to port
    assert got["/clock"][0]["clock"] == {"sec": round(START.timestamp()), "nanosec": 0}


def test_speed_is_ahead_and_to_port(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By the command. The ship makes 10 knots over ground to the east and heads 060: a drift of 30 degrees to starboard."""
    scene = """[radar]
azimuths = 8
range_max_m = 500
coarse_azimuths = true
[own_ship]
course_deg = 90
heading_deg = 60
speed_kn = 10
"""
    (tmp_path / "scene.toml").write_text(scene)
    words = ["record", str(tmp_path / "scene.toml"), "--ros2", "-o", str(tmp_path / "bag.mcap")]
    assert main(words) == 0 and main([*words, "--truth", "--overwrite"]) == 2
    assert "a bag has neither truth nor labels" in capsys.readouterr().err
    with (tmp_path / "bag.mcap").open("rb") as stream:
        ((schema, _, message),) = make_reader(stream).iter_messages(topics=["/odom"])
    assert schema is not None
    odometry = Reader(schema.data.decode(), message.data).message
    assert odometry["pose"]["pose"]["position"] == {"x": 0.0, "y": 0.0, "z": 0.0}  # at the first of its spokes
    linear = odometry["twist"]["twist"]["linear"]
    speed = 10 * 1852 / 3600
    assert linear["x"] == pytest.approx(speed * math.cos(math.radians(30)))
    assert linear["y"] == pytest.approx(-speed * math.sin(math.radians(30)))
