"""What changes in the state of a radar is found, once, and all of it at first."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

import pytest

from radar_service.ports.app import create_app
from radar_service.service.radio.state_changes import StateWatch
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, scene, steerable_scene


@contextlib.asynccontextmanager
async def playing() -> AsyncIterator[tuple[Server, Station]]:
    only = Station("0", FakeEngine(steerable_scene()), factory(), settings=Settings(pace=Pace("pause")))
    async with running(create_app([only])) as server:
        yield server, only


async def test_all_at_first_and_then_what_has_changed() -> None:
    async with playing() as (server, only):
        watch = StateWatch(only)
        first = watch.changes()
        assert [change.kind for change in first] == ["status", "scene", "controls", "errors"]
        assert first[2].values == only.controls() and first[3].values == {}
        assert not watch.changes()
        await only.change({"gain": 12.0})
        assert [(change.kind, change.values) for change in watch.changes()] == [
            ("controls", {"gain": 12.0, "gain_auto": False})
        ]
        await server.http.patch("/api/radars/0/errors", json={"gyro": {"bias_deg": 2}})
        (errors,) = watch.changes()
        assert errors.kind == "errors" and errors.values["gyro"]["bias_deg"] == 2
        await only.commands.command("buoy", lambda time: {"speed_kn": 3.0})
        await only.commands.command(None, lambda time: {"course_deg": 45.0})
        await only.commands.command("buoy", lambda time: {"speed_kn": 4.0})
        (commands,) = watch.changes()
        assert commands.kind == "commands" and commands.as_dict()["values"]["bodies"]["buoy"]["speed_kn"] == pytest.approx(
            4.0
        )
        assert commands.values["own_ship"]["course_deg"] == pytest.approx(45.0)
        assert not watch.changes()


async def test_another_scene_is_told_with_its_epoch_and_its_commands_count_anew() -> None:
    async with playing() as (server, only):
        watch = StateWatch(only)
        await only.commands.command("buoy", lambda time: {"speed_kn": 3.0})
        watch.changes()
        answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": "other"}})
        while only.hub.epoch != answer.json()["epoch"]:
            await asyncio.sleep(0.001)
        changes = {change.kind: change.values for change in watch.changes()}
        assert changes["scene"]["epoch"] == answer.json()["epoch"] and "commands" not in changes


async def test_commands_to_the_same_scene_begun_anew_are_told_however_many_there_were() -> None:
    """Between two looks the scene begins anew and gets as many commands as it had; a change of range tells none again."""
    async with playing() as (_, only):
        watch, order = StateWatch(only), only.epoch.scene_request
        assert order is not None
        await only.commands.command("buoy", lambda time: {"speed_kn": 3.0})
        assert [change.kind for change in watch.changes()][-1] == "commands"
        name, _ = await only.swap(order)
        while only.epoch.name != name:
            await asyncio.sleep(0.001)
        await only.commands.command("buoy", lambda time: {"speed_kn": 3.0})
        assert "commands" in {change.kind for change in watch.changes()}
        await only.change({"range_m": 100.0})
        while only.epoch.name == name:
            await asyncio.sleep(0.001)
        assert "commands" not in {change.kind for change in watch.changes()}


async def test_how_far_a_radar_is_behind_is_told_in_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    async with playing() as (_, only):
        reached = [0.512]
        monkeypatch.setattr("radar_service.service.radio.state_changes.state", lambda station: "behind")
        monkeypatch.setattr(type(only.transmitter.pacer), "reached", lambda pacer: reached[0])
        watch = StateWatch(only)
        assert watch.changes()[0].values == {"state": "behind", "fault": None, "factor_reached": 0.5}
        reached[0] = 0.49
        assert not watch.changes()
        reached[0] = 0.44
        assert watch.changes()[0].values["factor_reached"] == 0.45


async def test_a_radar_that_fails_is_told_with_its_fault() -> None:
    engine = FakeEngine(scene(), dies_at=3)
    only = Station("0", engine, factory(), settings=Settings(pace=Pace("run", float("inf"))), restarts=0)
    async with running(create_app([only])) as _:
        watch, told = StateWatch(only), dict[str, Any]()
        while told.get("state") != "failed":
            await asyncio.sleep(0.001)
            for change in watch.changes():
                told |= change.values if change.kind == "status" else {}
        assert told["fault"] == only.transmitter.state.fault
