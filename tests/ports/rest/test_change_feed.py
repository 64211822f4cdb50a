"""The websocket of changes: all of the state first, then what changes, to those who may know it."""

import json
from typing import Any

import pytest

from radar_service.ports import port_host
from radar_service.ports.http import conversation
from radar_service.ports.rest import websockets
from radar_service.service.access import Access
from radar_service.service.fanout.client_queue import TOO_SLOW
from radar_service.service.radio.station import Station
from tests.ports.asgi import Closed, Socket
from tests.ports.playing import playing, station
from tests.service.fake import steerable_scene

COMMAND, READ = "command-" * 3, "reading-" * 3


def steerable(**options: Any) -> Station:
    return station(steerable_scene(), **options)


async def until(socket: Socket, kind: str) -> dict[str, Any]:
    """The next change of that kind."""
    while (change := json.loads(await socket.text()))["kind"] != kind:
        pass
    return dict(change)


async def test_a_client_gets_the_whole_state_and_then_what_changes() -> None:
    async with playing(steerable()) as server:
        early = await server.open("/api/changes")
        assert (await until(early, "controls"))["values"] == server.stations[0].controls()
        await server.http.patch("/api/radars/0/controls", json={"rain": 12})
        while len((change := await until(early, "controls"))["values"]) > 1:  # what the service found at its first look
            pass
        assert change == {"radar": "0", "kind": "controls", "values": {"rain": 12.0}, "time": 0.0}
        late = await server.open("/api/changes")
        state = {kind: (await until(late, kind))["values"] for kind in ("status", "scene", "controls")}
        assert state["controls"] == server.stations[0].controls() and state["controls"]["rain"] == 12.0
        assert state["status"] == {"state": "paused", "fault": None, "factor_reached": None}
        assert state["scene"] == {"epoch": server.stations[0].hub.epoch, "name": "steerable", "fidelity": "balanced"}
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "run"}})
        assert (await until(late, "status"))["values"]["state"] == "running"


async def test_a_new_client_gets_the_last_command_to_each_body() -> None:
    async with playing(steerable(allow_truth=True)) as server:
        for speed in (3, 4):
            await server.http.patch("/api/radars/0/bodies/buoy", json={"speed_kn": speed})
        await server.http.patch("/api/radars/0/own-ship", json={"course_deg": 70})
        values = (await until(await server.open("/api/changes"), "commands"))["values"]
        assert values["bodies"]["buoy"]["speed_kn"] == pytest.approx(4.0)
        assert values["own_ship"]["course_deg"] == pytest.approx(70.0)


@pytest.mark.parametrize("truth", [False, True])
async def test_commands_and_errors_are_told_to_those_who_may_know_the_truth(truth: bool) -> None:
    async with playing(steerable(allow_truth=truth), access=Access(COMMAND, READ)) as server:
        knowing = await server.open("/api/changes", authorization=f"Bearer {COMMAND}")
        reading = await server.open("/api/changes", authorization=f"Bearer {READ}")
        bearer = {"authorization": f"Bearer {COMMAND}"}
        await server.http.patch("/api/radars/0/bodies/buoy", json={"speed_kn": 5}, headers=bearer)
        await server.http.patch("/api/radars/0/errors", json={"gyro": {"bias_deg": 3}}, headers=bearer)
        seen = []
        while not {"commands", "errors"} <= {change["kind"] for change in seen if change["values"]}:
            seen.append(json.loads(await knowing.text()))
        secrets = {change["kind"]: change["values"] for change in seen}
        assert secrets["commands"]["bodies"]["buoy"]["speed_kn"] == pytest.approx(5.0)
        assert secrets["errors"]["gyro"]["bias_deg"] == 3
        await server.http.patch("/api/radars/0/controls", json={"rain": 12}, headers=bearer)
        told = []
        while not told or told[-1]["values"] != {"rain": 12.0}:
            told.append(json.loads(await reading.text()))
        assert ({"commands", "errors"} & {change["kind"] for change in told} == {"commands", "errors"}) is truth
        assert truth or not {"commands", "errors"} & {change["kind"] for change in told}


async def test_a_stranger_is_told_nothing() -> None:
    async with playing(access=Access(COMMAND, READ)) as server:
        with pytest.raises(Closed):
            await server.open("/api/changes")


async def test_a_client_that_does_not_read_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websockets, "MAX_WAITING", 5)
    monkeypatch.setattr(port_host, "LOOK", 0.01)
    monkeypatch.setattr(conversation, "GRACE", 60.0)  # s: on a busy machine the changes after the sixth take longer than 1 s
    async with playing() as server:
        deaf = await server.open("/api/changes")
        hearing = await server.open("/api/changes")
        for rain in range(1, 12):
            await server.http.patch("/api/radars/0/controls", json={"rain": rain})
            while (await until(hearing, "controls"))["values"].get("rain") != rain:
                pass
        with pytest.raises(Closed) as closed:
            while True:
                last = json.loads(await deaf.text())
        assert closed.value.code == TOO_SLOW and last == {"type": "bye", "reason": websockets.BEHIND}


async def test_the_state_of_many_radars_is_no_reason_to_end_a_client(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websockets, "MAX_WAITING", 3)
    monkeypatch.setattr(websockets.ChangeFeed, "take", lambda feed, change: None)  # nothing but the state
    async with playing(*(station(steerable_scene(), str(k)) for k in range(4))) as server:
        client = await server.open("/api/changes")
        got = [json.loads(await client.text()) for _ in range(4 * 3)]
        assert {(change["radar"], change["kind"]) for change in got} >= {
            (str(k), kind) for k in range(4) for kind in ("status", "scene", "controls")
        }
