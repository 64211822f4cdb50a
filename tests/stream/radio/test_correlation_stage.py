"""Scan-to-scan correlation of a radar: one memory for all receivers, from when it is switched on."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.display.scan_correlation import ScanMemory
from radar_service.display.video import Controls
from radar_service.stream.codecs.native import messages
from radar_service.stream.feed_request import View
from radar_service.stream.radio.correlation_stage import CorrelationStage
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch
from tests.stream.fake import AZIMUTHS, FakeEngine, scene
from tests.stream.radio.recording import RecordingSink

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
        block = epoch.engine.block(scan * AZIMUTHS, AZIMUTHS)  # type: ignore[attr-defined]
        self.stage.send(SpokeBatch(epoch, 0, block, video))
        assert self.sink.batches[-1] is self.other.batches[-1]
        return self.sink.batches[-1].earlier


def is_unknown(earlier: np.ndarray | None) -> bool:
    assert earlier is not None
    return bool(np.isposinf(earlier).all())


def test_it_acts_from_the_second_scan_after_it_was_switched_on() -> None:
    played = Played()
    assert played.send(0, OFF) is None and is_unknown(played.send(1))
    found, memory = played.send(2), ScanMemory(played.epoch.engine.scene.radar, played.epoch.engine.range, 10.0)
    for scan in (1, 2):
        expected = memory.take(played.epoch.engine.block(scan * AZIMUTHS, AZIMUTHS))  # type: ignore[attr-defined]
    assert found is not None and np.isfinite(found).all()
    np.testing.assert_array_equal(found, expected)
    assert played.send(3, OFF) is None and is_unknown(played.send(4)) and not is_unknown(played.send(5))


def test_a_batch_passes_untouched_while_it_is_off() -> None:
    played = Played()
    batch = SpokeBatch(played.epoch, 0, played.epoch.engine.block(0, 5), OFF)  # type: ignore[attr-defined]
    played.stage.send(batch)
    assert played.sink.batches == [batch] and played.sink.batches[0] is batch


def test_another_range_keeps_the_memory_and_another_engine_or_a_failure_ends_it() -> None:
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
