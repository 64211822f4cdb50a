"""The stream of the truth, and the truth in the feed: what comes, when, and to whom; what is missing is announced."""

import asyncio
import contextlib
import json
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.records.truth import Truth
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.radio import truth_stream
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.truth_stream import MAX_WAITING, TRUTHS_PER_SCAN, FeedTruth, Follower, TruthStream
from radar_service.service.spokes import NO_COMMANDS, Epoch, RadarInfo, SpokeBatch
from radar_service.spoke_source import SpokeSourceFault, TruthLine
from tests.service.fake import AZIMUTHS, FakeEngine, commanded, scene, steerable_scene
from tests.service.fanout.batches import U8, everything, opened

PERIOD = scene().radar.rotation_period


class Played:
    """A stream, its engine, and followers whose lines are collected."""

    def __init__(self, engine: FakeEngine, pool: ThreadPoolExecutor) -> None:
        self.stream, self.engine = TruthStream(engine, pool), engine
        self.stream.start()
        self.tasks: list[asyncio.Task[None]] = []
        self.log = NO_COMMANDS

    def follow(self, radiometric: bool = False) -> tuple[Follower, list[dict[str, Any]]]:
        follower, lines = self.stream.join(radiometric), list[dict[str, Any]]()

        async def collect() -> None:
            async for line in self.stream.lines(follower):
                lines.append(json.loads(line))

        self.tasks.append(asyncio.create_task(collect()))
        return follower, lines

    def send(self, first: int, count: int, engine: FakeEngine | None = None) -> None:
        """Sends spokes, one batch a scan at most."""
        engine = engine or self.engine
        self.stream.send(SpokeBatch(Epoch("e", engine, None, self.log), first, engine.block(first, count), Controls()))

    async def until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            await asyncio.sleep(0.001)

    async def over(self) -> None:
        self.stream.end("over")
        await asyncio.gather(*self.tasks)


@contextlib.asynccontextmanager
async def playing(engine: FakeEngine | None = None) -> AsyncIterator[Played]:
    with ThreadPoolExecutor(1) as pool:
        yield Played(engine or FakeEngine(scene()), pool)


def kinds(lines: list[dict[str, Any]]) -> list[tuple[str, float]]:
    """Types of lines, and their times in spokes."""
    return [(line["type"], round(line.get("time", 0.0) / PERIOD * AZIMUTHS, 6)) for line in lines]


async def test_a_crossing_comes_with_the_spokes_that_pass_it_and_a_snapshot_with_the_end() -> None:
    async with playing() as played:
        _, lines = played.follow()
        for first, count, expected in ((0, 9, 1), (9, 1, 2), (10, 7, 2), (17, 1, 3), (18, 5, 3), (23, 1, 4)):
            played.send(first, count)
            await played.until(lambda expected=expected: len(lines) >= expected)  # type: ignore[misc]
            assert len(lines) == expected
        await played.over()
        assert kinds(lines) == [("header", 0), ("crossing", 8.5), ("crossing", 16.5), ("snapshot", 24)]


async def test_who_joins_within_a_scan_hears_what_is_to_come() -> None:
    async with playing() as played:
        played.send(0, 12)  # nobody follows
        _, lines = played.follow()
        played.send(12, AZIMUTHS - 12)
        played.send(AZIMUTHS, AZIMUTHS)
        await asyncio.sleep(0)
        await played.over()
        later = [("crossing", 32.5), ("crossing", 40.5), ("snapshot", 48)]
        assert kinds(lines) == [("header", 0), ("crossing", 16.5), ("snapshot", 24), *later]


async def test_another_scene_has_a_header_and_another_engine_of_the_same_has_none() -> None:
    async with playing() as played:
        _, lines = played.follow()
        await played.until(lambda: bool(lines))
        played.send(0, AZIMUTHS)
        played.send(AZIMUTHS, AZIMUTHS, FakeEngine(scene()))  # as after a restart
        other = FakeEngine(scene("another"))
        played.stream.open_epoch(RadarInfo.unnamed(Epoch("f", other, None)))
        played.send(0, AZIMUTHS, other)
        await asyncio.sleep(0)
        await played.over()
        names = [line["scene"] for line in lines if line["type"] == "header"]
        assert names == ["test scene", "another"] and len(lines) == 2 + 3 * 3


async def test_commands_change_the_lines_that_are_still_to_come() -> None:
    class Delayed(FakeEngine):
        """Each command brings the second crossing a spoke nearer, once the engine has computed the spokes before it."""

        reached = 0

        def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
            first, *others = super().truth_lines(scan, radiometric)
            if scan is None:
                return [first]
            time = others[0].time - sum(command.spoke <= self.reached for command in self.commands) * PERIOD / AZIMUTHS
            return [first, TruthLine(time, json.dumps(json.loads(others[0].text) | {"time": time})), *others[1:]]

    async with playing() as played:
        worker = SpokeWorker(engine := Delayed(steerable_scene()))
        played.log = worker.commands
        played.stream.open_epoch(RadarInfo.unnamed(Epoch("f", engine, None)))
        _, lines = played.follow()
        played.send(0, 8, engine)
        await played.until(lambda: len(lines) >= 1)
        commanded(worker, 13, "buoy", {"speed_kn": 1})
        engine.reached = 12
        played.send(8, 4, engine)  # its blocks know the command, which acts later
        await played.until(lambda: len(lines) >= 2)
        engine.reached = AZIMUTHS
        played.send(12, 5, engine)
        await played.until(lambda: len(lines) >= 3)
        commanded(worker, 17, "buoy", {"speed_kn": 2})
        played.send(17, AZIMUTHS - 17, engine)
        await asyncio.sleep(0)
        await played.over()
        assert kinds(lines) == [("header", 0), ("crossing", 8.5), ("crossing", 15.5), ("snapshot", 24)]


async def test_an_engine_is_asked_once_for_all_followers() -> None:
    asked: list[int | None] = []

    class Counting(FakeEngine):
        def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
            asked.append(scan)
            return super().truth_lines(scan, radiometric)

    async with playing(Counting(scene())) as played:
        all_lines = [played.follow()[1] for _ in range(3)]
        played.send(0, AZIMUTHS)
        await asyncio.sleep(0)
        await played.over()
        assert all_lines[0] == all_lines[1] == all_lines[2] and len(all_lines[0]) == 4
        assert asked == [None, 0]


async def test_power_comes_to_those_alone_who_ask_for_it() -> None:
    async with playing() as played:
        plain, measured = played.follow()[1], played.follow(radiometric=True)[1]
        played.send(0, AZIMUTHS)
        await asyncio.sleep(0)
        await played.over()
        assert [line.get("snr_db") for line in plain] == [None, None, None, None]
        assert [line.get("snr_db") for line in measured] == [None, 20.0, 20.0, None]


async def test_an_engine_that_fails_leaves_a_hole_and_no_more() -> None:
    class Failing(FakeEngine):
        def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
            if scan == 0:
                raise SpokeSourceFault("gone")
            return super().truth_lines(scan, radiometric)

    async with playing(Failing(scene())) as played:
        _, lines = played.follow()
        for scan in range(2):
            played.send(scan * AZIMUTHS, AZIMUTHS)
        await asyncio.sleep(0)
        await played.over()
        assert [line["type"] for line in lines] == ["header", "crossing", "crossing", "snapshot"]
        assert lines[1]["scan"] == 1


async def test_who_reads_too_slowly_is_ended_and_others_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(truth_stream, "MAX_BEHIND", 3)
    async with playing() as played:
        slow = played.stream.join()  # reads nothing
        for spoke in range(5):
            played.send(spoke, 1)
            await asyncio.sleep(0)
        assert (slow.reason, slow.code) == ("this client reads the truth too slowly", 4408)
        assert await slow.next() is None
        played.stream.leave(slow)
        _, lines = played.follow()
        await played.over()
        assert [line["type"] for line in lines] == ["header"]


async def test_the_end_of_the_radar_ends_followers() -> None:
    async with playing() as played:
        follower, _ = played.follow()
        played.stream.close("the radar has stopped")
        await asyncio.gather(*played.tasks)
        assert (follower.reason, follower.code) == ("the radar has stopped", 1001)
        follower.end("again")
        assert follower.reason == "the radar has stopped"


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


class FeedPlayed:
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
async def telling(engine: Engine, **options: Any) -> AsyncIterator[FeedPlayed]:
    played = FeedPlayed(engine, **options)
    try:
        yield played
    finally:
        engine.answers.set()
        played.truth.stop()
        played.pool.shutdown()


async def test_truth_comes_so_many_times_a_scan_where_a_client_requests_it() -> None:
    async with telling(Engine()) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert {message["type"] for message in messages} == {"truth"}
        np.testing.assert_allclose([m["time"] for m in messages], np.arange(8) * 2.5 / 8, rtol=1e-12)  # rounding
    async with telling(Engine(), requests=False) as played:
        played.send(1)
        await asyncio.sleep(0)
        assert played.engine.asked == 0


async def test_a_truth_that_fails_is_announced_in_its_position() -> None:
    async with telling(Engine(2.5 / 8)) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert [message["type"] for message in messages] == ["truth", "no_truth", *["truth"] * 6]
        expected = {"epoch": "e", "time": 2.5 / 8, "until": 2.5 / 8, "count": 1, "reason": "the wheel came off"}
        assert messages[1] == {"type": "no_truth", **expected}


async def test_truths_that_come_too_slowly_are_given_up_oldest_first_in_one_message() -> None:
    async with telling(Engine()) as played:
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
    async with telling(Engine()) as played:
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
