"""The truth in the feed: at instants of what was sent, in order, and announced where it is missing."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.records.truth import Truth
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.radio.truth_stream import MAX_WAITING, TRUTHS_PER_SCAN, FeedTruth
from radar_service.service.spokes import Epoch, SpokeBatch
from tests.service.fake import AZIMUTHS, FakeEngine, scene
from tests.service.fanout.batches import U8, everything, opened


class Engine(FakeEngine):
    """Answers while `answers` is set; fails at the times in `fails`."""

    def __init__(self, *fails: float) -> None:
        super().__init__(scene())
        self.fails, self.asked = fails, 0
        self.answers = threading.Event()
        self.answers.set()

    def truth(self, t: float) -> Truth:
        self.asked += 1
        assert self.answers.wait(60)
        if t in self.fails:
            raise RuntimeError("the wheel came off")
        return super().truth(t)


class Played:
    """Truths of an engine for a client, who requests them or not."""

    def __init__(self, engine: Engine, requests: bool = True) -> None:
        self.engine, self.hub, self.client = engine, opened(), ClientQueue(U8, truth=requests)
        self.hub.join(self.client)
        self.pool = ThreadPoolExecutor(1)
        self.truth = FeedTruth(self.hub, self.pool)
        self.truth.start()

    def send(self, scans: int, epoch: str = "e") -> None:
        for scan in range(scans):
            block = self.engine.block(scan * AZIMUTHS, AZIMUTHS)
            self.truth.send(SpokeBatch(Epoch(epoch, self.engine, None), block.first, block, Controls()))

    async def told(self, count: int) -> list[dict[str, Any]]:
        """The messages after the hello, which stand for `count` truths."""
        messages: list[dict[str, Any]] = []
        while sum(message.get("count", 1) for message in messages) < count:
            await asyncio.sleep(0.001)
            messages += [message for message in await everything(self.client) if message["type"] != "hello"]
        return messages


@contextlib.asynccontextmanager
async def playing(engine: Engine, **options: Any) -> AsyncIterator[Played]:
    played = Played(engine, **options)
    try:
        yield played
    finally:
        engine.answers.set()
        played.truth.stop()
        played.pool.shutdown()


async def test_truth_comes_so_many_times_a_scan_where_a_client_requests_it() -> None:
    async with playing(Engine()) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert {message["type"] for message in messages} == {"truth"}
        np.testing.assert_allclose([m["time"] for m in messages], np.arange(8) * 2.5 / 8, rtol=1e-12)  # rounding
    async with playing(Engine(), requests=False) as played:
        played.send(1)
        await asyncio.sleep(0)
        assert played.engine.asked == 0


async def test_a_truth_that_fails_is_announced_in_its_position() -> None:
    async with playing(Engine(2.5 / 8)) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert [message["type"] for message in messages] == ["truth", "no_truth", *["truth"] * 6]
        expected = {"epoch": "e", "time": 2.5 / 8, "until": 2.5 / 8, "count": 1, "reason": "the wheel came off"}
        assert messages[1] == {"type": "no_truth", **expected}


async def test_truths_that_come_too_slowly_are_given_up_oldest_first_in_one_message() -> None:
    async with playing(Engine()) as played:
        played.engine.answers.clear()
        played.send(1)
        while not played.engine.asked:
            await asyncio.sleep(0.001)
        played.send(9)
        await asyncio.sleep(0)
        assert not await played.told(0)
        played.engine.answers.set()
        first, missing, *others = await played.told(10 * TRUTHS_PER_SCAN)
        assert first["type"] == "truth" and [other["type"] for other in others] == ["truth"] * MAX_WAITING
        assert (missing["type"], missing["count"]) == ("no_truth", 10 * TRUTHS_PER_SCAN - 1 - MAX_WAITING)
        assert "too slowly" in missing["reason"] and missing["time"] == 2.5 / 8


@pytest.mark.parametrize("ends", ["epoch", "stop"])
async def test_truths_of_an_epoch_that_is_over_or_of_a_radar_that_stops_are_not_asked(ends: str) -> None:
    async with playing(Engine()) as played:
        played.engine.answers.clear()
        played.send(1)
        while not played.engine.asked:
            await asyncio.sleep(0.001)
        if ends == "epoch":
            played.hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
            played.send(1, "f")
            await asyncio.sleep(0)
        else:
            played.truth.stop()
            played.send(1)
        played.engine.answers.set()
        messages = await played.told(TRUTHS_PER_SCAN if ends == "epoch" else 0)
        assert {message["epoch"] for message in messages} == ({"f"} if ends == "epoch" else set())
        assert played.engine.asked == (1 + TRUTHS_PER_SCAN if ends == "epoch" else 1)
