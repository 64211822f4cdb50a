"""What tests of ports listen with: a UDP socket, and a service with ports beside REST and the feed."""

import asyncio
import contextlib
import json
import socket
import sys
import threading
from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.processes.fork_server import ForkServer
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, steerable_scene

FLAT_OUT = Settings(pace=Pace("run", float("inf")))
PAUSED = Settings(pace=Pace("pause"))
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


def play(
    ports: Port | Sequence[Port], test: Callable[[Server], Awaitable[None]], settings: Settings = PAUSED,
    access: Access | None = None, fork_server: ForkServer | None = None, **options: Any,
) -> PortHost:  # fmt: skip
    """Runs a radar with ports beside REST and the feed; returns the host of the ports."""
    host = PortHost((RestPort(), FeedPort(), *([ports] if isinstance(ports, Port) else ports)))

    async def whole() -> None:
        engine = FakeEngine(steerable_scene())
        station = Station("0", engine, factory(), settings=settings, sinks=host.sinks("0"), **options)
        async with running(create_app([station], host, access=access, fork_server=fork_server)) as server:
            server.stations = [station]
            await test(server)
        for port in [ports] if isinstance(ports, Port) else ports:
            port.close()

    asyncio.run(asyncio.wait_for(whole(), 60))
    return host


def numbers(heard: list[dict[str, Any]]) -> list[int]:
    return [n for words in heard if "first" in words for n in range(words["first"], words["first"] + words["count"])]


def assert_accounted(heard: list[dict[str, Any]]) -> None:
    """Each number came once, or was told as lost, in rising order."""
    told = [n for words in heard if "skipped" in words for n in range(words["skipped"][0], sum(words["skipped"]))]
    seen = Counter([*numbers(heard), *told])
    assert seen and sorted(seen) == list(range(max(seen) + 1)) and set(seen.values()) == {1}
    assert numbers(heard) == sorted(numbers(heard))
