"""Errors on purpose between an engine and the sinks of the feed: which spokes pass, under which numbers, and when changes act."""

import json
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.display.video import Controls
from radar_service.numerics.types import Singles
from radar_service.records.reports import Readings
from radar_service.service.radio.error_stage import MAX_RUNS, ErrorStage, ReadingsHistory
from radar_service.service.scene_request import SceneRequest
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from radar_service.spoke_source import TruthLine
from radar_service.world.error import SceneError
from tests.errors.runs import AZIMUTHS as SIMULATED
from tests.errors.runs import SCENE, simulator
from tests.service.fake import AZIMUTHS, OWN_SHIP, FakeEngine, scene
from tests.service.radio.recording import RecordingSink

DROPPED = {"feed": {"drop_rate": 0.3}}
EVERYTHING: dict[str, Any] = {
    "profile": "imo-a823", "gyro": {"latency_s": 0.1}, "position": {"noise_m": 4},
    "feed": {"drop_rate": 0.1, "repeat_rate": 0.1, "late_rate": 0.1, "late_s": 0.2, "swap_rate": 0.1, "heading_lost_s": [[1, 2]],
             "stuck_sector_deg": [80, 120]},
}  # fmt: skip


class Played:
    """A stage between an engine and a recording sink."""

    def __init__(self, engine: Any = None) -> None:
        self.sink, self.engine = RecordingSink(), engine or FakeEngine(scene())
        self.stage = ErrorStage(self.engine, [self.sink])
        self.epoch = Epoch("one", self.engine, None)
        self.stage.open_epoch(RadarInfo.unnamed(self.epoch))
        self.first = 0

    def send(self, number: int, count: int, before: Singles | None = None) -> SpokeBatch:
        """Sends spokes of one scan as they are."""
        batch = SpokeBatch(self.epoch, self.first, self.engine.block(number, count), Controls(), before)
        self.first += count
        self.stage.send(batch)
        return batch

    @property
    def spokes(self) -> list[int]:
        """Numbers from t = 0 of all spokes that were passed on."""
        return [spoke.number for batch in self.sink.batches for spoke in batch.block.spokes()]


def test_without_errors_batches_pass_as_they_are() -> None:
    played = Played()
    sent = [played.send(0, 10), played.send(10, 14)]
    assert all(passed is batch for passed, batch in zip(played.sink.batches, sent, strict=True))
    played.stage.skip("one", 24, 5, "why")
    played.stage.close("over")
    assert played.sink.calls[-2:] == [("skip", ("one", 24, 5, "why")), ("close", "over")] and played.sink.calls[0] == (
        "open",
        "one",
    )


def test_what_is_sent_has_numbers_of_its_own_without_a_gap() -> None:
    played = Played()
    played.stage.set_errors(EVERYTHING)
    for scan in range(4):
        played.send(scan * AZIMUTHS, AZIMUTHS)
    numbers = [batch.first + k for batch in played.sink.batches for k in range(len(batch))]
    assert numbers == list(range(len(numbers)))
    assert len(set(played.spokes)) < 4 * AZIMUTHS and played.spokes != sorted(played.spokes)
    for batch in played.sink.batches:
        assert batch.block.first % AZIMUTHS == batch.block.index
    played.stage.skip("one", 4 * AZIMUTHS, 7, "a restart")
    assert played.sink.calls[-1] == ("skip", ("one", played.sink.spokes, 7, "a restart"))
    played.stage.set_errors(None)
    played.send(5 * AZIMUTHS, 3)
    assert played.sink.batches[-1].first == played.sink.spokes - 3 + 7


def test_a_change_acts_from_the_first_spoke_not_yet_sent() -> None:
    played = Played()
    played.send(0, 10)
    played.stage.set_errors({"gyro": {"bias_deg": 3}, "feed": {"drop_rate": 1}})
    played.send(10, 5)
    assert played.spokes == list(range(10)) and played.stage.errors is not None
    played.stage.set_errors({"feed": None})
    played.send(15, 2)
    played.stage.set_errors(None)
    played.send(17, 2)
    assert played.spokes == [*range(10), 15, 16, 17, 18] and played.stage.errors is None
    wrong, right = played.sink.batches[-2].block, played.sink.batches[-1].block
    np.testing.assert_allclose(wrong.heading, right.heading[0] + np.deg2rad(3), atol=1e-12)
    assert wrong.true is not None and right.true is None


def test_refused_errors_change_nothing() -> None:
    played = Played()
    played.stage.set_errors(DROPPED)
    with pytest.raises(SceneError, match="drop_rate: 2 is not allowed"):
        played.stage.set_errors({"feed": {"drop_rate": 2}})
    assert played.stage.errors is not None and played.stage.errors.feed is not None
    assert played.stage.errors.feed.drop_rate == 0.3


def test_the_spoke_before_is_that_which_the_radar_made() -> None:
    """Interference rejection acts in the radar, before spokes are lost."""
    played, before = Played(), np.full(20, 7.0, dtype=np.float32)
    played.stage.set_errors(DROPPED)
    whole = played.send(0, AZIMUTHS, before).block
    assert len(played.sink.batches) > 2
    for batch in played.sink.batches:
        assert batch.before is not None
        np.testing.assert_array_equal(batch.before, before if batch.block.first == 0 else whole.power[batch.block.first - 1])


def test_a_scene_begins_with_its_own_errors() -> None:
    played = Played()
    played.stage.set_errors(DROPPED)
    played.stage.open_epoch(RadarInfo.unnamed(Epoch("another range", played.engine, 100.0)))
    assert played.stage.errors is not None
    wrong = rs.load_scene(SCENE | {"errors": {"log": {"bias_kn": 1}}})
    for k in range(2 * MAX_RUNS):
        played.stage.open_epoch(RadarInfo.unnamed(Epoch(f"scene {k}", FakeEngine(wrong if k % 2 else scene()), None)))
        assert (played.stage.errors is not None) is bool(k % 2)


def test_an_engine_that_replaces_a_failed_one_goes_on_with_the_errors() -> None:
    played = Played()
    played.stage.set_errors(DROPPED)
    played.send(0, 5)
    other = FakeEngine(scene())
    played.stage.send(SpokeBatch(Epoch("one", other, None), 5, other.block(AZIMUTHS, 24), Controls()))
    played.stage.open_epoch(RadarInfo.unnamed(Epoch("another range", other, 100.0)))
    assert played.stage.errors is not None and len(played.spokes) < 29
    for scan in range(2, 3 * MAX_RUNS):
        other = FakeEngine(scene())
        played.stage.send(SpokeBatch(Epoch("one", other, None), 5, other.block(scan * AZIMUTHS, 24), Controls()))
    assert len(played.spokes) < 24 * 3 * MAX_RUNS - 20
    line = TruthLine(0.0, json.dumps({"type": "snapshot", "scan": 1, "own_ship": asdict(OWN_SHIP)}))
    assert "feed_errors" in played.stage.completed(other, line) and "feed_errors" not in played.stage.completed(
        played.engine, line
    )


def test_the_feed_of_the_service_is_that_of_the_simulator() -> None:
    """Spokes, own ship with latency, and every line of the truth, also after changes while the radar runs."""
    served, alone = simulator(), simulator()
    stage = ErrorStage(served, [sink := RecordingSink()])
    epoch = Epoch("one", served, None)  # type: ignore[arg-type]
    stage.open_epoch(RadarInfo.unnamed(epoch))
    expected, blocks = [], iter(served.blocks(4, size=16))
    for scan, errors in enumerate((None, EVERYTHING, {"feed": {"drop_rate": 0.5}, "gyro": None}, None)):
        alone.set_errors(errors)
        stage.set_errors(errors)
        expected += list(alone.feed(1))
        for _ in range(SIMULATED // 16):
            stage.send(SpokeBatch(epoch, 0, next(blocks), Controls()))
        records = [*alone.crossings(scan), alone.snapshot(scan)]
        true = [*served.crossings(scan), served.snapshot(scan)]
        lines = [stage.completed(served, TruthLine(r.time, json.dumps(r.as_dict()))) for r in true]  # type: ignore[arg-type]
        assert lines == [json.dumps(record.as_dict()) for record in records]
        assert ('"reported": null' in lines[0]) is (errors is None) and ("feed_errors" in lines[-1]) is (errors is not None)
    sent = [spoke for batch in sink.batches for spoke in batch.block.spokes()]
    assert len(sent) == len(expected)
    for one, other in zip(sent, expected, strict=True):
        for name in ("number", "time", "azimuth", "heading", "position", "course", "speed", "power"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_lines_of_other_engines_and_headers_stay() -> None:
    played = Played()
    played.stage.set_errors(DROPPED)
    header, line = TruthLine(0.0, '{"type": "header", "seed": 7}'), TruthLine(0.0, '{"type": "snapshot"}')
    assert played.stage.completed(played.engine, header) is header.text
    assert played.stage.completed(FakeEngine(scene()), line) is line.text


def test_an_engine_that_goes_on_at_another_rate_keeps_the_errors_in_force() -> None:
    """With the bytes that a simulator has in this process; what is in the scene's file is no longer in force."""
    served, alone = simulator(), simulator()
    stage = ErrorStage(served, [sink := RecordingSink()])
    stage.open_epoch(RadarInfo.unnamed(Epoch("one", served, None)))
    for each in (stage, alone):
        each.set_errors(None)
        each.set_errors({"gyro": {"bias_deg": 7}, "feed": {"drop_rate": 0.3}})
    served.scan()
    alone.scan()
    order = SceneRequest(SCENE, rpm=30, goes_on=True)
    epoch = Epoch("two", served.at_rpm(30), None, scene_request=order)
    stage.open_epoch(RadarInfo.unnamed(epoch))
    for block in epoch.spoke_source.blocks():
        if block.scan > 2:
            break
        stage.send(SpokeBatch(epoch, 0, block, Controls()))
    sent = [(spoke.number, spoke.heading) for batch in sink.batches for spoke in batch.block.spokes()]
    expected = [(spoke.number, spoke.heading) for spoke in alone.at_rpm(30).feed(2)]
    assert sent == expected and len(sent) < 2 * SIMULATED
    stage.open_epoch(RadarInfo.unnamed(Epoch("three", FakeEngine(scene()), None)))
    assert stage.errors is None


# True readings of earlier spokes, from a memory of bounded size.
def added(history: ReadingsHistory, first: int, count: int) -> None:
    """Adds readings whose values tell the number."""
    n = np.arange(first, first + count, dtype=np.float64)
    history.add(first, Readings(n, n + 0.1, np.stack([n + 0.2, n + 0.3], axis=1), n + 0.4, n + 0.5))


def found(history: ReadingsHistory, *number: int) -> list[float]:
    """The azimuths of spokes; the other columns must belong to them."""
    made = history.readings(np.array(number))
    columns = (made.heading - 0.1, made.position[:, 0] - 0.2, made.position[:, 1] - 0.3, made.course - 0.4, made.speed - 0.5)
    for column in columns:
        np.testing.assert_allclose(column, made.azimuth, atol=1e-12)  # rounding
    return list(made.azimuth)


def test_what_is_not_kept_is_that_of_the_newest_before_it() -> None:
    history = ReadingsHistory(16)
    added(history, 5, 5)
    assert found(history, 0, 5, 9, 30) == [5, 5, 9, 9]  # none is before 0
    added(history, 12, 3)  # 10 and 11 were never sent
    assert found(history, 10, 11, 12, 14, 15) == [9, 9, 12, 14, 14]
    added(history, 15, 10)
    assert found(history, 2, 13, 24) == [9, 13, 24]  # 9 is the oldest of 16: 9 and 12 to 24
