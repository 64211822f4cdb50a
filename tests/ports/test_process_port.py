"""A port in a process of its own: it gets what any port gets, and where it dies, blocks or raises nobody else is harmed."""

import asyncio
import os
import pickle
import threading
import zlib
from collections.abc import Awaitable, Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from radar_service.ports import port_host, port_thread, process_port
from radar_service.ports.port import Port
from radar_service.ports.process_port import PortError, ProcessPort, work
from radar_service.ports.recorder.service_recorder import RecorderPort
from radar_service.processes.fork_server import ForkServer
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.settings import Settings
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, SpokeSink
from tests.ports.asgi import Server
from tests.ports.listening import FLAT_OUT, PAUSED, Ear, assert_accounted, numbers, play
from tests.ports.toy import ToyPort, ToySink
from tests.processes.test_fork_server import is_gone, until
from tests.service.fake import AZIMUTHS, FakeEngine, power_of, scene


@pytest.fixture(autouse=True)
def starts_at_leisure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_port, "START_SECONDS", 60.0)  # that a busy machine may take to import


@pytest.fixture
def stops_at_leisure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process does all that was sent to it, however busy the machine is."""
    monkeypatch.setattr(port_host, "STOP_SECONDS", 60.0)
    monkeypatch.setattr(process_port, "STOP_SECONDS", 60.0)


class FarSink(ToySink):
    """Says of each batch what its spokes are, too."""

    def send(self, batch: SpokeBatch) -> None:
        super().send(batch)
        block = batch.block
        words = {"power": zlib.crc32(block.power), "range": zlib.crc32(block.range), "before": batch.before is not None}
        self._port.say(words | {"gain": batch.video.gain, "noise": batch.epoch.info.noise_power, "of": block.first})


class FarPort(ToyPort):
    """The toy without routes. Everything that it says names its process."""

    name = "far"
    routes = Port.routes  # type: ignore[assignment]  # none

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return (FarSink(radar, self),)

    def say(self, words: dict[str, Any]) -> None:
        super().say(words | {"process": os.getpid()})


class Dying(FarPort):
    """Ends its process at the hundredth thing that it says; the next one does so too."""

    said = 0

    def say(self, words: dict[str, Any]) -> None:
        super().say(words)
        self.said += 1
        if self.said == 100:
            os._exit(1)


class Blocking(FarPort):
    def changed(self, change: Any) -> None:
        super().changed(change)
        threading.Event().wait()


class Raising(FarPort):
    def say(self, words: dict[str, Any]) -> None:
        super().say(words)
        raise RuntimeError("a fault far away")


class Texts(FarPort):
    """Raises with more text than a channel holds, and says what it has."""

    def say(self, words: dict[str, Any]) -> None:
        super().say(words)
        raise RuntimeError("x" * 300_000)


class RaisingSink(FarSink):
    def send(self, batch: SpokeBatch) -> None:
        raise RuntimeError("a fault of the first sink")


class TwoSinks(FarPort):
    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return (RaisingSink(radar, self), FarSink(radar, self))


class Slow(FarPort):
    """Is busy when the service stops, and says when it is closed."""

    def changed(self, change: Any) -> None:
        threading.Event().wait(0.1)
        super().changed(change)

    def close(self) -> None:
        self.say({"closed": True})
        super().close()


class Hanging(FarPort):
    def tick(self, radar: str, time: float) -> None:
        super().tick(radar, time)
        threading.Event().wait()


class Unmade(FarPort):
    def __init__(self, port: int) -> None:
        raise OSError("the address is in use")


@pytest.fixture
def ear() -> Iterator[Ear]:
    made = Ear()
    yield made
    made.close()


def flat_out(scans: int) -> Callable[[Server], Awaitable[None]]:
    """A lossless client gets so many scans, each spoke once."""

    async def test(server: Server) -> None:
        got = await (await server.feed("?mode=lossless")).spokes(scans * AZIMUTHS)
        assert [n for m in got for n in range(m["first"], m["first"] + m["count"])][: scans * AZIMUTHS] == list(
            range(scans * AZIMUTHS)
        )
        assert (await server.http.get("/api/health")).json()["status"] == "ok"

    return test


def test_spokes_changes_and_times_reach_another_process(ear: Ear) -> None:
    async def test(server: Server) -> None:
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 7}})
        await asyncio.to_thread(ear.until, lambda heard: len(numbers(heard)) >= 7)
        await server.http.patch("/api/radars/0/controls", json={"gain": 61})
        await asyncio.to_thread(ear.until, lambda heard: any("gain" in words.get("values", ()) for words in heard[8:]))

    play(port := ProcessPort(FarPort, ear.port), test)
    assert numbers(ear.heard) == list(range(7)) and port.starts == 1
    assert {words["process"] for words in ear.heard} == {ear.heard[0]["process"]} != {os.getpid()}
    assert [words["opened"] for words in ear.heard if "opened" in words] == ["steerable"]
    assert {"status", "scene", "controls"} <= {words["changed"] for words in ear.heard if "changed" in words}
    assert any("time" in words for words in ear.heard)
    known = FakeEngine(scene()).info
    batches = [words for words in ear.heard if "power" in words]
    counts = [words["count"] for words in ear.heard if "first" in words]
    for words, count in zip(batches, counts, strict=True):
        expected = power_of(words["of"] + np.arange(count), known.range.size)
        assert words["power"] == zlib.crc32(expected) and words["range"] == zlib.crc32(known.range)
        assert words["noise"] == known.noise_power and words["before"] is (words["of"] > 0)


@pytest.mark.usefixtures("stops_at_leisure")
def test_what_was_handed_on_is_done_before_the_end(ear: Ear) -> None:
    async def test(server: Server) -> None:
        await (await server.feed("?mode=lossless")).spokes(10 * AZIMUTHS)

    play(ProcessPort(FarPort, ear.port), test, FLAT_OUT, wait_for=1)
    process = ear.heard[0]["process"]
    assert_accounted(ear.heard)
    assert len(numbers(ear.heard)) >= 10 * AZIMUTHS
    until(lambda: is_gone(process))


def test_where_it_dies_another_one_goes_on_and_knows_what_was_lost(ear: Ear, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lost numbers are those of batches that the dead process had not said; the next one is told of them."""

    async def until_another_speaks(server: Server) -> None:
        feed = await server.feed("?mode=lossless")
        while len({words["process"] for words in ear.heard}) < 2:
            await feed.spokes(AZIMUTHS)

    monkeypatch.setattr(process_port, "AFTER_DEATH", 0.0)
    port = ProcessPort(Dying, ear.port)
    host = play(port, until_another_speaks, FLAT_OUT, wait_for=1)
    (thread,) = [thread for each, thread in host.threads.items() if each is port]
    processes = list(dict.fromkeys(words["process"] for words in ear.heard))
    assert len(processes) >= 2 and port.starts >= len(processes) and thread.faults > 0
    for process in processes:  # each knows of all numbers from 0 on: as spokes, or as lost
        words = [words for words in ear.heard if words["process"] == process]
        if any("first" in each or "skipped" in each for each in words):
            assert_accounted(words)
            assert "opened" in next(each for each in words if "first" in each or "skipped" in each or "opened" in each)
        if len(words) > 10:
            assert {"status", "scene", "controls"} <= {each["changed"] for each in words if "changed" in each}


def test_one_that_dies_at_once_is_not_started_without_end(ear: Ear) -> None:
    port = ProcessPort(Dying, ear.port)
    play(port, flat_out(40), FLAT_OUT, wait_for=1)
    assert port.starts == 1


@pytest.mark.parametrize("settings", [FLAT_OUT, PAUSED])
def test_one_that_blocks_is_left_behind_in_time(settings: Settings, ear: Ear, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port_thread, "MAX_BYTES", 4096)
    monkeypatch.setattr("radar_service.ports.port_host.STOP_SECONDS", 0.2)
    monkeypatch.setattr(process_port, "STOP_SECONDS", 0.1)

    async def test(server: Server) -> None:
        if settings is FLAT_OUT:
            await flat_out(150)(server)  # more than the channel holds
        await asyncio.to_thread(ear.until, lambda heard: any("changed" in words for words in heard))

    port = ProcessPort(Blocking, ear.port)
    host = play(port, test, settings, wait_for=settings is FLAT_OUT)
    (thread,) = [thread for each, thread in host.threads.items() if each is port]
    assert (thread.dropped > 0) is (settings is FLAT_OUT)
    until(lambda: is_gone(ear.heard[0]["process"]))


@pytest.mark.usefixtures("stops_at_leisure")
def test_what_fails_there_is_counted_here(ear: Ear, caplog: pytest.LogCaptureFixture) -> None:
    port = ProcessPort(Raising, ear.port)
    with caplog.at_level("ERROR", "radar_service"):
        host = play(port, flat_out(20), FLAT_OUT, wait_for=1)
    (thread,) = [thread for each, thread in host.threads.items() if each is port]
    assert thread.faults > 0 and port.starts == 1
    assert_accounted(ear.heard)
    assert "RuntimeError: a fault far away" in str([getattr(record, "fields", "") for record in caplog.records])


@pytest.mark.usefixtures("stops_at_leisure")
def test_texts_of_faults_stop_nothing(ear: Ear) -> None:
    port = ProcessPort(Texts, ear.port)
    host = play(port, flat_out(40), FLAT_OUT, wait_for=1)
    (thread,) = [thread for each, thread in host.threads.items() if each is port]
    assert thread.faults > 10 and port.starts == 1 and len(numbers(ear.heard)) >= 40 * AZIMUTHS
    assert_accounted(ear.heard)


@pytest.mark.usefixtures("stops_at_leisure")
def test_a_sink_that_raises_takes_nothing_from_another_one(ear: Ear) -> None:
    play(ProcessPort(TwoSinks, ear.port), flat_out(20), FLAT_OUT, wait_for=1)
    assert_accounted(ear.heard)
    assert len(numbers(ear.heard)) >= 20 * AZIMUTHS and not any("skipped" in words for words in ear.heard)


def test_one_that_is_busy_at_the_end_is_closed_and_not_started_again(ear: Ear, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_port, "AFTER_DEATH", 0.0)
    play(port := ProcessPort(Slow, ear.port), flat_out(20), FLAT_OUT, wait_for=1)
    assert port.starts == 1 and [words for words in ear.heard if "closed" in words]
    with pytest.raises(PortError, match="the port does not run"):
        port.tick("0", 0.0)


def test_a_process_that_hangs_ends_with_the_service(
    fork_server: ForkServer, ear: Ear, monkeypatch: pytest.MonkeyPatch
) -> None:
    child = fork_server.child(work, Hanging, (ear.port,))
    assert child.control.receive(20.0) == (True, "")
    child.data.send(("tick", "0", 1.0))
    ear.until(lambda heard: len(heard) == 1)
    child.control.close()  # as where the service is killed
    child.data.close()
    until(lambda: is_gone(child.process))


def test_one_that_cannot_be_made_ends_the_start(ear: Ear) -> None:
    with pytest.raises(PortError, match="far: OSError: the address is in use"):
        play(ProcessPort(Unmade, ear.port), flat_out(1))


def test_a_port_that_works_with_the_service_is_refused() -> None:
    with pytest.raises(TypeError, match=r"ToyPort\.routes: it needs the service, which its own process does not have"):
        ProcessPort(ToyPort, 1)
    with pytest.raises(TypeError, match=r"RecorderPort\.delays: no radar waits for another process"):
        ProcessPort(RecorderPort, 1)


def test_its_clock_and_its_sources_are_those_of_its_class_or_as_they_are_given() -> None:
    request = SourceRequest(labels=True)
    given, plain = ProcessPort(FarPort, 1, period=2.5, sources=request), ProcessPort(FarPort, 1)
    assert (given.period, given.sources) == (2.5, request)
    assert (plain.period, plain.sources) == (FarPort.period, SourceRequest())


def test_an_epoch_crosses_without_its_source() -> None:
    """It is asked for nothing in another process, and is small."""
    radar = RadarInfo.unnamed(Epoch("e", FakeEngine(scene()), 100.0))
    again = pickle.loads(pickle.dumps(radar)).epoch
    assert again == radar.epoch and again.layout(5).bins == 5 and again.layout(5).range == radar.epoch.layout(5).range
    assert not hasattr(again, "source") and not hasattr(again, "commands")
