"""Websockets of poses and of changes: an answer for each pose, in order; of changes all of the state first."""

import json
import math
from typing import Any

import msgpack
import pytest

from radar_service.ports import port_host
from radar_service.ports.http import conversation
from radar_service.ports.rest import websockets
from radar_service.service.access import Access
from radar_service.service.fanout.client_queue import TOO_SLOW
from radar_service.service.radio.station import Station
from tests.ports.asgi import Closed, Socket
from tests.ports.playing import playing, station
from tests.ports.rest.test_command_routes import BUOY
from tests.service.fake import AZIMUTHS, steerable_scene

PATH = "/api/radars/0/poses"


async def answer(socket: Socket) -> dict[str, Any]:
    return dict(json.loads(await socket.text()))


async def test_poses_in_json_and_msgpack_are_answered_in_order() -> None:
    async with playing(steerable(allow_truth=True)) as server:
        socket = await server.open(PATH)
        poses: list[dict[str, Any]] = [
            {"body": "buoy", "position_m": [10, 20], "course_deg": 45, "speed_kn": 6, "turn_rate_deg_s": 1},
            {"position_m": [1.5, 2], "heading_deg": 30},
            {"body": "buoy", "position_m": [11, 21], "course_deg": 46, "speed_kn": 6, "time": 0.5},
        ]
        for n, pose in enumerate(poses):
            await socket.say(**({"text": json.dumps(pose)} if n % 2 else {"bytes": msgpack.packb(pose)}))
        made = [await answer(socket) for _ in poses]
        assert [(each["type"], each["body"], each["spoke"]) for each in made] == [
            ("pose", "buoy", 0), ("pose", None, 0), ("pose", "buoy", 0)
        ]  # fmt: skip
        assert made[1]["course_deg"] == made[1]["heading_deg"] == 30.0 and made[1]["at_once"] is True
        back = 6 * 1852 / 3600 * 0.5
        at = math.radians(46)
        expected = [11 - back * math.sin(at), 21 - back * math.cos(at)]  # spoke 0 is half a second before the pose
        assert made[2]["position_m"] == pytest.approx(expected)
        assert (await server.http.get(BUOY)).json()["latest"]["course_deg"] == 46.0


TWICE = 'the key "speed_kn" occurs twice'
RUBBISH: list[tuple[str | bytes, str]] = [  # and what its refusal says
    ("{", ""), ("[1]", ""), ('{"speed_kn": NaN}', "speed_kn"), ('{"body": "boy", "speed_kn": 1}', "boy"), (b"\xc1", ""),
    (b"", ""), ('{"speed_kn": 99}', "speed_kn: 99"), ("[" * 2000, ""), ('{"speed_kn": 1, "time": 99}', "time"),
    ('{"speed_kn": 1, "speed_kn": 2}', TWICE), (b"\x82\xa8speed_kn\x01\xa8speed_kn\x02", TWICE),
    ('{"speed_kn": true}', "speed_kn"), ('{"course_deg": "90"}', "course_deg"), ('{"present": 1, "body": "buoy"}', "present"),
    ('{"heading_deg": 1, "position_m": [true, 0]}', "position_m"), ('{"heading_deg": 1, "time": true}', "time"),
]  # fmt: skip


async def test_rubbish_is_refused_and_the_conversation_goes_on() -> None:
    async with playing(steerable(allow_truth=True)) as server:
        socket = await server.open(PATH)
        for message, words in RUBBISH:
            await socket.say(**({"text": message} if isinstance(message, str) else {"bytes": message}))
            refused = await answer(socket)
            assert refused["type"] == "refused" and len(refused["detail"][0]) > 20 and words in refused["detail"][0], message
        await socket.say(text='{"speed_kn": 1}')
        assert (await answer(socket))["type"] == "pose"


async def test_too_many_poses_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websockets, "POSES_PER_SECOND", 1e-3)
    monkeypatch.setattr(websockets, "POSES_AT_ONCE", 2.0)
    async with playing(steerable(allow_truth=True)) as server:
        socket = await server.open(PATH)
        for _ in range(3):
            await socket.say(text='{"speed_kn": 1}')
        answers = [await answer(socket) for _ in range(3)]
        assert [each["type"] for each in answers] == ["pose", "pose", "refused"] and "send fewer" in answers[2]["detail"][0]


async def test_the_token_to_command_is_needed() -> None:
    read, command = "r" * 16, "c" * 16
    async with playing(steerable(allow_truth=True), access=Access(command=command, read=read)) as server:
        for token in ("", read):
            with pytest.raises(Closed):
                await server.open(PATH, authorization=f"Bearer {token}")
        socket = await server.open(PATH, authorization=f"Bearer {command}")
        await socket.say(text='{"speed_kn": 1}')
        assert (await answer(socket))["type"] == "pose"


async def test_a_client_that_leaves_takes_its_poses_along() -> None:
    async with playing(steerable(allow_truth=True)) as server:
        socket = await server.open(PATH)
        await socket.say(text='{"speed_kn": 1}')
        await socket.leave()
        feed = await server.feed()
        await server.step(AZIMUTHS)
        await feed.spokes(AZIMUTHS)


COMMAND, READ = "command-" * 3, "reading-" * 3


def steerable(**options: Any) -> Station:
    return station(steerable_scene(), **options)


async def next_of(socket: Socket, kind: str) -> dict[str, Any]:
    """The next change of that kind."""
    while (change := json.loads(await socket.text()))["kind"] != kind:
        pass
    return dict(change)


async def test_a_client_gets_the_whole_state_and_then_what_changes() -> None:
    async with playing(steerable()) as server:
        early = await server.open("/api/changes")
        assert (await next_of(early, "controls"))["values"] == server.stations[0].controls()
        await server.http.patch("/api/radars/0/controls", json={"rain": 12})
        while len((change := await next_of(early, "controls"))["values"]) > 1:  # what the service found at its first look
            pass
        assert change == {"radar": "0", "kind": "controls", "values": {"rain": 12.0}, "time": 0.0}
        late = await server.open("/api/changes")
        state = {kind: (await next_of(late, kind))["values"] for kind in ("status", "scene", "controls")}
        assert state["controls"] == server.stations[0].controls() and state["controls"]["rain"] == 12.0
        assert state["status"] == {"state": "paused", "fault": None, "factor_reached": None}
        assert state["scene"] == {"epoch": server.stations[0].hub.epoch, "name": "steerable", "fidelity": "balanced"}
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "run"}})
        assert (await next_of(late, "status"))["values"]["state"] == "running"


async def test_a_new_client_gets_the_last_command_to_each_body() -> None:
    async with playing(steerable(allow_truth=True)) as server:
        for speed in (3, 4):
            await server.http.patch("/api/radars/0/bodies/buoy", json={"speed_kn": speed})
        await server.http.patch("/api/radars/0/own-ship", json={"course_deg": 70})
        values = (await next_of(await server.open("/api/changes"), "commands"))["values"]
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
            while (await next_of(hearing, "controls"))["values"].get("rain") != rain:
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
