"""The websocket of poses: an answer for each, in order; rubbish is refused and the conversation goes on."""

import json
import math
from typing import Any

import msgpack
import pytest

from radar_service.ports.rest import websockets
from radar_service.service.access import Access
from tests.ports.asgi import Closed, Socket
from tests.ports.playing import playing
from tests.ports.rest.test_command_routes import BUOY, station
from tests.service.fake import AZIMUTHS

PATH = "/api/radars/0/poses"


async def answer(socket: Socket) -> dict[str, Any]:
    return dict(json.loads(await socket.text()))


async def test_poses_in_json_and_msgpack_are_answered_in_order() -> None:
    async with playing(station()) as server:
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
    async with playing(station()) as server:
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
    async with playing(station()) as server:
        socket = await server.open(PATH)
        for _ in range(3):
            await socket.say(text='{"speed_kn": 1}')
        answers = [await answer(socket) for _ in range(3)]
        assert [each["type"] for each in answers] == ["pose", "pose", "refused"] and "send fewer" in answers[2]["detail"][0]


async def test_the_token_to_command_is_needed() -> None:
    read, command = "r" * 16, "c" * 16
    async with playing(station(), access=Access(command=command, read=read)) as server:
        for token in ("", read):
            with pytest.raises(Closed):
                await server.open(PATH, authorization=f"Bearer {token}")
        socket = await server.open(PATH, authorization=f"Bearer {command}")
        await socket.say(text='{"speed_kn": 1}')
        assert (await answer(socket))["type"] == "pose"


async def test_a_client_that_leaves_takes_its_poses_along() -> None:
    async with playing(station()) as server:
        socket = await server.open(PATH)
        await socket.say(text='{"speed_kn": 1}')
        await socket.leave()
        feed = await server.feed()
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": AZIMUTHS}})
        await feed.spokes(AZIMUTHS)
