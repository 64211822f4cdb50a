"""Conversations by websocket: their parts end together, and reasons fit a close frame."""

import asyncio
import json

import pytest

from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.http.conversation import close_reason, until_first_ends
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.signalk.signalk_port import SignalKPort
from tests.ports.asgi import Closed
from tests.ports.playing import playing, station


async def test_the_first_part_that_ends_ends_the_others() -> None:
    ended = []

    async def part(name: str, event: asyncio.Event) -> None:
        try:
            await event.wait()
        finally:
            ended.append(name)

    first, never = asyncio.Event(), asyncio.Event()
    first.set()
    await asyncio.wait_for(until_first_ends(part("reads", never), part("writes", first)), 10)
    assert ended == ["writes", "reads"]


def test_a_reason_fits_a_close_frame_whatever_its_letters() -> None:
    """A control frame holds 125 bytes, two of them the close code (RFC 6455, section 5.5)."""
    assert close_reason("range: 5 m") == "range: 5 m"
    for letter in ("x", "é", "日", "🚢"):
        reason = close_reason(letter * 200)
        assert 116 < len(reason.encode()) <= 123 and set(reason) == {letter}


@pytest.mark.parametrize("path", ["poses", "truth/stream?radiometric=2"])
async def test_an_unknown_radar_is_refused_with_a_reason_and_counted(path: str) -> None:
    async with playing() as server:
        socket = await server.open(f"/api/radars/{'7' * 50}/{path}")
        bye = json.loads(await socket.text())
        assert bye == {"type": "bye", "reason": f'radar: there is no "{"7" * 40}"; see /api/radars'}
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4404
        assert 'reason="feed radar"} 1' in (await server.http.get("/metrics")).text


async def test_other_refusals_have_codes_of_their_own() -> None:
    async with playing() as server:
        socket = await server.open("/api/radars/0/truth/stream")
        assert "start it with --truth" in json.loads(await socket.text())["reason"]
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4403


@pytest.mark.parametrize(
    ("path", "most"),
    [
        ("/api/radars/0/truth/stream", "service.radio.truth_stream.MAX_FOLLOWERS"),
        ("/api/changes", "ports.rest.websockets.MAX_CLIENTS"), ("/signalk/v1/stream", "ports.signalk.stream.MAX_CLIENTS"),
    ],
)  # fmt: skip
async def test_too_many_clients_are_refused_until_one_leaves(path: str, most: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"radar_service.{most}", 1)
    host = PortHost((RestPort(), FeedPort(), SignalKPort(None, False)))
    async with playing(station(allow_truth=True, sinks=host.sinks("0")), ports=host) as server:
        first = await server.open(path)
        await first.text()
        second = await server.open(path)
        assert "its 1 clients" in json.loads(await second.text())["reason"]
        with pytest.raises(Closed) as closed:
            await second.text()
        assert closed.value.code == 4503
        await first.leave()
        assert "reason" not in json.loads(await (await server.open(path)).text())
