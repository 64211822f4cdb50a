"""The memories of the last scan: one revolution of one engine, and one for all receivers from when correlation is switched on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from radar_service.display.scan_correlation import ScanMemory
from radar_service.display.video import Controls
from radar_service.service.codecs.native import messages
from radar_service.service.feed_request import View
from radar_service.service.radio.last_scan import CorrelationStage, LastScan
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import AZIMUTHS, BINS, FakeEngine, power_of, scene
from tests.service.radio.recording import RecordingSink


def send(memory: LastScan, epoch: Epoch, first: int, count: int) -> None:
    assert isinstance(epoch.spoke_source, FakeEngine)
    memory.send(SpokeBatch(epoch, first, epoch.spoke_source.block(first, count), Controls()))


def test_it_keeps_the_newest_revolution() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.spoke_source)
    for first in range(0, 2 * AZIMUTHS, 4):
        send(memory, epoch, first, 4)
    kept = memory.read()
    rows = kept.rows
    assert (kept.next, kept.heading) == (2 * AZIMUTHS, pytest.approx(math.radians(30)))
    assert kept.of is epoch.info and sum(len(numbers) for numbers, *_ in rows) == AZIMUTHS
    assert rows[0][0].tolist() == [0, 1, 2, 3]
    np.testing.assert_array_equal(rows[0][1], power_of(AZIMUTHS + np.arange(4), BINS))


def test_another_range_keeps_the_rows_and_another_engine_drops_them() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.spoke_source)
    send(memory, epoch, 0, 4)
    memory.open_epoch(RadarInfo.unnamed(Epoch("f", epoch.spoke_source, 100.0)))
    memory.skip("f", 4, 3, "it broke")
    memory.close("it broke")
    assert len(memory.read().rows) == 1
    other = FakeEngine(scene())
    memory.open_epoch(RadarInfo.unnamed(Epoch("g", other, None)))
    kept = memory.read()
    assert (kept.of.range is other.range, kept.rows, kept.next) == (True, [], 0)


def test_rows_have_what_the_scan_before_had() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory, block = LastScan(epoch.spoke_source), epoch.spoke_source.block(0, 4)  # type: ignore[attr-defined]
    memory.send(SpokeBatch(epoch, 0, block, Controls(), earlier=block.power / 2))
    (_, _, earlier), *_ = memory.read().rows
    np.testing.assert_array_equal(earlier, block.power / 2)


def test_parts_of_a_block_hold_no_more_than_themselves() -> None:
    """A command cuts blocks: of 32 spokes one may be sent, and the others come anew."""
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.spoke_source)
    for first in range(AZIMUTHS):
        block = epoch.spoke_source.block(first, 4).part(0, 1)  # type: ignore[attr-defined]
        memory.send(SpokeBatch(epoch, first, block, Controls(), earlier=block.power))
    rows = memory.read().rows
    assert len(rows) == AZIMUTHS and all(power.base is None and earlier.base is None for _, power, earlier in rows)


def test_a_lost_heading_stays_as_it_was_last_reported() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.spoke_source)
    send(memory, epoch, 0, 4)
    lost = replace(epoch.spoke_source.block(4, 4), heading=np.full(4, math.nan))  # type: ignore[attr-defined]
    memory.send(SpokeBatch(epoch, 4, lost, Controls()))
    assert memory.read().heading == pytest.approx(math.radians(30)) and memory.read().next == 8


ON, OFF = Controls(scan_correlation=True), Controls()


class Played:
    """A stage with two sinks, and an engine whose spoke n + AZIMUTHS is stronger than spoke n."""

    def __init__(self) -> None:
        self.sink, self.other = RecordingSink(), RecordingSink()
        self.stage = CorrelationStage([self.sink, self.other])
        self.epoch = Epoch("e", FakeEngine(scene()), None)
        self.stage.open_epoch(RadarInfo.unnamed(self.epoch))

    def send(self, scan: int, video: Controls = ON, epoch: Epoch | None = None) -> np.ndarray | None:
        """Sends a scan; returns what the scan before had."""
        epoch = epoch or self.epoch
        block = epoch.spoke_source.block(scan * AZIMUTHS, AZIMUTHS)  # type: ignore[attr-defined]
        self.stage.send(SpokeBatch(epoch, 0, block, video))
        assert self.sink.batches[-1] is self.other.batches[-1]
        return self.sink.batches[-1].earlier


def is_unknown(earlier: np.ndarray | None) -> bool:
    assert earlier is not None
    return bool(np.isposinf(earlier).all())


def test_correlation_acts_from_the_second_scan_after_it_was_switched_on() -> None:
    played = Played()
    assert played.send(0, OFF) is None and is_unknown(played.send(1))
    found, memory = played.send(2), ScanMemory(played.epoch.info.scene.radar, played.epoch.spoke_source.range, 10.0)
    for scan in (1, 2):
        expected = memory.take(played.epoch.spoke_source.block(scan * AZIMUTHS, AZIMUTHS))  # type: ignore[attr-defined]
    assert found is not None and np.isfinite(found).all()
    np.testing.assert_array_equal(found, expected)
    assert played.send(3, OFF) is None and is_unknown(played.send(4)) and not is_unknown(played.send(5))


def test_a_batch_passes_correlation_untouched_while_it_is_off() -> None:
    played = Played()
    batch = SpokeBatch(played.epoch, 0, played.epoch.spoke_source.block(0, 5), OFF)  # type: ignore[attr-defined]
    played.stage.send(batch)
    assert played.sink.batches == [batch] and played.sink.batches[0] is batch


def test_another_range_keeps_the_correlation_and_another_engine_or_a_failure_ends_it() -> None:
    played = Played()
    played.send(0)
    near = replace(played.epoch, name="f", range=100.0)
    played.stage.open_epoch(RadarInfo.unnamed(near))
    assert not is_unknown(played.send(1, epoch=near))
    restarted = Epoch("f", FakeEngine(scene()), 100.0)  # goes on with the same epoch
    assert is_unknown(played.send(2, epoch=restarted)) and not is_unknown(played.send(3, epoch=restarted))
    played.stage.skip("f", 4, 3, "it broke")
    played.stage.close("it broke")
    assert is_unknown(played.send(4, epoch=restarted))
    assert len(played.sink.epochs) == len(played.other.epochs) == 2


@pytest.mark.parametrize("view", [View("u8"), View("u8", 5), View("u8-log"), View("c64")])
def test_every_view_has_the_same_past_and_measured_values_stay(view: View) -> None:
    """Spoke n has n + 1 nW times its bin: a scan later a cell is stronger than all around its place were, and is lowered."""
    played = Played()
    played.send(0)
    played.send(1)
    batch = played.sink.batches[-1]
    data = [messages.spokes(replace(batch, video=video), view)["data"] for video in (ON, OFF)]
    assert (data[0] != data[1]) is (view.encoding == "u8")
