"""Radars of one world on the air: one scene and one clock for all of them."""

import asyncio
import contextlib
import threading
from collections import Counter
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest

from radar_service import wire
from radar_service.processes.call import Progress
from radar_service.scene_file.load import load_scene
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.feed_request import Mode, View
from radar_service.service.radio import status
from radar_service.service.radio.command_worker import NoRadarError
from radar_service.service.radio.radar_group import RadarGroup
from radar_service.service.radio.station import Station, Stations
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.world.error import SceneError
from radar_service.world.scene import Scene
from tests.service.fake import AZIMUTHS, RADAR, FakeEngine, factory, made_by, scene, scene_of_several

IDS = ("bow", "pier")
OTHER = SceneRequest(scene_of_several("pier", "bow", name="other"))  # in another order: bow has 36 rpm here


@contextlib.asynccontextmanager
async def playing(*ids: str, make: Any = None, **options: Any) -> AsyncIterator[Stations]:
    """Stations of a world with radars of these ids. make: makes further engines."""
    world, of, stations = RadarGroup(), scene_of_several(*ids), Stations()
    for each in ids:
        engine = (make or factory())(SceneRequest(of, radar=each), Progress())
        pause = Settings(pace=Pace("pause"))
        station = Station(each, engine, make or factory(), settings=pause, group=world, **options)
        station.stations = stations
        stations.add(station)
    for station in stations.values():
        await station.start()
    try:
        yield stations
    finally:
        for station in stations.values():
            for client in list(station.hub.clients):  # the station waits for those that stay
                station.leave(client)
        await stations.stop()


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.001)


def rpm(station: Station) -> float:
    return round(60.0 / station.epoch.info.scene.radar.rotation_period, 6)


async def test_another_scene_for_one_radar_replaces_the_world() -> None:
    async with playing(*IDS) as stations:
        bow, pier = stations.values()
        await bow.change({"pace": {"state": "step", "steps": 3}})
        await until(lambda: bow.transmitter.state.sent == 3 and pier.transmitter.pacer.idle)
        epoch, known = await pier.swap(OTHER)
        await until(lambda: all(station.epoch.info.scene.name == "other" for station in stations.values()))
        await until(lambda: pier.hub.epoch == epoch)
        assert pier.epoch.info.scene == known.scene and pier.epoch.spoke_source is not bow.epoch.spoke_source
        assert (rpm(bow), rpm(pier)) == (36, 24) and set(stations.values()) == {bow, pier}
        assert [station.transmitter.state.simulated for station in stations.values()] == [0.0, 0.0]
        assert [station.epoch.info.scene.radar_id for station in stations.values()] == ["pier", "bow"]


def of_clients(station: Station, mode: Mode = "live") -> ClientQueue:
    """A client that has joined a radar."""
    client = ClientQueue(View("u8"), mode)
    station.join(client)
    return client


async def last_of(client: ClientQueue) -> tuple[Any, int]:
    """What a client reads last, and its close code; it leaves as soon as it has read that."""
    last = None
    while (item := await client.get()) is not None:
        last = wire.unpack(item.data)
    return last, client.code


async def test_a_scene_brings_its_radars() -> None:
    """Radars that it has not end, with a reason; one that stays goes on with another epoch, and all begin together."""
    async with playing(*IDS) as stations:
        bow, pier = stations.values()
        await bow.change({"pace": {"state": "step", "steps": 3}})
        await until(lambda: bow.transmitter.state.sent == 3 and pier.transmitter.pacer.idle)
        gone, stays = of_clients(bow), of_clients(pier)
        told = asyncio.create_task(last_of(gone))
        scene_request = SceneRequest(scene_of_several("mast", "pier", "aft", name="other"))
        epoch, known = await bow.swap(scene_request)
        assert list(stations) == ["mast", "pier", "aft"] and stations["pier"] is pier
        assert known.scene.radar_id == "mast" and stations["mast"].epoch.name == epoch
        last, code = await told
        bow.leave(gone)
        assert (last["type"], code) == ("bye", 1001)
        assert last["reason"] == "radar bow has ended: another scene runs, with mast, pier, aft"
        await until(lambda: pier.epoch.info.scene.name == "other")
        await until(
            lambda: {station.hub.epoch for station in stations.values()} == {s.epoch.name for s in stations.values()}
        )
        assert [station.settings.pace for station in stations.values()] == [Pace("pause")] * 3
        assert [station.transmitter.state.simulated for station in stations.values()] == [0.0] * 3
        assert [round(rpm(station)) for station in stations.values()] == [24, 36, 48]
        assert not stays.closed and pier.hub.clients == {stays}
        pier.leave(stays)
        await stations["aft"].change({"pace": {"state": "run"}})
        await until(lambda: all(station.transmitter.state.simulated > 1.0 for station in stations.values()))
        assert bow.transmitter.state.sent == 3


async def test_scenes_with_other_radars_come_and_go_without_remains() -> None:
    made: list[FakeEngine] = []
    before = Counter(thread.name for thread in threading.enumerate())  # of other tests

    def engine(of: Scene) -> FakeEngine:
        made.append(FakeEngine(of))
        return made[-1]

    async with playing("bow", make=made_by(engine)) as stations:
        await stations["bow"].change({"pace": {"state": "run", "factor": 50.0}})
        for number in range(20):
            ids = ("bow", "pier", "mast")[: 1 + (number + 1) % 3] if number % 2 else ("aft", "pier")
            await next(iter(stations.values())).swap(SceneRequest(scene_of_several(*ids)))
            assert list(stations) == list(ids)
            await until(lambda: all(station.transmitter.state.simulated > 0.5 for station in stations.values()))
        await until(lambda: sum(not each.closed for each in made) == len(stations))
        expected = {"radar commands": 1, "radar engine": len(stations), "radar transmitter": len(stations)}
        await until(lambda: Counter(t.name for t in threading.enumerate() if t.name in expected) - before == expected)


async def test_a_radar_of_another_scene_on_the_server_keeps_its_id() -> None:
    async with playing(*IDS) as stations:
        other = Station("mast", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")), group=RadarGroup(1))
        stations.add(other)
        before = dict(stations)
        with pytest.raises(SceneError, match='radar.id: "mast" is the id of two radars; ids are unique on a server'):
            await stations["bow"].swap(SceneRequest(scene_of_several("pier", "mast")))
        assert dict(stations) == before
        await stations["bow"].change({"pace": {"state": "step", "steps": AZIMUTHS}})
        await until(lambda: stations["bow"].transmitter.state.sent == AZIMUTHS)


async def test_a_single_radar_takes_the_only_one_of_a_scene() -> None:
    """With its own id. A radar without an id that follows several has the number of the scene on the command line."""
    async with playing("bow") as stations:
        alone = stations["bow"]
        for of in (scene("plain"), scene_of_several("mast", name="named")):
            epoch, known = await alone.swap(SceneRequest(of))
            assert known.scene.name == of.name and dict(stations) == {"bow": alone}
        await until(lambda: alone.epoch.name == epoch)
        await alone.swap(OTHER)
        assert list(stations) == ["pier", "bow"] and stations["bow"] is alone
        await alone.swap(SceneRequest(scene("plain")))
        assert list(stations) == ["0"]


async def test_a_scene_that_was_requested_later_wins_also_where_its_radar_has_ended() -> None:
    async with playing(*IDS) as stations:
        bow = stations["bow"]
        later = SceneRequest(scene_of_several("pier", "aft", name="later"))
        await asyncio.gather(bow.swap(SceneRequest(scene_of_several("pier", "mast"))), bow.swap(later))
        assert list(stations) == ["pier", "aft"] and stations["aft"].epoch.info.scene.name == "later"


@pytest.mark.parametrize("has_clients", [False, True])
async def test_new_radars_wait_for_clients_while_their_group_does(has_clients: bool) -> None:
    async with playing(*IDS, wait_for=1) as stations:
        bow = stations["bow"]
        await bow.change({"pace": {"state": "run"}})
        clients = [(station, of_clients(station)) for station in stations.values() if has_clients]
        await bow.swap(SceneRequest(scene_of_several("bow", "pier", "mast")))
        assert [status.state(station) == "waiting" for station in stations.values()] == [not has_clients] * 3
        clients += [(station, of_clients(station)) for station in stations.values() if not has_clients]
        await until(lambda: all(station.transmitter.state.sent > 0 for station in stations.values()))


async def test_commands_reach_a_radar_that_has_come() -> None:
    async with playing(*IDS) as stations:
        of = load_scene({"radar": [RADAR | {"id": each} for each in ("bow", "mast")], "own_ship": {"steerable": {}}})
        pier = stations["pier"]
        await stations["bow"].swap(SceneRequest(of))
        await until(lambda: all(station.epoch.info.scene.steerable.limits for station in stations.values()))
        await stations["mast"].commands.command(None, lambda time: {"speed_kn": 1.0})
        assert [len(station.epoch.commands) for station in stations.values()] == [1, 1]
        with pytest.raises(NoRadarError, match="radar pier has ended: another scene runs, with bow, mast"):
            await pier.commands.command(None, lambda time: {"speed_kn": 2.0})


async def test_a_change_of_rpm_is_one_radars_and_the_world_goes_on() -> None:
    async with playing(*IDS) as stations:
        bow, pier = stations.values()
        before = pier.epoch.spoke_source
        await bow.change({"rpm": 48.0})
        await until(lambda: rpm(bow) == 48)
        assert rpm(pier) == 36 and pier.epoch.spoke_source is before
        await bow.change({"pace": {"state": "run"}})
        sent = [station.transmitter.state.simulated for station in stations.values()]
        await until(
            lambda: all(s.transmitter.state.simulated > t + 1.0 for s, t in zip(stations.values(), sent, strict=True))
        )
        assert abs(bow.transmitter.state.simulated - pier.transmitter.state.simulated) < 1.0
