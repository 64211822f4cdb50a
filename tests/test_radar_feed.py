"""Radars for tests of trackers: the same scans and crossings in process and from a service."""

import signal
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar_feed import ProcessFeed, RadarFeeds, WebsocketFeed, crossing_from_line, service
from tests.recording.scenes import AZIMUTHS, MOVING
from tests.scenes import TWO_RADARS


def test_scans_and_crossings_are_those_of_a_simulator() -> None:
    with RadarFeeds() as feeds:
        feed = feeds(MOVING, seed=4, fidelity="fast")
        made = rs.Simulator(rs.load_scene(MOVING), "fast", 4)
        for scan in feed.scans(2):
            assert scan.field.tobytes() == made.scan().field.tobytes()
            assert feed.crossings[-len(made.crossings()) :] == list(made.crossings())
        assert [scan.number for scan in feed.scans(1)] == [2]


def test_a_service_gives_the_same_from_spoke_0_on() -> None:
    """Over sockets: fields, labels, powers and truth to the bit, angles rounded as on the wire."""
    with RadarFeeds() as feeds:
        own, feed = (feeds(MOVING, seed=4, over=over, labels=True, powers=(256,)) for over in ("process", "websocket"))
        assert isinstance(own, ProcessFeed) and isinstance(feed, WebsocketFeed)
        assert own.label_names == feed.label_names and own.label_names[256] == "a"
        for one, other in zip(own.scans(3), feed.scans(3), strict=True):
            assert other.field.tobytes() == one.field.tobytes() and other.power.tobytes() == one.power.tobytes()
            np.testing.assert_array_equal(other.azimuth, one.azimuth)
            np.testing.assert_array_equal(other.time, one.time)
            np.testing.assert_allclose(other.heading, one.heading, atol=np.pi / 65536)  # half a wire unit
            np.testing.assert_allclose(other.range, one.range, rtol=1e-15)  # rounding
            assert feed.crossings == own.crossings
            assert one.labels is not None and other.labels is not None
            assert other.labels.tobytes() == one.labels.tobytes() and (one.labels == 256).any()
            assert one.powers is not None and other.powers is not None and other.powers.keys() == one.powers.keys()
            assert other.powers[256].tobytes() == one.powers[256].tobytes()
        assert len(feed.crossings) >= 5 and feed.hello["radar"]["azimuths"] == AZIMUTHS


def test_a_crossing_that_an_earlier_version_recorded_has_a_level_boresight() -> None:
    (made, *_) = rs.Simulator(rs.load_scene(MOVING), "fast").crossings(0)
    line = made.as_dict()
    assert crossing_from_line(line) == made
    del line["boresight"]
    assert crossing_from_line(line) == replace(made, boresight=made.bearing)


@pytest.mark.parametrize("over", ["process", "websocket"])
def test_each_radar_of_a_scene_can_be_taken(over: Literal["process", "websocket"]) -> None:
    """The pier's radar turns twice as fast, and meets the tug that carries the other one."""
    expected = rs.Simulator(rs.load_scene(TWO_RADARS), "fast", 4, radar="pier")
    with RadarFeeds() as feeds:
        pier = feeds(TWO_RADARS, seed=4, over=over, fidelity="fast", radar="pier")
        first = feeds(TWO_RADARS, seed=4, fidelity="fast")
        scans = list(pier.scans(2))
        assert [scan.power.tobytes() for scan in scans] == [expected.scan().power.tobytes() for _ in scans]
        assert {crossing.body for crossing in pier.crossings} == {"tug", "p"}
        (bow,) = first.scans(1)
        assert bow.time[-1] - bow.time[0] == pytest.approx(2 * (scans[0].time[-1] - scans[0].time[0]))


@pytest.mark.parametrize("over", ["process", "websocket"])
def test_an_unknown_radar_is_refused_with_the_ids(over: Literal["process", "websocket"]) -> None:
    with RadarFeeds() as feeds, pytest.raises(rs.SceneError, match='radar: "shore" is not .* it has bow, pier: give one of'):
        feeds(TWO_RADARS, over=over, radar="shore")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"over": "air"}, 'over: "air" is not one of process, websocket'),
        ({"pace": 1.0}, "pace: 1.0 has no effect in process"),
        ({"powers": True}, "powers: True is not allowed"),
        ({"powers": (7,), "fidelity": "fast"}, "powers: 7 is no source of this scene"),
        ({"labels": True, "fidelity": "documented"}, "labels: the fidelity 'documented' has none"),
        ({"scene": rs.load_scene(MOVING), "over": "websocket"}, "scene: a service reads a file or a mapping"),
    ],
)
def test_what_is_not_allowed_is_named(options: dict[str, Any], words: str) -> None:
    with RadarFeeds() as feeds, pytest.raises(ValueError, match=words):
        feeds(**{"scene": MOVING} | options)


def test_a_service_that_does_not_stop_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (program := tmp_path / "deaf").write_text("#!/bin/sh\ntrap '' TERM\necho open http://here/\nexec sleep 9\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr("radar_service.radar_feed.STOP_TIMEOUT", 0.01)
    with service(MOVING, 0, "max", "auto") as running:
        assert running.address == "here" and running.end is None
    assert running.process.returncode == -signal.SIGKILL


def test_a_service_that_is_silent_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (program := tmp_path / "silent").write_text("#!/bin/sh\nexec sleep 30\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr("radar_service.radar_feed.START_TIMEOUT", 0.01)
    with pytest.raises(RuntimeError, match="it has not told its address within 0.01 s"), service(MOVING, 0, "max", "auto"):
        pass


def test_a_service_that_does_not_start_says_why() -> None:
    with RadarFeeds() as feeds, pytest.raises(RuntimeError, match="the service did not start: .*body\\[0\\].mesh"):
        feeds({"name": "bad", "body": [{"name": "b", "mesh": "none.obj"}]}, over="websocket")
