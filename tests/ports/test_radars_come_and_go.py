"""Scenes with other radars on a service with all ports: each follows those that come, and is told of those that go."""

import asyncio
import contextlib
import json
import re
from collections.abc import AsyncIterator, Callable, Sequence
from pathlib import Path
from typing import Any, cast

import pytest

from radar_service.ports.ais.ais_port import AisPort
from radar_service.ports.nmea.nmea_port import NmeaPort
from radar_service.ports.nmea_in.receivers import Receiver
from radar_service.ports.nmea_in.steering_port import SteeringPort
from radar_service.ports.port import Port
from radar_service.ports.recorder.recorder_port import RecorderPort
from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.ports.udp.udp_port import Sender
from radar_service.recording.chunk_table import ChunkTable, recorded_radars
from radar_service.recording.recording import Recording
from radar_service.records.cell_sources import SourceRequest
from radar_service.scene_file.load import load_scene
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Closed, Server
from tests.ports.playing import joined
from tests.service.fake import AZIMUTHS, RADAR

REASON = "radar 0 has ended: another scene runs, with ship, shore"
SIGNALK = "/signalk/v2/api/vessels/self/radars"


def scene(*ids: str, name: str = "mine") -> dict[str, Any]:
    """A scene with a radar of each id, or with one that has none."""
    radar: Any = [RADAR | {"id": each} for each in ids] if ids else RADAR
    return {"name": name, "radar": radar, "own_ship": {"steerable": {}, "mmsi": 211_000_000},
            "origin": {"latitude_deg": 54.0, "longitude_deg": 8.0}}  # fmt: skip


@contextlib.asynccontextmanager
async def playing(*ports: Port, pace: float = 4.0) -> AsyncIterator[Server]:
    """A radar without an id with REST, the feed and more ports, none of which has faults."""
    settings = Settings(pace=Pace("run", pace))
    async with joined(*ports, scenes=[load_scene(scene(name="first"))], settings=settings) as (server, host):
        yield server
    assert sum(thread.faults for thread in host.threads.values()) == 0


async def put(server: Server, radar: str, *ids: str, name: str = "mine") -> dict[str, Any]:
    """Runs a scene with radars of these ids; returns the answer."""
    answer = await server.http.put(f"/api/radars/{radar}/scene", json={"scene": scene(*ids, name=name)})
    assert answer.status_code == 200, answer.text
    result: dict[str, Any] = answer.json()
    return result


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.005)


async def test_rest_lists_those_that_have_come_and_says_which_have_gone() -> None:
    async with playing() as server:
        changes, poses = await server.open("/api/changes"), await server.open("/api/radars/0/poses")
        feed = await server.feed("?mode=live")
        answer = await put(server, "0", "ship", "shore")
        assert (answer["name"], answer["radars"]) == ("mine", ["ship", "shore"])
        listed = (await server.http.get("/api/radars")).json()
        assert [(radar["id"], radar["feed"]) for radar in listed] == [
            ("ship", "/api/radars/ship/feed"), ("shore", "/api/radars/shore/feed"),
        ]  # fmt: skip
        assert listed[0]["epoch"] == answer["epoch"] and {radar["controls"]["pace"]["factor"] for radar in listed} == {4.0}
        gone = await server.http.get("/api/radars/0")
        assert gone.status_code == 404 and gone.json()["detail"] == ['radar: there is no "0"; there are ship, shore']
        assert (await feed.until("bye"))["reason"] == REASON
        with pytest.raises(Closed, match="1001"):
            await feed.receive()
        assert json.loads(await poses.text()) == {"type": "bye", "reason": REASON}
        with pytest.raises(Closed, match="1001"):
            await poses.text()
        told: dict[str, Any] = {}
        while "0" not in told or not {"ship", "shore"} <= told.keys():
            change = json.loads(await changes.text())
            if change["radar"] != "0" or change["values"].get("state") == "ended":
                told[change["radar"]] = change["values"]
        assert told["0"] == {"state": "ended", "fault": REASON, "factor_reached": None}
        metrics = (await server.http.get("/metrics")).text
        assert set(re.findall(r'radar_azimuths_total{radar="(.*?)"}', metrics)) == {"ship", "shore"}
        assert [radar["id"] for radar in (await server.http.get("/api/health")).json()["radars"]] == ["ship", "shore"]
        command = await server.http.patch("/api/radars/shore/own-ship", json={"speed_kn": 3})
        assert command.status_code == 200, command.text


async def test_a_radar_that_stays_keeps_its_clients() -> None:
    async with playing() as server:
        await put(server, "0", "ship", "shore")
        feed = await server.feed("?mode=live", radar="shore")
        assert (await feed.until("hello"))["radar"]["id"] == "shore"
        answer = await put(server, "ship", "shore", "pier", name="next")
        assert answer["radars"] == ["shore", "pier"]
        hello = await feed.until("hello")
        assert (hello["scene"]["name"], hello["epoch"], hello["radar"]["id"]) == ("next", answer["epoch"], "shore")


async def test_an_id_of_another_scene_of_the_server_is_refused_and_all_go_on() -> None:
    async with playing() as server:
        answer = await server.http.put("/api/radars/0/scene", json={"scene": scene("ship", "ship")})
        assert answer.status_code == 422
        assert [radar["id"] for radar in (await server.http.get("/api/radars")).json()] == ["0"]


async def test_signalk_has_those_that_are_there() -> None:
    async with playing(SignalKPort()) as server:
        stream = await server.open("/signalk/v1/stream?subscribe=all")
        await put(server, "0", "ship", "shore")
        assert list((await server.http.get(SIGNALK)).json()["radars"]) == ["sim-ship", "sim-shore"]
        while '"radars.sim-shore.controls.gain"' not in await stream.text():
            pass
        while '"navigation.position"' not in await stream.text():  # of own ship, by the first radar
            pass
        await put(server, "ship", "shore")
        late = await server.open("/signalk/v1/stream?subscribe=all")
        await late.text()
        paths = set(re.findall(r"radars\.(sim-\w+)\.", await late.text()))
        assert paths == {"sim-shore"}


class Kept(Sender):
    """Keeps what it is given. May be asked from any thread."""

    lost = 0

    def __init__(self) -> None:
        self.count = 0

    def send(self, lines: Sequence[bytes]) -> None:
        self.count += len(lines)

    def close(self) -> None:
        """Nothing to close."""


async def test_sentences_are_about_the_first_radar_or_one_by_its_id() -> None:
    first, named, ais = Kept(), Kept(), Kept()
    async with playing(NmeaPort([first]), NmeaPort([named], "0"), AisPort([ais])) as server:
        await until(lambda: min(first.count, named.count, ais.count) > 0)
        await put(server, "0", "ship", "shore")
        before, silent, ships = first.count, named.count, ais.count
        await until(lambda: first.count > before + 50 and ais.count > ships)
        assert named.count <= silent + 10  # those of a tick that had begun
        silent = named.count
        await put(server, "ship")
        await until(lambda: named.count > silent)


class Talking:
    sockets = ()

    def received(self, count: Callable[[str], None]) -> list[tuple[str, list[bytes]]]:
        return [("a", [b"$GPHDT,77.0,T*05"])]

    def close(self) -> None:
        """Nothing to close."""


async def test_sentences_steer_the_radar_of_their_option_and_are_counted_while_it_is_not_there() -> None:
    port = SteeringPort([cast(Receiver, Talking())], "0")

    async def refused(server: Server) -> bool:
        return 'reason="nmea-radar"' in (await server.http.get("/metrics")).text

    async with playing(port) as server:
        station = server.stations[0]
        await until(lambda: len(station.epoch.commands) > 0)
        assert not await refused(server)
        await put(server, "0", "ship", "shore")
        while not await refused(server):
            await asyncio.sleep(0.005)


async def test_all_is_in_one_recording(tmp_path: Path) -> None:
    """A radar that comes back goes on in its channels; each epoch can be read."""
    path = tmp_path / "day.mcap"
    async with playing(RecorderPort(path, True, SourceRequest()), pace=50.0) as server:

        async def sent(*radars: str) -> None:
            while True:
                states = {
                    radar["id"]: radar["simulated_s"] for radar in (await server.http.get("/api/health")).json()["radars"]
                }
                if all(states[radar] > 3.0 for radar in radars):
                    return
                await asyncio.sleep(0.005)

        await sent("0")
        await put(server, "0", "ship", "shore")
        await sent("ship", "shore")
        await put(server, "ship")
        await sent("0")
    table = ChunkTable(path)
    assert sorted(recorded_radars(table)) == ["0", "ship", "shore"]
    for radar, names in (("0", ["first", "mine"]), ("ship", ["mine"]), ("shore", ["mine"])):
        epochs = [Recording(path, radar, number) for number in range(len(names))]
        assert [epoch.scene.name for epoch in epochs] == names and epochs[0].epochs == len(names)
        assert all(len(next(epoch.scans()).azimuth) == AZIMUTHS for epoch in epochs)
