"""Receives the feed of a radar: connects, checks messages, counts losses, and reconnects after a break.

    async with FeedClient("ws://127.0.0.1:8000") as radar:
        async for spoke in radar.spokes(): ...
    for spoke in spokes("ws://127.0.0.1:8000"): ...  # the same without asyncio

`radar_service.wire` defines the messages.
"""

import asyncio
import math
from collections.abc import AsyncGenerator, Callable, Iterator, Sequence
from typing import Any, Literal, Self, TypedDict, Unpack

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI

from radar_service import wire

from .address import feed_url
from .errors import FeedError, closed_error, refused_error
from .sequence import SequenceTracker
from .spoke import ReceivedSpoke, label_names, spokes_of

BACKOFF = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # s before the first, second ... attempt to reconnect; the last one repeats
TIMEOUT = 30.0  # s without a message; the slowest radar, 0.01 rpm with four azimuths, needs a longer one
CLOSE_TIMEOUT = 1.0  # s to wait for the radar's close frame; a radar with a full queue does not answer in time


class FeedOptions(TypedDict, total=False):
    """Options of a feed; see FeedClient."""

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
    labels: bool
    powers: Sequence[int] | Literal["all"]


class FeedClient:
    """A radar's feed. hello: the newest hello message, None before the first; sequence: counts of arrived and lost spokes.

    encoding, bins, truth, mode, labels, powers: parameters of the feed, sent to the service; powers: "all", or the numbers of
    sources. `label_names` then maps numbers to names.
    since: (epoch, next number) of an earlier feed, which this one continues.
    reconnect: reconnect after a break, each attempt after a wait of `backoff` [s], and continue with the next number.
    patience: [s] without any message after which the client no longer reconnects.
    notice: called with one sentence at every break and every return.
    timeout: [s] without any message after which the client closes the connection.
    token: sent to the service, which may require one.
    Raises ValueError for an unknown encoding.
    """

    def __init__(
        self, url: str, *, encoding: str = "u8", bins: int | None = None, truth: bool = False, mode: str = "live",
        since: tuple[str, int] | None = None, reconnect: bool = False, timeout: float = TIMEOUT,
        backoff: Sequence[float] = BACKOFF, patience: float = math.inf, notice: Callable[[str], None] = lambda _: None,
        token: str = "", labels: bool = False, powers: Sequence[int] | Literal["all"] = (),
    ) -> None:  # fmt: skip
        if encoding not in wire.DTYPES:
            raise ValueError(f'encoding: "{encoding}" is not one of {", ".join(wire.DTYPES)}')
        query = {"encoding": encoding, "mode": mode}
        self._query = query | ({"bins": str(bins)} if bins else {}) | ({"truth": "1"} if truth else {})
        self._query |= ({"labels": "1"} if labels else {}) | ({"powers": _powers(powers)} if powers else {})
        self._url, self._since, self._timeout = url, since, timeout
        self._backoff = tuple(backoff) if reconnect else ()
        self._patience, self._notice = patience, notice
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self.hello: dict[str, Any] | None = None
        self.sequence = SequenceTracker()
        self.reconnections = 0
        self._socket: ClientConnection | None = None
        self._address = url
        self._sees_beginnings = False  # a new epoch must then begin with number 0
        self._bye: str | None = None

    @property
    def label_names(self) -> dict[int, str]:
        """The name of each source that a label may be the number of; empty before the hello, and without labels and powers."""
        return label_names(self.hello or {})

    async def messages(self) -> AsyncGenerator[dict[str, Any], None]:
        """Yields every message after it is counted. Raises FeedError when the feed ends and cannot be reopened."""
        clock = asyncio.get_running_loop().time
        failures, last_message = 0, clock()
        while True:
            try:
                message = await self._next()
            except FeedError as fault:
                await self.close()
                wait = self._backoff[min(failures, len(self._backoff) - 1)] if self._backoff else math.nan
                in_time = clock() + wait <= last_message + self._patience  # False where wait is nan
                if not (fault.retry and self.hello and in_time):
                    raise
                self._notice(f"{str(fault).removeprefix(f'{self._address}: ')}; trying again in {wait:g} s")
                await asyncio.sleep(wait)
                failures += 1
                self.reconnections += 1
                continue
            if failures:
                self._notice(f"back after {clock() - last_message:.1f} s")
            failures = 0
            yield message
            last_message = clock()

    async def spokes(self) -> AsyncGenerator[ReceivedSpoke, None]:
        """Yields the spokes one by one, without repeats. Raises FeedError as `messages` does."""
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
        """Closes the connection; another iteration opens it again."""
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
            raise refused_error(self._address, fault) from fault
        except ConnectionClosed as fault:
            raise closed_error(self._address, fault, self._bye) from fault
        except TimeoutError as fault:
            text = f"{self._address}: no message for {self._timeout:g} s; the radar may be paused or in standby"
            raise FeedError(text, retry=True) from fault
        except (InvalidURI, InvalidHandshake) as fault:
            raise FeedError(f"{self._address}: this is no radar's feed: {fault}") from fault
        except OSError as fault:
            text = f"{self._address}: cannot connect: {fault.strerror or fault}; is the service running there?"
            raise FeedError(text, retry=True) from fault

    async def _open(self) -> None:
        since = self._since_parameter()
        self._address = feed_url(self._url, **self._query, **({"since": since} if since else {}))
        self._sees_beginnings = bool(since)  # the service then sends a new epoch from its beginning, or announces the gap
        self._bye = None
        self._socket = await connect(
            self._address,
            max_size=wire.MAX_MESSAGE,
            compression=None,
            proxy=None,  # a radar is on this machine or on the ship's own network
            open_timeout=self._timeout,
            close_timeout=CLOSE_TIMEOUT,
            additional_headers=self._headers,
        )

    def _since_parameter(self) -> str | None:
        """EPOCH:NUMBER where the feed continues, None at its start."""
        if self.sequence.epoch is not None and self.sequence.next is not None:
            return f"{self.sequence.epoch}:{self.sequence.next}"
        return f"{self._since[0]}:{self._since[1]}" if self._since else None

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
                    message["repeated"] = self.sequence.spokes(int(message["first"]), int(message["count"]))
                case "gap":
                    self._check_epoch(message)
                    self.sequence.gap(int(message["first"]), int(message["count"]))
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
        self.sequence.hello(str(message["epoch"]), 0 if self._sees_beginnings else None)
        self.hello, self._sees_beginnings = message, True

    def _check_epoch(self, message: dict[str, Any]) -> None:
        if message["epoch"] != self.sequence.epoch:
            raise ValueError(f"{message['type']} of epoch {message['epoch']!r} without its hello")


def _powers(powers: Sequence[int] | Literal["all"]) -> str:
    return powers if isinstance(powers, str) else ",".join(map(str, powers))


def spokes(url: str, **options: Unpack[FeedOptions]) -> Iterator[ReceivedSpoke]:
    """Yields the spokes of a feed without asyncio, until the caller leaves the loop. options: see FeedClient.

    The client reads the connection only while the caller waits for the next spoke. A `live` feed has gaps if the caller
    takes longer over one spoke than the service waits. Raises FeedError when the feed ends.
    """
    client = FeedClient(url, **options)
    feed, received = client.spokes(), list[ReceivedSpoke]()

    async def receive_spoke() -> (
        None
    ):  # without a result: asyncio.Runner.run formats that of its task, samples and all, and drops it
        received.append(await anext(feed))

    with asyncio.Runner() as runner:
        try:
            while True:
                runner.run(receive_spoke())
                yield received.pop()
        finally:
            runner.run(client.close())
