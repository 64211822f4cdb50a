"""The native feed on a websocket: who asks for what, and a mailbox emptied into a socket."""

import asyncio
import contextlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.scene.radar_model import MAX_BINS
from radar_service.stream import wire
from radar_service.stream.access import is_loopback
from radar_service.stream.hub import Refused
from radar_service.stream.mailbox import Client, Mode, View
from radar_service.stream.station import Station
from radar_service.stream.websocket import frame_writer

BAD_REQUEST, FORBIDDEN, NOT_FOUND, UNAVAILABLE = 4400, 4403, 4404, 4503
REFUSALS = {BAD_REQUEST: "feed request", FORBIDDEN: "feed rights", NOT_FOUND: "feed radar", UNAVAILABLE: "feed full or down"}
GRACE = 2.0  # s to take the last message before the line is cut
PARAMETERS = ("encoding", "bins", "truth", "mode", "since", "sector", "spokes", "compress")
MAX_MERGED = 32  # a message holds no more
TICKET = "ticket"  # read before the request comes here


@dataclass(frozen=True)
class Request:
    """What a client asks of a feed. since: epoch, and number of the first spoke that it has not had."""

    view: View = View("u8")
    mode: Mode = "live"
    truth: bool = False
    since: tuple[str, int] | None = None


def request_from_query(query: Mapping[str, str], is_near: bool = True) -> Request:
    """The request that a query string means; is_near: on this machine, where `compress=auto` is no compression.

    Raises ValueError naming the parameter, its value and what is allowed.
    """
    for key in query:
        if key not in (*PARAMETERS, TICKET):
            raise ValueError(f"{key[:40]}: the feed has no such parameter; it takes {', '.join(PARAMETERS)}")
    encoding = query.get("encoding", "u8")
    if encoding not in wire.DTYPES:
        raise ValueError(f'encoding: "{encoding[:40]}" is not one of {", ".join(wire.DTYPES)}')
    mode = query.get("mode", "live")
    if mode not in ("live", "lossless"):
        raise ValueError(f'mode: "{mode[:40]}" is not one of live, lossless')
    truth = query.get("truth", "0")
    if truth not in ("0", "1"):
        raise ValueError(f'truth: "{truth[:40]}" is not 0 or 1')
    spokes = _whole("spokes", query.get("spokes", ""), MAX_MERGED, "leave it out for every spoke") or 1
    compression = query.get("compress", "none")
    if compression not in ("none", "auto", *wire.COMPRESSIONS):
        raise ValueError(f'compress: "{compression[:40]}" is not one of none, auto, {", ".join(wire.COMPRESSIONS)}')
    packing = {"none": "", "auto": "" if is_near else "zstd"}.get(compression, compression)
    bins = _whole("bins", query.get("bins", ""), MAX_BINS, "leave it out for every cell")
    view = View(encoding, bins, _sector(query.get("sector", "")), spokes, packing)
    return Request(view, cast(Mode, mode), truth == "1", _since(query.get("since", "")))


def _whole(name: str, text: str, most: int, otherwise: str) -> int | None:
    if not text:
        return None
    if not re.fullmatch(r"[0-9]{1,6}", text) or not 1 <= int(text) <= most:
        raise ValueError(f'{name}: "{text[:40]}" is not a whole number from 1 to {most}; {otherwise}')
    return int(text)


def _sector(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    found = re.fullmatch(r"([0-9]{1,3}),([0-9]{1,3})", text)
    if not found or int(found[1]) > 360 or int(found[2]) > 360:
        raise ValueError(f'sector: "{text[:40]}" is not FROM,TO: true bearings from 0 to 360 in whole degrees, clockwise')
    return int(found[1]), int(found[2])


def _since(text: str) -> tuple[str, int] | None:
    if not text:
        return None
    found = re.fullmatch(r"([^:]{1,64}):([0-9]{1,18})", text)
    if not found:
        raise ValueError(f'since: "{text[:80]}" is not EPOCH:SEQ, the epoch and the first spoke not yet had')
    return found[1], int(found[2])


async def serve(
    socket: WebSocket, station: Station | None, may_command: bool = True, refused: Callable[[str], None] = lambda _: None
) -> None:
    """Serve one client until it goes, is let go, or the server stops. A refusal is a `bye` and a close code from 4400.

    may_command: whether it may do what others feel, as `lossless` is. refused: told the kind of a refusal.
    """
    await socket.accept()
    try:
        station, client, since = _admitted(socket, station, may_command)
        station.join(client, since)
    except _Refusal as fault:
        refused(REFUSALS[fault.code])
        return await _refuse(socket, fault.code, str(fault))
    except Refused as fault:
        refused(REFUSALS[UNAVAILABLE])
        return await _refuse(socket, UNAVAILABLE, str(fault))
    try:
        await _converse(socket, client)
    finally:
        station.leave(client)


class _Refusal(Exception):
    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


def _admitted(
    socket: WebSocket, station: Station | None, may_command: bool
) -> tuple[Station, Client, tuple[str, int] | None]:
    """The station, a client for it, and where that goes on. Raises _Refusal."""
    if station is None:
        raise _Refusal(NOT_FOUND, f'radar: there is no "{socket.path_params["radar"][:40]}"; see /api/radars')
    try:
        request = request_from_query(socket.query_params, _is_near(socket))
    except ValueError as fault:
        raise _Refusal(BAD_REQUEST, str(fault)) from None
    if request.truth and not station.allow_truth:
        raise _Refusal(FORBIDDEN, "truth: this server does not give it; start it with --truth")
    if request.mode == "lossless" and not may_command:
        raise _Refusal(FORBIDDEN, "mode: lossless holds up the radar for everybody; it needs the token to command")
    return station, Client(request.view, request.mode, request.truth), request.since


def _is_near(socket: WebSocket) -> bool:
    return socket.client is None or is_loopback(socket.client.host)


async def _refuse(socket: WebSocket, code: int, reason: str) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # it may be gone before it is told
        await socket.send_bytes(wire.pack({"type": "bye", "epoch": "", "reason": reason}))
        await socket.close(code, reason.encode()[:120].decode(errors="ignore"))  # a close frame holds 123 bytes


async def _converse(socket: WebSocket, client: Client) -> None:
    tasks = [asyncio.create_task(act) for act in (_send(socket, client), _listen(socket), _cut(client))]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    if client.closed:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            await asyncio.wait_for(socket.close(client.code), GRACE)


async def _send(socket: WebSocket, client: Client) -> None:
    client.write = write = frame_writer(socket.scope)
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket is gone, and _listen knows
        while (item := await client.get()) is not None:
            if not (write and write(item.frame)):
                await socket.send_bytes(item.data)  # which waits for room, and knows what to say of a line that is closing


async def _listen(socket: WebSocket) -> None:
    """Nothing that a client says matters, except that it goes."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass


async def _cut(client: Client) -> None:
    await client.over()
    await asyncio.sleep(GRACE)
