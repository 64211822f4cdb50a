"""The memory of the last scan: one revolution, of one engine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from radar_service.display.video import Controls
from radar_service.stream.radio.last_scan import LastScan
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch
from tests.stream.fake import AZIMUTHS, BINS, FakeEngine, power_of, scene


def send(memory: LastScan, epoch: Epoch, first: int, count: int) -> None:
    assert isinstance(epoch.engine, FakeEngine)
    memory.send(SpokeBatch(epoch, first, epoch.engine.block(first, count), Controls()))


def test_it_keeps_the_newest_revolution() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.engine)
    for first in range(0, 2 * AZIMUTHS, 4):
        send(memory, epoch, first, 4)
    kept = memory.read()
    rows = kept.rows
    assert (kept.next, kept.heading) == (2 * AZIMUTHS, pytest.approx(math.radians(30)))
    assert kept.engine is epoch.engine and sum(len(numbers) for numbers, *_ in rows) == AZIMUTHS
    assert rows[0][0].tolist() == [0, 1, 2, 3]
    np.testing.assert_array_equal(rows[0][1], power_of(AZIMUTHS + np.arange(4), BINS))


def test_another_range_keeps_the_rows_and_another_engine_drops_them() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.engine)
    send(memory, epoch, 0, 4)
    memory.open_epoch(RadarInfo.unnamed(Epoch("f", epoch.engine, 100.0)))
    memory.skip("f", 4, 3, "it broke")
    memory.close("it broke")
    assert len(memory.read().rows) == 1
    other = FakeEngine(scene())
    memory.open_epoch(RadarInfo.unnamed(Epoch("g", other, None)))
    kept = memory.read()
    assert (kept.engine, kept.rows, kept.next) == (other, [], 0)


def test_rows_have_what_the_scan_before_had() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory, block = LastScan(epoch.engine), epoch.engine.block(0, 4)  # type: ignore[attr-defined]
    memory.send(SpokeBatch(epoch, 0, block, Controls(), earlier=block.power / 2))
    (_, _, earlier), *_ = memory.read().rows
    np.testing.assert_array_equal(earlier, block.power / 2)


def test_parts_of_a_block_hold_no_more_than_themselves() -> None:
    """A command cuts blocks: of 32 spokes one may be sent, and the others come anew."""
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.engine)
    for first in range(AZIMUTHS):
        block = epoch.engine.block(first, 4).part(0, 1)  # type: ignore[attr-defined]
        memory.send(SpokeBatch(epoch, first, block, Controls(), earlier=block.power))
    rows = memory.read().rows
    assert len(rows) == AZIMUTHS and all(power.base is None and earlier.base is None for _, power, earlier in rows)


def test_a_lost_heading_stays_as_it_was_last_reported() -> None:
    epoch = Epoch("e", FakeEngine(scene()), None)
    memory = LastScan(epoch.engine)
    send(memory, epoch, 0, 4)
    lost = replace(epoch.engine.block(4, 4), heading=np.full(4, math.nan))  # type: ignore[attr-defined]
    memory.send(SpokeBatch(epoch, 4, lost, Controls()))
    assert memory.read().heading == pytest.approx(math.radians(30)) and memory.read().next == 8
