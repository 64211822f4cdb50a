"""Failures are reported and repaired, and sequence numbers stay right: engines fail, scenes change, connections break."""

import ast
import asyncio
import math
import random
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service.service
from clients.ppi.client import FeedClient
from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.records.spokes import SpokeBlock
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Closed, Socket
from tests.ports.playing import FLAT_OUT, playing, station
from tests.ports.serving import served
from tests.service.fake import AZIMUTHS, BINS, FakeEngine, factory, power_of, scene
from tests.service.held import ResultCache, held


async def covered(feed: Socket, upto: int) -> Iterator[tuple[str, int, int]]:
    """(type, first, end) of the messages that count, until number `upto` is covered."""
    spans, end = [], 0
    while end < upto:
        message = await feed.receive()
        if "first" in message:
            end = message["first"] + message["count"]
            spans.append((message["type"], message["first"], end))
    return iter(spans)


async def test_an_engine_that_dies_is_replaced_in_the_next_scan_and_the_rest_is_a_gap() -> None:
    """Spokes come in fives, so 39 to 43 is the block that kills it at spoke 40; scans have 24."""
    async with playing(station(FakeEngine(scene(), dies_at=40), settings=Settings(pace=Pace("pause", math.inf)))) as server:
        feed = await server.feed("?mode=lossless&encoding=f32")
        messages, end = [await feed.receive()], 0
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "run"}})
        epoch = messages[0]["epoch"]
        while end < 4 * AZIMUTHS:
            messages.append(await feed.receive())
            assert messages[-1]["epoch"] == epoch and messages[-1]["first"] == end
            end = messages[-1]["first"] + messages[-1]["count"]
        gaps = [m for m in messages if m["type"] == "gap"]
        assert [(gap["first"], gap["count"]) for gap in gaps] == [(39, 9)] and "the wheel came off" in gaps[0]["reason"]
        for message in messages[1:]:
            if message["type"] == "spokes":
                numbers = message["first"] + np.arange(message["count"])
                np.testing.assert_array_equal(wire.samples(message), power_of(numbers, BINS))
                assert message["scan"] * AZIMUTHS + message["index"] == message["first"]
        health = (await server.http.get("/api/health")).json()["radars"][0]
        assert health["restarts"] == 1 and health["state"] in ("running", "behind") and health["fault"] is None
        for number in (30, 39, 42, 47, 48, 50):
            late = await server.feed(f"?encoding=f32&since={epoch}:{number}")
            spans = list(await covered(late, 60))
            assert spans[0][1] == number and all(a[2] == b[1] for a, b in zip(spans, spans[1:], strict=False))
            lost = [(first, stop) for kind, first, stop in spans if kind == "gap"]
            assert lost == ([(max(number, 39), 48)] if number < 48 else [])


async def test_an_engine_that_keeps_dying_fails_the_radar_and_says_so() -> None:
    reports: list[str] = []
    dying = factory(dies_at=0)
    async with playing(
        station(FakeEngine(scene(), dies_at=40), settings=FLAT_OUT, make=dying, failed=lambda: reports.append("failed"))
    ) as server:
        feed = await server.feed("?mode=lossless")
        assert "the wheel came off" in (await feed.until("bye"))["reason"]
        with pytest.raises(Closed):
            await feed.receive()
        assert "the wheel came off" in (await (await server.feed()).receive())["reason"]
        answer = await server.http.get("/api/health")
        assert (answer.status_code, answer.json()["status"], answer.json()["radars"][0]["restarts"]) == (503, "failed", 3)
        assert (await server.http.get("/api/health/ready")).status_code == 503
        assert (await server.http.get("/api/health/alive")).status_code == 200
        while not reports:  # or the whole test runs out of time
            await asyncio.sleep(0.001)
        assert reports == ["failed"]


class StallingEngine(FakeEngine):
    """Makes 24 spokes, each as if the machine took a second of `clock` for it."""

    def __init__(self, clock: list[float]) -> None:
        super().__init__(scene())
        self._clock = clock

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        for block in super().blocks(scans, 1):
            self._clock[0] += 1.0
            yield block


async def test_a_machine_too_slow_says_so_with_the_factor_and_keeps_order() -> None:
    """A spoke is 60/24/24 s of simulation; with a second for each, the factor reached is 0.104 of real time."""
    clock = [0.0]
    async with playing(
        station(StallingEngine(clock), settings=Settings(pace=Pace(factor=20)), clock=lambda: clock[0])
    ) as server:
        feed = await server.feed("?mode=lossless")
        spans = list(await covered(feed, 3 * AZIMUTHS))
        assert all(a[2] == b[1] for a, b in zip(spans, spans[1:], strict=False))
        health = (await server.http.get("/api/health")).json()
        assert health["status"] == "behind" and health["radars"][0]["slips"] > 0
        assert health["radars"][0]["factor_reached"] < 0.97


@pytest.mark.parametrize("swaps", [30, pytest.param(1000, marks=pytest.mark.study)])
async def test_scenes_swapped_under_load_each_begin_anew_for_everybody(swaps: int) -> None:
    before: list[ResultCache] = []

    async def follow(feed: Socket) -> list[str]:
        epochs: list[str] = []
        end = None  # the first epoch has begun before
        while True:
            message = await feed.receive()
            if message["type"] == "hello":
                epochs.append(message["epoch"])
                end = 0 if epochs[1:] else None
                if message["scene"]["name"] == f"scene {swaps - 1}":
                    return epochs
            elif message["type"] in ("spokes", "gap"):
                assert message["epoch"] == epochs[-1] and end in (None, message["first"])
                end = message["first"] + message["count"]

    async with playing(station(settings=FLAT_OUT)) as server:
        feeds = [await server.feed(f"?encoding={kind}") for kind in ("u8", "u8", "f32", "u8-log")]
        followers = [asyncio.create_task(follow(feed)) for feed in feeds]
        named = []
        for k in range(swaps):
            answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": f"scene {k}"}})
            assert answer.status_code == 200
            named.append(answer.json()["epoch"])
            if k == swaps // 4:
                before.append(held())
        seen = await asyncio.gather(*followers)
        while (after := held()).files > before[0].files:  # the folder of a replaced scene may just be being removed
            await asyncio.sleep(0.001)
        assert after.threads <= before[0].threads + 2  # of the engine that takes over
        assert after.objects < 1.1 * before[0].objects
        for epochs in seen:
            assert len(set(epochs)) == len(epochs) and epochs == seen[0]
            assert [e for e in named if e in epochs] == epochs[1:]  # in order; overtaken ones never began


class CutClient(FeedClient):
    """A client whose connection can be cut without a word."""

    def cut(self) -> bool:
        """Cuts the connection; returns whether there was one."""
        if self._socket is None:
            return False
        self._socket.transport.abort()
        return True


@pytest.mark.parametrize("breaks", [25, pytest.param(1000, marks=pytest.mark.study)])
def test_lines_that_are_cut_again_and_again_cost_no_spoke(breaks: int) -> None:
    """The Python client over real sockets, each cut without a word at a random moment."""
    dice, only = random.Random(6), station(settings=Settings(pace=Pace(factor=100)))

    async def follow(url: str) -> tuple[list[int], FeedClient]:
        client, numbers = CutClient(url, encoding="u8-log", reconnect=True, backoff=(0.0,), timeout=20), list[int]()
        cuts = 0
        async with client:
            async for spoke in client.spokes():
                numbers.append(spoke.number)
                if client.reconnections == breaks:
                    return numbers, client
                if client.reconnections == cuts and not dice.randrange(12) and client.cut():
                    cuts += 1
        raise AssertionError

    with served(create_app([only]), [only]) as (host, port):
        numbers, client = asyncio.run(asyncio.wait_for(follow(f"ws://{host}:{port}"), 30 + breaks / 4))
    assert numbers == list(range(numbers[0], numbers[-1] + 1)) and len(numbers) > 3 * breaks
    assert client.sequence.lost == 0 and client.sequence.epochs == 1
    print(f"\n{client.reconnections} returns, {len(numbers)} spokes, none lost")


async def test_a_clock_that_jumps_disturbs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of day goes back and forth by a year with every look at it; spokes come in order and at their pace."""
    calls = 0

    def jumping() -> float:
        nonlocal calls
        calls += 1
        return 1.7e9 + (-1) ** calls * 3.2e7

    class Jumping(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> "Jumping":
            return cls.fromtimestamp(jumping(), tz)

    monkeypatch.setattr("time.time", jumping)
    monkeypatch.setattr("radar_service.service.spokes.datetime", Jumping)
    only = station(settings=Settings(pace=Pace(factor=20)))
    async with playing(only) as server:
        began = time.monotonic()
        feed = await server.feed("?mode=lossless&encoding=u8-log")
        spans = list(await covered(feed, 3 * AZIMUTHS))
        lasted = time.monotonic() - began
        assert all(a[2] == b[1] and a[0] == "spokes" for a, b in zip(spans, spans[1:], strict=False))
        due = (3 * AZIMUTHS - spans[0][1]) * only.epoch.info.scene.radar.spoke_period / 20
        assert lasted > due - 0.1  # s: a message more or less; a busy machine may make it longer
    assert calls > 0


@pytest.mark.parametrize("factor", [1e-12, 5e-324])
async def test_a_pace_too_slow_to_wait_for_can_be_taken_back(factor: float) -> None:
    """At 1e-12 the next spoke is due in 1e11 s, at 5e-324 never; neither is a time that a thread can wait for."""
    only = station(settings=Settings(pace=Pace(factor=100)))
    async with playing(only) as server:
        feed = await server.feed("?encoding=u8-log")
        begun = list(await covered(feed, 5))
        for pace in ({"factor": factor}, {"factor": 1000}):
            before = only.transmitter.state.sent
            answer = await server.http.patch("/api/radars/0/controls", json={"pace": pace})
            assert answer.status_code == 200
            while only.transmitter.state.sent == before:  # the first spoke goes at once, and the second is waited for
                await asyncio.sleep(0.001)
        spans = begun + list(await covered(feed, begun[-1][2] + 2 * AZIMUTHS))
        assert all(a[2] == b[1] for a, b in zip(spans, spans[1:], strict=False))
        health = (await server.http.get("/api/health")).json()["radars"][0]
        assert health["restarts"] == 0 and health["fault"] is None


def test_pacing_knows_no_wall_clock() -> None:
    """The time of day, which people and NTP set, is used only as the start of UTC, in log lines, and for packets of captures."""
    package = Path(str(radar_service.service.__file__)).parents[1]
    users = {
        file.name
        for folder in ("service", "ports", "processes")
        for file in (package / folder).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Attribute) and f"{ast.unparse(node.value)}.{node.attr}" in
        ("time.time", "datetime.now", "datetime.utcnow", "time.localtime", "time.time_ns", "datetime.today")
    }  # fmt: skip
    assert users == {"spokes.py", "capture.py"}
