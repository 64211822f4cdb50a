"""The websocket feed of any codec: admits a client, and empties its queue into the socket.

Errors on purpose of a client's connection act here: it carries few bytes per second, or is cut.
"""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence

from fastapi import APIRouter
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.ports.http.conversation import (
    BAD_REQUEST,
    FORBIDDEN,
    NOT_FOUND,
    REFUSALS,
    UNAVAILABLE,
    close_reason,
    until_first_ends,
    until_gone,
)
from radar_service.ports.http.security import ROLE
from radar_service.ports.http.websocket import framed
from radar_service.ports.port import Port, Service
from radar_service.ports.roles import needs
from radar_service.service.access import Access, is_loopback
from radar_service.service.codecs.codec import CODECS, Codec
from radar_service.service.fanout.client_queue import GRACE, ClientQueue
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.feed_request import FeedRequest, View
from radar_service.service.radio.station import Station
from radar_service.world import ErrorSettings, FeedErrors

SLICE = 0.25  # s after which the errors are read again
NO_ERRORS = FeedErrors(0.0, 0.0, 1, 0.0, 0.0, 0.0, 0.0, None, (), None, None)
Since = tuple[str, int] | None


class FeedPort(Port):
    """The websockets of spokes. Their sink belongs to each radar: lossless clients delay it."""

    name, delays = "feed", True

    def routes(self, service: Service) -> Sequence[APIRouter]:
        """Returns the feeds."""
        return (feed_routes(service.stations, service.access, service.refused, self.name),)


class ConnectionErrors:
    """Slows or cuts one connection, which begins now. errors: returns those in force, which may change."""

    def __init__(
        self, errors: Callable[[], ErrorSettings | None], clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:  # fmt: skip
        self._errors, self._clock, self._sleep = errors, clock, sleep
        self._since = clock()

    @property
    def is_cut(self) -> bool:
        """Whether the connection has reached the age at which it is cut."""
        cut_after = self._feed.cut_after
        return cut_after is not None and self._clock() - self._since >= cut_after

    async def carry(self, size: int) -> None:
        """Waits as long as a message of `size` bytes takes, or until the connection is cut or not slow any more."""
        left = float(size)
        while left > 0.0 and (rate := self._feed.bytes) is not None and not self.is_cut:
            seconds = min(left / rate, SLICE)
            await self._sleep(seconds)
            left -= seconds * rate

    def is_faulty(self) -> bool:
        """Whether the connection is slow or to be cut, so that `carry` comes before each message."""
        errors = self._errors()  # read for each message of each client
        return errors is not None and errors.feed is not None and (self._feed.bytes, self._feed.cut_after) != (None, None)

    @property
    def _feed(self) -> FeedErrors:
        errors = self._errors()
        return errors.feed if errors and errors.feed else NO_ERRORS


def feed_routes(stations: Mapping[str, Station], access: Access, refused: Callable[[str], None], port: str) -> APIRouter:
    """Returns one websocket route for each registered codec of a port."""
    router = APIRouter()

    def add(codec: Codec) -> None:
        @router.websocket(codec.path)
        @needs("read")
        async def feed(socket: WebSocket, radar: str) -> None:
            may_delay = access.lossless or access.may(socket.scope.get(ROLE), "command")
            await serve(socket, codec, stations.get(radar), may_delay, refused)

    for codec in CODECS.values():
        if codec.port == port:
            add(codec)
    return router


async def serve(
    socket: WebSocket, codec: Codec, station: Station | None, may_delay: bool, refused: Callable[[str], None],
    request: FeedRequest | None = None,
) -> None:  # fmt: skip
    """Serves one client until it leaves, is disconnected, or the server stops.

    A refusal is a `bye` and a close code from 4400. may_delay: whether the client may use `lossless`, which delays the
    radar for everybody; refused: is called with the kind of a refusal; request: by default that of the address.
    """
    await socket.accept()
    try:
        station, client, since = _admit(socket, codec, station, may_delay, request)
        station.join(client, since)
    except _Refusal as error:
        refused(REFUSALS[error.code])
        return await _refuse(socket, codec, error.code, str(error))
    except FeedRefused as error:
        refused(REFUSALS[UNAVAILABLE])
        return await _refuse(socket, codec, UNAVAILABLE, str(error))
    try:
        if websocket := framed(socket.scope):
            websocket.on_end(lambda code, reason: client.end(codec.bye(station.hub.epoch, reason), code))
        await _converse(socket, client, ConnectionErrors(lambda: station.errors.errors))
    finally:
        station.leave(client)


class _Refusal(Exception):
    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


def _admit(
    socket: WebSocket, codec: Codec, station: Station | None, may_delay: bool, request: FeedRequest | None
) -> tuple[Station, ClientQueue, Since]:
    """Returns the station, a queue for the client, and where the client resumes. Raises _Refusal."""
    if station is None:
        raise _Refusal(NOT_FOUND, f'radar: there is no "{socket.path_params["radar"][:40]}"; see /api/radars')
    is_local = socket.client is None or is_loopback(socket.client.host)
    try:
        request = request or codec.request(socket.query_params, is_local)
    except ValueError as error:
        raise _Refusal(BAD_REQUEST, str(error)) from None
    if request.truth and not station.allow_truth:
        raise _Refusal(FORBIDDEN, "truth: this server does not send it; start it with --truth")
    _check_sources(station, request.view)
    if request.mode == "lossless" and not may_delay:
        raise _Refusal(FORBIDDEN, "mode: lossless delays the radar for everybody; it needs the token to command")
    owner = socket.client.host if socket.client else ""
    return station, ClientQueue(request.view, request.mode, request.truth, owner=owner), request.since


def _check_sources(station: Station, view: View) -> None:
    """Raises _Refusal where the client may not have, or the radar cannot tell, what it requests of the sources."""
    if not view.sources:
        return
    if not station.allow_truth:
        raise _Refusal(FORBIDDEN, "labels and powers: this server does not send them; start it with --truth")
    try:
        station.epoch.info.sources.check(view.sources)
    except ValueError as error:
        raise _Refusal(BAD_REQUEST, str(error)) from None


async def _refuse(socket: WebSocket, codec: Codec, code: int, reason: str) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the client may have left already
        if last := codec.bye("", reason):
            await socket.send_bytes(last)
        await socket.close(code, close_reason(reason))


async def _converse(socket: WebSocket, client: ClientQueue, errors: ConnectionErrors) -> None:
    await until_first_ends(_send(socket, client, errors), until_gone(socket), client.ended())
    if client.closed:
        websocket = framed(socket.scope)
        if websocket:
            websocket.write_last()
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            async with asyncio.timeout(GRACE):
                for item in client.rest():
                    if item.data:
                        await socket.send_bytes(item.data)
                await socket.close(client.code)
            if websocket:
                await websocket.flushed()


async def _send(socket: WebSocket, client: ClientQueue, errors: ConnectionErrors) -> None:
    """Returns when the socket has closed, after the last message, and where the connection is cut on purpose."""
    websocket = framed(socket.scope)
    write = websocket.write_frame if websocket else None
    client.write, client.is_held = write, errors.is_faulty
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; until_gone returns too
        while (item := await client.get()) is not None:
            await errors.carry(len(item.data))
            if errors.is_cut:
                return
            if item.data and not (write and write(item.frame)):
                await socket.send_bytes(item.data)  # which waits for room and raises where the socket closes
