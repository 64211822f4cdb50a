"""A radar's feed that follows a script: each connection gets the next list of messages and then the next ending; and what a
client receives from it."""

import asyncio
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qsl, urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve

from clients.ppi import FeedClient, FeedError, ScanCollector
from clients.ppi import spokes as received_spokes
from clients.ppi.terminal_ppi import TerminalPpi
from radar_service import wire

TARGETS = ((30.0, 600.0), (120.0, 1100.0), (250.0, 1700.0))  # bearing in degrees, range in metres


def hello(epoch: str = "a", azimuths: int = 72, bins: int = 100, encoding: str = "u8", **changes: Any) -> dict[str, Any]:
    """A greeting of a radar that reaches 2000 m; range step 20 m with 100 bins."""
    step = 2000.0 / bins
    return {
        "type": "hello", "protocol": wire.PROTOCOL, "epoch": epoch,
        "radar": {"id": "0", "name": "test radar", "azimuths": azimuths},
        "scene": {"name": "test scene"},
        "encoding": {"name": encoding, "bins": bins, "range_first_m": step / 2, "range_step_m": step,
                     "db_per_step": 0.75, "offset_db": -180.0},
    } | changes  # fmt: skip


def spokes(greeting: dict[str, Any], data: NDArray[Any], first: int, count: int, heading_deg: float = 0.0) -> dict[str, Any]:
    """Spokes first to first + count of a radar that shows `data` (azimuths, bins) again and again; one scan at most."""
    azimuths, bins = data.shape
    index = first % azimuths
    rows = index + np.arange(count)
    return {
        "type": "spokes", "epoch": greeting["epoch"], "first": first, "count": count, "scan": first // azimuths,
        "index": index, "time": ((first + np.arange(count)) / 30.0).tolist(),
        "azimuth": wire.turn_from_radians(rows * (2 * np.pi / azimuths)),
        "heading": wire.turn_from_radians(np.full(count, np.radians(heading_deg))),
        "position": [[float(first + k), -5.0] for k in range(count)],
        "course": wire.turn_from_radians(np.full(count, 0.5)), "speed": [3.5] * count, "bins": bins,
        "range_step_m": 2000.0 / bins, "range_first_m": 1000.0 / bins, "range": 2000.0,
        "encoding": greeting["encoding"]["name"], "data": data[rows].tobytes(),
    }  # fmt: skip


def gap(greeting: dict[str, Any], first: int, count: int) -> dict[str, Any]:
    """An announced loss."""
    return {"type": "gap", "epoch": greeting["epoch"], "first": first, "count": count, "reason": "this client is too slow"}


def picture(azimuths: int = 72, bins: int = 100) -> NDArray[np.uint8]:
    """Three targets a few cells large."""
    data = np.zeros((azimuths, bins), dtype=np.uint8)
    for bearing_deg, distance in TARGETS:
        row, column = round(bearing_deg / 360 * azimuths), round(distance / 2000 * bins - 0.5)
        data[row, column - 1 : column + 2] = 255
    return data


DATA, GREETING = picture(), hello()


def batch(first: int, count: int, greeting: dict[str, Any] = GREETING, **options: Any) -> dict[str, Any]:
    """Spokes of a radar that shows `picture()`."""
    return spokes(greeting, DATA, first, count, **options)


@dataclass
class Script:
    """What one connection gets: messages, then a close with `code`. wait: keep it open until the client goes."""

    messages: Sequence[dict[str, Any] | bytes | str]
    code: int = 1001
    wait: bool = False


@dataclass
class FakeFeed:
    """The server as a test sees it. queries: the query of each connection; authorizations: the header of each, empty where
    it has none; greeted, left: set when a client has been sent all of a script, and when one has gone."""

    url: str = ""
    scripts: list[Script] = field(default_factory=list)
    queries: list[dict[str, str]] = field(default_factory=list)
    authorizations: list[str] = field(default_factory=list)
    greeted: threading.Event = field(default_factory=threading.Event)
    left: threading.Event = field(default_factory=threading.Event)

    def handle(self, connection: ServerConnection) -> None:
        """Play the next script."""
        assert connection.request is not None
        self.queries.append(dict(parse_qsl(urlsplit(connection.request.path).query)))
        self.authorizations.append(connection.request.headers.get("Authorization", ""))
        script = self.scripts.pop(0)
        try:
            for message in script.messages:
                connection.send(wire.pack(message) if isinstance(message, dict) else message)
            self.greeted.set()
            if script.wait:
                connection.recv(timeout=20)
        except ConnectionClosed:
            self.left.set()
        connection.close(script.code)

    def check(self, connection: ServerConnection, request: Request) -> Response | None:
        """Only radar 0 exists; radar 5 is broken."""
        path = urlsplit(request.path).path
        if path == "/api/radars/5/feed":
            return connection.respond(HTTPStatus.INTERNAL_SERVER_ERROR, "the engine died")
        if path != "/api/radars/0/feed":
            return connection.respond(HTTPStatus.NOT_FOUND, '{"detail": "no such radar"}')
        return None


@contextmanager
def running(*scripts: Script) -> Iterator[FakeFeed]:
    """A feed on a loopback port of the system's choice, gone when the block is left."""
    feed = FakeFeed(scripts=list(scripts))
    server: Server = serve(feed.handle, "127.0.0.1", 0, process_request=feed.check, compression=None, max_size=1024)
    feed.url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield feed
    finally:
        server.shutdown()
        thread.join(10)


def numbers(url: str, count: int, **options: Any) -> list[int]:
    """Numbers of the first `count` spokes of a feed."""
    received = []
    for spoke in received_spokes(url, timeout=10.0, **options):
        received.append(spoke.number)
        if len(received) == count:
            break
    return received


def final_error(url: str, **options: Any) -> FeedError:
    """The error with which a feed ends; fails after ten seconds if the client never gives up."""

    async def follow() -> None:
        async with FeedClient(url, timeout=10.0, **options) as client:
            async for _ in client.spokes():
                pass

    with pytest.raises(FeedError) as fault:
        asyncio.run(asyncio.wait_for(follow(), 10.0))
    return fault.value


def collected(messages: list[dict[str, Any]], keep: int | None = None) -> ScanCollector:
    """A collector that took these messages."""
    collector = ScanCollector(keep)
    for message in messages:
        collector.take(message)
    return collector


def ppi_of(*messages: dict[str, Any], **options: Any) -> TerminalPpi:
    """A PPI that took these messages."""
    made = TerminalPpi(**options)
    for message in messages:
        made.take(message)
    return made
