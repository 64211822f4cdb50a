"""What fan-out costs: the same bytes to many readers, by this service's feed and by a bare server, in turns.

    python -m tests.measurements.fanout BYTES SECONDS    prints messages a second of both, and their ratio
    python -m tests.measurements.fanout feed|raw BYTES   serves one of them until it is terminated

Closed loop: a message goes out when everybody has room for it; each turn of the event loop is one message to all. `raw`
writes bytes to sockets and knows nothing; `feed` is hub, client queues, websocket server and all, with lossless clients.
"""

import asyncio
import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import cast

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.ports.http.server import Requests, Server, configuration, listening_socket
from radar_service.service.fanout.hub import EncodedBatch
from radar_service.service.feed_request import View
from radar_service.service.radio.station import Station, Stations
from radar_service.service.settings import Pace, Settings
from tests.measurements.load import connected
from tests.service.fake import FakeEngine, factory, scene

READERS, TURNS = 100, 3
WARM_UP = 0.5  # s before counting
QUERY = "mode=lossless"


class Raw(asyncio.Protocol):
    """A connection of the bare server."""

    def __init__(self, everybody: "Everybody") -> None:
        self._everybody = everybody

    def connection_made(self, transport: asyncio.BaseTransport) -> None:

        self.transport = cast(asyncio.WriteTransport, transport)
        self._everybody.connections.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._everybody.connections.discard(self)
        self.resume_writing()

    def pause_writing(self) -> None:
        self._everybody.full.add(self)
        self._everybody.room.clear()

    def resume_writing(self) -> None:
        self._everybody.full.discard(self)
        if not self._everybody.full:
            self._everybody.room.set()


class Everybody:
    """Who is connected to the bare server, and who of them has no room."""

    def __init__(self) -> None:
        self.connections, self.full, self.room = set[Raw](), set[Raw](), asyncio.Event()
        self.room.set()


async def raw(size: int) -> None:
    """The bare server."""
    everybody, data = Everybody(), bytes(size)
    listener = listening_socket("127.0.0.1", 0)
    await asyncio.get_running_loop().create_server(lambda: Raw(everybody), sock=listener)
    print(f"http://127.0.0.1:{listener.getsockname()[1]}/", flush=True)
    while True:
        for connection in list(everybody.connections):
            connection.transport.write(data)
        await everybody.room.wait()
        await asyncio.sleep(0 if everybody.connections else 0.01)


async def feed(size: int) -> None:
    """The service, its own radar paused, publishing one message over and over."""
    station = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")))
    requests = Requests()
    config = configuration(create_app([station], requests=requests), connections=2000)
    config.lifespan = "on"
    view = View("u8")

    async def publish() -> None:
        while not server.started:
            await asyncio.sleep(0.01)
        data = wire.pack({"type": "spokes", "epoch": station.hub.epoch, "first": 0, "count": 1, "data": b""})
        data += bytes(size - len(data))
        while True:
            await station.hub.publish(EncodedBatch(station.hub.epoch, station.hub.next, 1, {view: data}))
            await asyncio.sleep(0 if station.hub.clients else 0.01)

    server = Server(config, Stations([station]).stop, requests)
    publishing = asyncio.create_task(publish())
    await server.serve(sockets=[listening_socket("127.0.0.1", 0)])
    publishing.cancel()


def serve(kind: str, size: int) -> None:
    """One of the two, until SIGTERM."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    loop_factory = configuration(create_app([])).get_loop_factory()
    with asyncio.Runner(loop_factory=loop_factory) as runner:
        runner.run({"raw": raw, "feed": feed}[kind](size))


@contextlib.contextmanager
def serving(kind: str, size: int) -> Iterator[tuple[str, int, int]]:
    """Host, port and process of one of the two in a process of its own."""
    command = [sys.executable, "-m", "tests.measurements.fanout", kind, str(size)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        host, _, port = process.stdout.readline().split("http://")[1].strip(" /\n").partition(":")
        try:
            yield host, int(port), process.pid
        finally:
            process.kill()


def processor(process: int) -> float:
    """Processor time that a process has had [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def rate(address: tuple[str, int], process: int, kind: str, seconds: float) -> tuple[float, float]:
    """Bytes that all readers get together in a second, and in a second of the server's processor time."""
    readers = [connected(address, QUERY) if kind == "feed" else socket.create_connection(address) for _ in range(READERS)]
    by_number, poll = {reader.fileno(): reader for reader in readers}, select.epoll()
    for number, reader in by_number.items():
        reader.setblocking(False)
        poll.register(number, select.EPOLLIN)
    buffer, got, used = memoryview(bytearray(1 << 20)), 0, 0.0
    begun, end = time.monotonic() + WARM_UP, time.monotonic() + WARM_UP + seconds
    while (now := time.monotonic()) < end:
        if not used and now >= begun:
            got, begun, used = 0, now, processor(process)
        for number, _ in poll.poll(0.1):
            got += by_number[number].recv_into(buffer)
    used = processor(process) - used
    for reader in readers:
        reader.close()
    return got / (now - begun), got / used


@dataclass(frozen=True)
class Fanout:
    """Messages of so many bytes, by the feed and by the bare server: in a second, and in one of processor time."""

    size: int
    feed: float
    raw: float
    feed_core: float
    raw_core: float

    @property
    def ratio(self) -> float:
        """Of the feed to the bare server."""
        return self.feed / self.raw

    @property
    def ratio_core(self) -> float:
        """The same in processor time, for machines that others use."""
        return self.feed_core / self.raw_core


def compared(size: int, seconds: float) -> Fanout:
    """Both in turns, so many seconds each; the median of each."""
    rates: dict[str, list[tuple[float, float]]] = {"feed": [], "raw": []}
    for _ in range(TURNS):
        for kind, result in rates.items():
            with serving(kind, size) as (host, port, process):
                result.append(rate((host, port), process, kind, seconds / TURNS))
    (feed, feed_core), (raw, raw_core) = (
        [median(geometry) / size for geometry in zip(*rates[k], strict=True)] for k in rates
    )
    return Fanout(size, feed, raw, feed_core, raw_core)


if __name__ == "__main__":
    if sys.argv[1] in ("raw", "feed"):
        serve(sys.argv[1], int(sys.argv[2]))
    else:
        result = compared(int(sys.argv[1]), float(sys.argv[2]))
        print(json.dumps(vars(result) | {"ratio": round(result.ratio, 3), "ratio_core": round(result.ratio_core, 3)}))
