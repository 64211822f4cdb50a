"""The feed of a radar, received: connect, check, count what is lost, come back after a break.

    async with FeedClient("ws://127.0.0.1:8000") as radar:
        async for spoke in radar.spokes(): ...
    for spoke in spokes("ws://127.0.0.1:8000"): ...  # the same without asyncio

`radar_service.stream.wire` says what the messages hold.
"""

import asyncio
import math
from collections.abc import AsyncGenerator, Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self, TypedDict, Unpack
from urllib.parse import parse_qsl, urlencode, urlsplit, urlunsplit

import numpy as np
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI

from radar_service.stream import wire

from .ledger import Ledger

BACKOFF = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # s before the first, second ... attempt to come back; the last one repeats
TIMEOUT = 30.0  # s without a message; the slowest radar, 0.01 rpm with four azimuths, is beyond it
LEAVING = 1.0  # s for the radar to answer that we go; behind a backlog it will not be heard
REFUSED = range(4400, 4500)  # close codes for what asking again will not mend


class FeedError(Exception):
    """A feed that cannot be had, or is over. retry: whether it may come back by itself."""

    def __init__(self, text: str, retry: bool = False) -> None:
        super().__init__(text)
        self.retry = retry


@dataclass(frozen=True)
class ReceivedSpoke:
    """One azimuth as it came. SI and radians; samples (N,) in the encoding asked for, standing at `range` (N,) [m]."""

    epoch: str
    number: int  # sequence number within the epoch
    scan: int
    index: int  # row within the scan, 0 looks north
    time: float
    azimuth: float
    heading: float
    position: tuple[float, float]  # of own ship, east, north
    course: float
    speed: float
    range: NDArray[np.float64]
    range_step: float
    samples: NDArray[Any]
    blind: bool


def feed_url(url: str, **query: str) -> str:
    """The whole address of a feed from a short one: `host:port` and `http://host:port` mean the feed of radar 0.

    query: parameters that are added to, or replace, those of the address. Raises FeedError for what is no address.
    """
    parts = urlsplit(url if "://" in url else f"ws://{url}")
    scheme = {"http": "ws", "https": "wss"}.get(parts.scheme, parts.scheme)
    if scheme not in ("ws", "wss") or not parts.hostname:
        raise FeedError(f"{url}: not the address of a feed; give ws://HOST:PORT or ws://HOST:PORT/api/radars/ID/feed")
    path = parts.path.rstrip("/") or "/api/radars/0/feed"
    if path.startswith("/api/radars/") and path.count("/") == 3:
        path += "/feed"
    asked = urlencode(dict(parse_qsl(parts.query)) | query, safe=":")
    return urlunsplit((scheme, parts.netloc, path, asked, ""))


class FeedOptions(TypedDict, total=False):
    """How a feed is asked for; see FeedClient."""

    encoding: str
    bins: int | None
    truth: bool
    mode: str
    since: tuple[str, int] | None
    reconnect: bool
    timeout: float
    backoff: Sequence[float]
    patience: float
    notice: Callable[[str], None]
    token: str


class FeedClient:
    """A radar's feed. hello: the newest greeting, None before the first; ledger: what came and what was lost.

    encoding, bins, truth, mode: as the service takes them. since: (epoch, first number wanted) of an earlier feed.
    reconnect: come back after a break, after waiting `backoff` [s], and go on where it broke off, unless nothing has come
    for `patience` [s]. notice: told, in a sentence, of every break and every return.
    timeout: [s] without any message after which the feed counts as dead. token: where the service asks for one.
    """

    def __init__(
        self, url: str, *, encoding: str = "u8", bins: int | None = None, truth: bool = False, mode: str = "live",
        since: tuple[str, int] | None = None, reconnect: bool = False, timeout: float = TIMEOUT,
        backoff: Sequence[float] = BACKOFF, patience: float = math.inf, notice: Callable[[str], None] = lambda _: None,
        token: str = "",
    ) -> None:  # fmt: skip
        if encoding not in wire.DTYPES:
            raise ValueError(f'encoding: "{encoding}" is not one of {", ".join(wire.DTYPES)}')
        query = {"encoding": encoding, "mode": mode}
        self._query = query | ({"bins": str(bins)} if bins else {}) | ({"truth": "1"} if truth else {})
        self._url, self._since, self._timeout = url, since, timeout
        self._backoff = tuple(backoff) if reconnect else ()
        self._patience, self._notice = patience, notice
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self.hello: dict[str, Any] | None = None
        self.ledger = Ledger()
        self.reconnections = 0
        self._socket: ClientConnection | None = None
        self._address, self._watched = url, False
        self._bye: str | None = None

    async def messages(self) -> AsyncGenerator[dict[str, Any], None]:
        """Every message as it comes, already counted. Ends by raising FeedError, unless it may and can come back."""
        clock = asyncio.get_running_loop().time
        failures, heard = 0, clock()
        while True:
            try:
                message = await self._next()
            except FeedError as fault:
                await self.close()
                wait = self._backoff[min(failures, len(self._backoff) - 1)] if self._backoff else math.nan
                may = fault.retry and self.hello and clock() + wait <= heard + self._patience  # nan is no time to wait
                if not may:
                    raise
                self._notice(f"{str(fault).removeprefix(f'{self._address}: ')}; trying again in {wait:g} s")
                await asyncio.sleep(wait)
                failures += 1
                self.reconnections += 1
                continue
            if failures:
                self._notice(f"back after {clock() - heard:.1f} s")
            failures = 0
            yield message
            heard = clock()

    async def spokes(self) -> AsyncGenerator[ReceivedSpoke, None]:
        """The spokes one by one, each once; ends as `messages` does."""
        async for message in self.messages():
            if message["type"] == "spokes":
                try:
                    received = spokes_of(message)
                except (LookupError, TypeError, ValueError) as fault:
                    raise FeedError(f"{self._address}: spokes that cannot be used: {fault!r}") from fault
                for spoke in received:
                    if spoke.number >= message["first"] + message["repeated"]:
                        yield spoke

    async def close(self) -> None:
        """Leave the radar; iterating again comes back."""
        socket, self._socket = self._socket, None
        if socket is not None:
            await socket.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def _next(self) -> dict[str, Any]:
        try:
            if self._socket is None:
                await self._open()
            assert self._socket is not None
            async with asyncio.timeout(self._timeout):  # wait_for of Python 3.11 may swallow a cancellation
                data = await self._socket.recv(decode=False)
            return self._read(data)
        except InvalidStatus as fault:
            raise _refusal(self._address, fault) from fault
        except ConnectionClosed as fault:
            raise _ending(self._address, fault, self._bye) from fault
        except TimeoutError as fault:
            text = f"{self._address}: nothing came for {self._timeout:g} s; the radar may be paused or in standby"
            raise FeedError(text, retry=True) from fault
        except (InvalidURI, InvalidHandshake) as fault:
            raise FeedError(f"{self._address}: this is no radar's feed: {fault}") from fault
        except OSError as fault:
            text = f"{self._address}: cannot connect: {fault.strerror or fault}; is the service running there?"
            raise FeedError(text, retry=True) from fault

    async def _open(self) -> None:
        running = self.ledger.epoch is not None and self.ledger.next is not None
        since = (
            f"{self.ledger.epoch}:{self.ledger.next}" if running else self._since and f"{self._since[0]}:{self._since[1]}"
        )
        self._address = feed_url(self._url, **self._query, **({"since": since} if since else {}))
        self._watched, self._bye = (
            bool(since),
            None,
        )  # with `since` even a new epoch is sent, or announced, from its beginning
        # No proxy: a radar stands on this machine or on the ship's own network.
        self._socket = await connect(
            self._address,
            max_size=wire.MAX_MESSAGE,
            compression=None,
            proxy=None,
            open_timeout=self._timeout,
            close_timeout=LEAVING,
            additional_headers=self._headers,
        )

    def _read(self, data: bytes) -> dict[str, Any]:
        try:
            message = wire.unpack(data)
            match message["type"]:
                case "hello":
                    self._greet(message)
                case "spokes":
                    self._check_epoch(message)
                    if message["count"] != len(message["azimuth"]) and "row_first" not in message:
                        raise ValueError(f"{message['count']} spokes with {len(message['azimuth'])} azimuths")
                    message["repeated"] = self.ledger.spokes(int(message["first"]), int(message["count"]))
                case "gap":
                    self._check_epoch(message)
                    self.ledger.gap(int(message["first"]), int(message["count"]))
                case "bye":
                    self._bye = str(message["reason"])
        except (LookupError, TypeError, ValueError) as fault:
            raise FeedError(f"{self._address}: not a message of a radar's feed: {fault!r}") from fault
        return message

    def _greet(self, message: dict[str, Any]) -> None:
        if message["protocol"] != wire.PROTOCOL:
            raise FeedError(
                f"{self._address}: the radar speaks protocol {message['protocol']}, this client {wire.PROTOCOL}; "
                "use a client of the radar's version"
            )
        self.ledger.hello(str(message["epoch"]), 0 if self._watched else None)
        self.hello, self._watched = message, True

    def _check_epoch(self, message: dict[str, Any]) -> None:
        if message["epoch"] != self.ledger.epoch:
            raise ValueError(f"{message['type']} of epoch {message['epoch']!r} without its hello")


def _ending(url: str, fault: ConnectionClosed, bye: str | None) -> FeedError:
    code, said = (fault.rcvd.code, fault.rcvd.reason) if fault.rcvd else (1006, "")
    reason = bye or said or f"without a word (close code {code})"
    if code in REFUSED:
        return FeedError(f"{url}: the radar refused: {reason}")
    return FeedError(f"{url}: the radar ended the feed: {reason}", retry=True)


def _refusal(url: str, fault: InvalidStatus) -> FeedError:
    status, body = fault.response.status_code, fault.response.body or b""
    said = body.decode("utf-8", "replace").strip()[:500]
    parts = urlsplit(url)
    if status == 404:
        listing = f"{'https' if parts.scheme == 'wss' else 'http'}://{parts.netloc}/api/radars"
        said = f"there is no such radar ({said or 'not found'}); {listing} lists those there are"
    return FeedError(f"{url}: refused with HTTP {status}: {said or 'no reason given'}", retry=status >= 500)


def spokes_of(message: dict[str, Any]) -> list[ReceivedSpoke]:
    """The spokes of a `spokes` message. Raises ValueError where its parts disagree."""
    samples = wire.samples(message)
    azimuth, heading, course = (wire.radians_from_turn(message[key]) for key in ("azimuth", "heading", "course"))
    step = float(message["range_step_m"])
    places = float(message["range_first_m"]) + step * np.arange(samples.shape[1], dtype=np.float64)
    hidden = message.get("blind") or [False] * len(samples)
    offset = message.get("row_first") or range(len(samples))
    return [
        ReceivedSpoke(
            message["epoch"], message["first"] + offset[k], message["scan"], message["index"] + offset[k],
            float(message["time"][k]), float(azimuth[k]), float(heading[k]),
            (float(message["position"][k][0]), float(message["position"][k][1])), float(course[k]),
            float(message["speed"][k]), places, step, samples[k], bool(hidden[k]),
        )
        for k in range(len(samples))
    ]  # fmt: skip


def spokes(url: str, **options: Unpack[FeedOptions]) -> Iterator[ReceivedSpoke]:
    """The spokes of a feed without asyncio, until the loop is left or FeedError is raised. options: see FeedClient.

    The connection is only served while the next spoke is being waited for; take longer over one than the service's
    patience and a `live` feed will have gaps.
    """
    client = FeedClient(url, **options)
    feed = client.spokes()

    async def following() -> ReceivedSpoke:
        return await anext(feed)

    with asyncio.Runner() as runner:
        try:
            while True:
                yield runner.run(following())
        finally:
            runner.run(client.close())
