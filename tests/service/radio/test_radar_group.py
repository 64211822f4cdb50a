"""Radars of one world on the air: one scene and one clock for all of them."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.feed_request import View
from radar_service.service.radio import status
from radar_service.service.radio.radar_group import RadarGroup
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.world.error import SceneError
from tests.service.fake import AZIMUTHS, RADAR, FakeEngine, factory, scene, scene_of_several

IDS = ("bow", "pier")
OTHER = SceneRequest(scene_of_several("pier", "bow", name="other"))  # in another order: bow has 36 rpm here


def play(test: Callable[[dict[str, Station]], Awaitable[None]], *ids: str, **options: Any) -> None:
    """Stations of a world with radars of these ids."""

    async def body() -> None:
        world, of = RadarGroup(), scene_of_several(*ids)
        stations: dict[str, Station] = {}
        for each in ids:
            engine = FakeEngine(of.for_radar(each))
            engine.scene_request = SceneRequest(of, radar=each)
            stations[each] = Station(each, engine, factory(), settings=Settings(pace=Pace("pause")), group=world, **options)
        for station in stations.values():
            await station.start()
        try:
            await test(stations)
        finally:
            for station in stations.values():
                for client in list(station.hub.clients):  # the station waits for those that stay
                    station.leave(client)
                await station.stop()

    asyncio.run(asyncio.wait_for(body(), 60))


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.001)


def rpm(station: Station) -> float:
    return round(60.0 / station.epoch.info.scene.radar.rotation_period, 6)


def test_another_scene_for_one_radar_replaces_the_world() -> None:
    async def test(stations: dict[str, Station]) -> None:
        bow, pier = stations.values()
        await bow.change({"pace": {"state": "step", "steps": 3}})
        await until(lambda: bow.transmitter.sent == 3 and pier.transmitter.pacer.idle)
        epoch, known = await pier.swap(OTHER)
        await until(lambda: all(station.epoch.info.scene.name == "other" for station in stations.values()))
        await until(lambda: pier.hub.epoch == epoch)
        assert pier.epoch.info.scene == known.scene and pier.epoch.spoke_source is not bow.epoch.spoke_source
        assert (rpm(bow), rpm(pier)) == (36, 24)
        assert [station.transmitter.simulated for station in stations.values()] == [0.0, 0.0]
        assert [station.epoch.scene_request.radar for station in stations.values()] == list(IDS)

    play(test, *IDS)


@pytest.mark.parametrize(
    "order",
    [
        SceneRequest(scene_of_several("bow", "pier", "mast")),
        SceneRequest(scene_of_several("bow", "mast")),
        SceneRequest(scene()),
    ],
    ids=["one more", "another", "none of them"],
)
def test_a_scene_with_other_radars_is_refused_and_all_go_on(order: SceneRequest) -> None:
    async def test(stations: dict[str, Station]) -> None:
        before = {name: station.epoch.spoke_source for name, station in stations.items()}
        with pytest.raises(SceneError, match="radar"):
            await stations["bow"].swap(order)
        await stations["bow"].change({"pace": {"state": "step", "steps": AZIMUTHS}})
        await until(lambda: stations["bow"].transmitter.sent == AZIMUTHS)
        assert {name: station.epoch.spoke_source for name, station in stations.items()} == before

    play(test, *IDS)


def test_the_refusal_names_both_lists() -> None:
    async def test(stations: dict[str, Station]) -> None:
        with pytest.raises(SceneError) as refused:
            await stations["bow"].swap(SceneRequest(scene_of_several("bow", "pier", "mast")))
        assert refused.value.problems == (
            "radar: the scene has bow, pier, mast, but bow, pier runs here; give a scene with the same radars, or start the "
            "server with this one",
        )

    play(test, *IDS)


def test_a_single_radar_takes_the_only_one_of_a_scene_but_none_of_several() -> None:
    async def test(stations: dict[str, Station]) -> None:
        alone = stations["bow"]
        await alone.swap(SceneRequest(scene("plain")))
        await until(lambda: alone.epoch.info.scene.name == "plain")
        await alone.swap(SceneRequest(scene_of_several("mast", name="named")))
        await until(lambda: alone.epoch.info.scene.name == "named")
        with pytest.raises(SceneError, match="the scene has pier, bow, but bow runs here"):
            await alone.swap(OTHER)

    play(test, "bow")


def test_a_change_of_rpm_is_one_radars_and_the_world_goes_on() -> None:
    async def test(stations: dict[str, Station]) -> None:
        bow, pier = stations.values()
        before = pier.epoch.spoke_source
        await bow.change({"rpm": 48.0})
        await until(lambda: rpm(bow) == 48)
        assert rpm(pier) == 36 and pier.epoch.spoke_source is before
        await bow.change({"pace": {"state": "run"}})
        sent = [station.transmitter.simulated for station in stations.values()]
        await until(lambda: all(s.transmitter.simulated > t + 1.0 for s, t in zip(stations.values(), sent, strict=True)))
        assert abs(bow.transmitter.simulated - pier.transmitter.simulated) < 1.0

    play(test, *IDS)


def test_requests_of_several_radars_are_met_in_their_order() -> None:
    async def test(stations: dict[str, Station]) -> None:
        later = SceneRequest(scene_of_several(*IDS, name="later"))
        await asyncio.gather(stations["bow"].swap(OTHER), stations["pier"].swap(later))
        await until(lambda: all(station.epoch.info.scene.name == "later" for station in stations.values()))

    play(test, *IDS)


def test_spoke_0_of_all_waits_for_clients_of_each() -> None:
    async def test(stations: dict[str, Station]) -> None:
        bow, pier = stations.values()
        await bow.change({"pace": {"state": "run"}})
        bow.join(ClientQueue(View("u8")))
        assert [status.state(station) for station in stations.values()] == ["waiting", "waiting"]
        assert bow.transmitter.sent == 0
        pier.join(ClientQueue(View("u8")))
        await until(lambda: bow.transmitter.sent > 0 and pier.transmitter.sent > 0)

    play(test, *IDS, wait_for=1)


def test_a_command_to_one_radar_acts_on_all() -> None:
    of = load_scene(
        {"radar": [RADAR | {"id": each, "rpm": rpm} for each, rpm in zip(IDS, (24, 36), strict=True)],
         "own_ship": {"steerable": {}}}
    )  # fmt: skip

    async def test(stations: dict[str, Station]) -> None:
        await stations["bow"].swap(SceneRequest(of))
        await until(lambda: all(station.epoch.info.scene.steerable.limits for station in stations.values()))
        await stations["bow"].change({"pace": {"state": "step", "steps": 7}})
        await until(lambda: stations["bow"].transmitter.sent == 7 and stations["pier"].transmitter.pacer.idle)
        command = await stations["bow"].commands.command(None, lambda time: {"speed_kn": 1.0})
        (other,) = stations["pier"].epoch.commands
        assert (other.spoke, other.time) == (10, pytest.approx(10 * 5 / 3 / AZIMUTHS))  # the next spoke of either
        assert (command.spoke, command.time) == (7, other.time)

    play(test, *IDS)
