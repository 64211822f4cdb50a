"""The websocket of the truth: JSON Lines in step with the feed, and refusals with a reason."""

import json
from typing import Any

import pytest

from radar_service.records.fidelity import PRESETS
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Closed, Server, Socket
from tests.ports.playing import playing, station
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene

PATH = "/api/radars/0/truth/stream"


async def line(socket: Socket) -> dict[str, Any]:
    return dict(json.loads(await socket.text()))


async def step(server: Server, spokes: int) -> None:
    await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": spokes}})


async def test_lines_come_in_step_with_the_spokes() -> None:
    async with playing(station(allow_truth=True)) as server:
        truth, feed = await server.open(PATH), await server.feed()
        assert (await line(truth))["type"] == "header"
        await step(server, AZIMUTHS // 2)
        await feed.spokes(AZIMUTHS // 2)
        first = await line(truth)
        assert (first["type"], first["spoke"], first["scan"]) == ("crossing", 8, 0)
        await step(server, AZIMUTHS - AZIMUTHS // 2)
        assert [(await line(truth))["type"] for _ in range(2)] == ["crossing", "snapshot"]


async def test_the_power_of_bodies_is_asked_for_by_the_address() -> None:
    async with playing(station(allow_truth=True)) as server:
        truth, feed = await server.open(f"{PATH}?radiometric=1"), await server.feed()
        assert (await line(truth))["type"] == "header"
        await step(server, AZIMUTHS)
        await feed.spokes(AZIMUTHS)
        assert (await line(truth))["snr_db"] == 20.0
        wrong = await server.open(f"{PATH}?radiometric=yes")
        assert (await line(wrong))["reason"] == 'radiometric: "yes" is not 0 or 1; leave it out for 0'
        with pytest.raises(Closed) as closed:
            await wrong.text()
        assert closed.value.code == 4400


async def test_the_specification_as_printed_has_no_power_to_tell() -> None:
    engine = FakeEngine(scene())
    engine.fidelity = PRESETS["documented"]
    async with playing(Station("0", engine, factory(), settings=Settings(pace=Pace("pause")), allow_truth=True)) as server:
        reason = (await line(await server.open(f"{PATH}?radiometric=1")))["reason"]
        assert reason.startswith("radiometric: the fidelity documented has none")
        assert (await line(await server.open(PATH)))["type"] == "header"


async def test_a_server_that_stops_says_bye() -> None:
    only = station(allow_truth=True)
    async with playing(only) as server:
        socket = await server.open(PATH)
        await line(socket)
        only.truth_stream.end("the server is stopping")
        assert await line(socket) == {"type": "bye", "reason": "the server is stopping"}
