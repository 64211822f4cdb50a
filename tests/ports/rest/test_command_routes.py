"""REST of commands: answers with the first spoke that shows them, refusals with a reason, and a radar that goes on."""

import asyncio
from typing import Any

import pytest

from radar_service.ports.rest.command_routes import CommandChange, CommandState
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.world.commands import KEYS, Command
from tests.ports.playing import playing
from tests.ports.playing import station as paused
from tests.service.fake import AZIMUTHS, steerable_scene

OWN, BUOY, ROCK = "/api/radars/0/own-ship", "/api/radars/0/bodies/buoy", "/api/radars/0/bodies/the%20rock%2F1"


def station() -> Station:
    return paused(steerable_scene(), allow_truth=True)


async def test_a_command_acts_from_the_first_spoke_that_is_not_sent() -> None:
    async with playing(station()) as server:
        before = (await server.http.get(BUOY)).json()
        assert before == {
            "body": "buoy",
            "max_speed_kn": pytest.approx(20),
            "max_turn_rate_deg_s": pytest.approx(5),
            "latest": None,
        }
        feed = await server.feed()
        await server.step(7)
        await feed.spokes(7)
        answer = await server.http.patch(BUOY, json={"course_deg": 90, "speed_kn": 5})
        expected = {
            "body": "buoy",
            "spoke": 7,
            "time": pytest.approx(7 * 2.5 / AZIMUTHS),
            "course_deg": 90.0,
            "speed_kn": 5.0,
            "by": "rest",
        }
        made = answer.json()
        assert answer.status_code == 200 and {key: value for key, value in made.items() if value is not None} == expected
        assert (await server.http.get(BUOY)).json()["latest"] == made
        own = (await server.http.patch(OWN, json={"turn_rate_deg_s": -2})).json()
        assert (own["body"], own["spoke"], own["turn_rate_deg_s"]) == (None, 7, -2.0)
        assert (await server.http.get(OWN)).json()["latest"] == own
        await server.step(5)
        assert [m["first"] for m in await feed.spokes(5)][0] == 7  # none is lost, none comes twice


REFUSED: list[tuple[str, dict[str, Any], int, str]] = [
    (OWN.replace("0", "7"), {"speed_kn": 1}, 404, 'there is no "7"'),
    ("/api/radars/0/bodies/boy", {"speed_kn": 1}, 404, 'the scene has no "boy"; bodies that may be steered: "buoy"'),
    (ROCK, {"speed_kn": 1}, 409, 'body "the rock/1" is not steerable in this scene; add steerable'),
    (BUOY, {"speed_kn": 20.5}, 422, "speed_kn: 20.5 is not allowed; 0 to 20"),
    (BUOY, {"turn_rate_deg_s": -5.5}, 422, "turn_rate_deg_s: -5.5 is not allowed; -5 to 5"),
    (BUOY, {"course_deg": 400}, 422, "course_deg: 400"), (BUOY, {"position_m": [1]}, 422, "position_m"),
    (BUOY, {}, 422, "a command without a value: give at least one of"), (BUOY, {"rudder": 3}, 422, "rudder"),
    (OWN, {"present": False}, 422, "own ship is always present"),
]  # fmt: skip


async def test_refusals_say_why_and_change_nothing() -> None:
    async with playing(station()) as server:
        for path, body, status, words in REFUSED:
            answer = await server.http.patch(path, json=body)
            assert answer.status_code == status and words in answer.json()["detail"][0], answer.text
            if status in (404, 409):
                assert (await server.http.get(path)).status_code == status
            else:
                assert (await server.http.get(path)).json()["latest"] is None
        health = (await server.http.get("/api/health")).json()
        assert health["radars"][0]["fault"] is None


async def test_commands_act_in_standby_and_a_swap_forgets_them() -> None:
    async with playing(only := station()) as server:
        await server.http.patch("/api/radars/0/controls", json={"transmit": False, "pace": {"state": "step", "steps": 9}})
        while not only.transmitter.pacer.idle:
            await asyncio.sleep(0.001)
        assert (await server.http.patch(BUOY, json={"speed_kn": 3})).json()["spoke"] == 9
        await only.swap(SceneRequest(steerable_scene("next")))
        while only.epoch.info.scene.name != "next":
            await asyncio.sleep(0.001)
        assert (await server.http.get(BUOY)).json()["latest"] is None
        again = (await server.http.patch(BUOY, json={"speed_kn": 4})).json()
        assert (again["spoke"], again["time"]) == (0, 0.0)


def test_their_keys_are_those_of_a_command() -> None:
    assert set(CommandChange.model_fields) == set(KEYS)
    assert set(CommandState.model_fields) == {"body", "spoke", "time", "by", *KEYS}


def test_a_command_becomes_its_state() -> None:
    command = Command(7, 0.5, None, course_deg=3.0, position_m=(1.0, 2.0))
    assert CommandState.model_validate(command.as_dict()).model_dump(exclude_none=True) == {
        "spoke": 7, "time": 0.5, "course_deg": 3.0, "position_m": (1.0, 2.0)
    }  # fmt: skip
