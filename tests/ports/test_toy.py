"""A foreign port is one folder and one line: it has options, routes with roles, sinks and a clock, and harms nobody."""

import asyncio
import contextlib
import json
import logging
import socket
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
from fastapi import APIRouter

from radar_service.commands.command_line import parser
from radar_service.ports import port_thread, registry
from radar_service.ports.port import Service
from radar_service.service.access import Access
from radar_service.service.settings import Pace, Settings
from radar_service.terminal.arguments import UsageError
from tests.plug_ins import join
from tests.ports.asgi import Closed, Server
from tests.ports.playing import FLAT_OUT, PAUSED, play
from tests.ports.toy import ToyPort
from tests.service.fake import AZIMUTHS

TOKEN = "command-" * 3
SO_RCVBUFFORCE = 33  # of Linux


class Ear:
    """A UDP socket that listens. heard: all words, in order."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
        if sys.platform == "linux":
            with contextlib.suppress(PermissionError):  # beyond what the system allows to all, 208 KiB as a rule
                self._socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 2**22)
        self._socket.bind(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        self.heard: list[dict[str, Any]] = []
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while data := self._socket.recv(2**16):
            with self._changed:
                self.heard.append(json.loads(data))
                self._changed.notify_all()

    def until(self, condition: Callable[[list[dict[str, Any]]], bool]) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: condition(self.heard), 60.0), self.heard[-5:]

    def close(self) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as last:
            last.sendto(b"", ("127.0.0.1", self.port))
        self._thread.join(10.0)
        self._socket.close()


def numbers(heard: list[dict[str, Any]]) -> list[int]:
    return [n for words in heard if "first" in words for n in range(words["first"], words["first"] + words["count"])]


def assert_accounted(heard: list[dict[str, Any]]) -> None:
    """Each number came once, or was told as lost, in rising order."""
    told = [n for words in heard if "skipped" in words for n in range(words["skipped"][0], sum(words["skipped"]))]
    seen = Counter([*numbers(heard), *told])
    assert seen and sorted(seen) == list(range(max(seen) + 1)) and set(seen.values()) == {1}
    assert numbers(heard) == sorted(numbers(heard))


@pytest.fixture
def ear() -> Iterator[Ear]:
    made = Ear()
    yield made
    made.close()


def test_it_is_one_entry_point(monkeypatch: pytest.MonkeyPatch, ear: Ear) -> None:
    join(monkeypatch, "ports", "toy", "tests.ports.toy")
    with registry.opened(parser().parse_args(["serve"])) as ports:
        assert [port.name for port in ports] == ["feed", "rest"]
    with registry.opened(parser().parse_args(["serve", "--toy", str(ear.port)])) as ports:
        assert [port.name for port in ports] == ["feed", "rest", "toy"]
    with (
        pytest.raises(UsageError, match="--toy: 0 is not a port"),
        registry.opened(parser().parse_args(["serve", "--toy", "0"])),
    ):
        pass


def test_spokes_changes_and_times_go_out(ear: Ear) -> None:
    async def test(server: Server) -> None:
        await server.step(7)
        await asyncio.to_thread(ear.until, lambda heard: len(numbers(heard)) >= 7)
        await server.http.patch("/api/radars/0/controls", json={"gain": 61, "transmit": False})
        await server.http.patch("/api/radars/0/bodies/buoy", json={"speed_kn": 5})
        await asyncio.to_thread(ear.until, lambda heard: any(words.get("changed") == "commands" for words in heard))

    play(ToyPort(ear.port), test)
    assert numbers(ear.heard) == list(range(7))
    changes = [(words["changed"], words["values"]) for words in ear.heard if "changed" in words]
    assert [kind for kind, _ in changes[:3]] == ["status", "scene", "controls"]  # all of the state first
    assert changes[1][1]["name"] == "steerable" and changes[1][1]["epoch"] and changes[2][1]["pace"]["state"] == "pause"
    assert ("controls", {"gain": 61.0, "gain_auto": False, "transmit": False}) in changes
    assert changes[-1][1]["bodies"]["buoy"]["speed_kn"] == pytest.approx(5.0)
    assert [words for words in ear.heard if "opened" in words] == [{"radar": "0", "opened": "steerable"}]


@pytest.mark.parametrize("settings", [PAUSED, Settings(transmit=False), Settings(transmit=False, pace=Pace("run", 20.0))])
def test_its_clock_runs_in_a_pause_and_in_standby(settings: Settings, ear: Ear) -> None:
    """In standby the world's time goes on, in a pause it stands."""

    async def test(server: Server) -> None:
        await asyncio.to_thread(ear.until, lambda heard: sum("time" in words for words in heard) >= 4)

    play(ToyPort(ear.port), test, settings)
    times = [words["time"] for words in ear.heard if "time" in words]
    assert not numbers(ear.heard) and times == sorted(times)
    if settings.pace.state == "pause":
        assert set(times) == {0.0}
    else:
        assert all(time >= times[0] + ToyPort.period * number for number, time in enumerate(times))


def test_its_routes_have_their_roles(ear: Ear) -> None:
    async def test(server: Server) -> None:
        assert (await server.http.get("/toy")).json() == ["0"]
        with pytest.raises(Closed):
            await server.open("/toy/0")
        client = await server.open("/toy/0", authorization=f"Bearer {TOKEN}")
        await client.say(text='{"gain": 33}')
        assert await client.text() == "33.0"
        for wrong in ('{"gain": 333}', "rubbish", '{"gain": "34"}', '{"range": 1e9}'):
            await client.say(text=wrong)
            assert (await client.text()).startswith("refused: ")
        assert server.stations[0].controls()["gain"] == 33

    play(ToyPort(ear.port), test, access=Access(TOKEN))


class Healthy(ToyPort):
    name = "healthy"

    def routes(self, service: Service) -> Sequence[APIRouter]:
        return ()


class Raising(ToyPort):
    def say(self, words: dict[str, Any]) -> None:
        raise RuntimeError("a fault of the toy")


class Blocking(ToyPort):
    """Blocks until it is closed."""

    def __init__(self, port: int) -> None:
        super().__init__(port)
        self.gate = threading.Event()

    def say(self, words: dict[str, Any]) -> None:
        self.gate.wait(60.0)
        super().say(words)

    def close(self) -> None:
        self.gate.set()
        super().close()


class Flooding(ToyPort):
    """Answers each call with two hundred datagrams."""

    def say(self, words: dict[str, Any]) -> None:
        for _ in range(200):
            super().say(words)


@pytest.mark.parametrize("kind", [Raising, Blocking, Flooding])
def test_a_port_that_raises_blocks_or_floods_harms_nobody(
    kind: type[ToyPort], ear: Ear, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lossless client gets each spoke, and another port each or the news of its loss, while the queue of this one overflows."""
    monkeypatch.setattr(port_thread, "MAX_BYTES", 4096)
    monkeypatch.setattr("radar_service.ports.port_host.STOP_SECONDS", 0.1)
    nowhere = Ear()

    async def test(server: Server) -> None:
        got = await (await server.feed("?mode=lossless")).spokes(40 * AZIMUTHS)
        assert [n for m in got for n in range(m["first"], m["first"] + m["count"])][: 40 * AZIMUTHS] == list(
            range(40 * AZIMUTHS)
        )
        assert (await server.http.get("/api/health")).json()["status"] == "ok"
        assert server.stations[0].transmitter.state.restarts == 0

    with caplog.at_level(logging.ERROR, "radar_service"):
        host = play((kind(nowhere.port), Healthy(ear.port)), test, FLAT_OUT, wait_for=1)
    nowhere.close()
    assert_accounted(ear.heard)
    (thread,) = [thread for port, thread in host.threads.items() if port.name == "toy"]
    assert (thread.faults if kind is Raising else thread.dropped) > 0
    assert ("a fault of the toy" in str([getattr(r, "fields", "") for r in caplog.records])) is (kind is Raising)
