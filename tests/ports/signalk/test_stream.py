"""The stream of the Signal K API: hello, present values at once, changes as they happen, controls in, and rubbish."""

import asyncio
import json
import math
from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.service.access import Access
from radar_service.service.settings import Settings
from tests.ports.asgi import Closed
from tests.ports.playing import FLAT_OUT
from tests.ports.signalk.playing import BASE, heard, playing, until, values_of
from tests.service.fake import RADAR, scene

PATH = "/signalk/v1/stream"
GAIN = "radars.sim-0.controls.gain"
TOKEN = "command-" * 3


async def test_hello_comes_first_and_nothing_without_subscription() -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?subscribe=none")
        hello = await heard(socket)
        assert {"name", "version", "timestamp", "self", "roles"} <= hello.keys() and hello["self"] == "vessels.self"
        await server.http.put(f"{BASE}/sim-0/controls/rain", json=3)
        await socket.say(text=json.dumps({"subscribe": [{"path": "radars.*.controls.gain", "policy": "instant"}]}))
        delta = await heard(socket)
        assert values_of(delta) == {GAIN: {"value": 45.0, "auto": True}} and delta["context"] == "vessels.self"
        (update,) = delta["updates"]
        assert update["$source"] and update["timestamp"].endswith("Z")
        assert update["meta"] == [
            {"path": GAIN, "value": (await server.http.get(f"{BASE}/sim-0/capabilities")).json()["controls"]["gain"]}
        ]


async def test_all_present_values_come_at_once_and_then_what_changes() -> None:
    async with playing(scene(), scene("second")) as server:
        socket = await server.open(PATH)  # own ship, as by default
        await heard(socket)
        first = values_of(await heard(socket))
        assert {path for path in first if path.startswith("radars")} == {
            f"radars.sim-{k}.controls.{name}"
            for k in (0, 1)
            for name in (await server.http.get(f"{BASE}/sim-{k}/controls")).json()
        }
        assert first["radars.sim-0.controls.power"] == {"value": 2}
        await server.http.patch("/api/radars/0/controls", json={"gain": 61})  # the page's way
        while GAIN not in (values := values_of(delta := await heard(socket))):  # own ship may come between
            assert not any(path.startswith("radars.") for path in values)
        assert values[GAIN] == {"value": 61.0, "auto": False} and "meta" not in delta["updates"][0]


async def test_a_client_without_cached_values_gets_changes_alone() -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?sendCachedValues=false")
        await heard(socket)
        await server.http.put(f"{BASE}/sim-0/controls/rain", json=3)
        seen: dict[str, Any] = {}
        while "radars.sim-0.controls.rain" not in seen:
            seen |= values_of(await heard(socket))
        assert [path for path in seen if path.startswith("radars.")] == ["radars.sim-0.controls.rain"]


async def test_own_ship_is_told_as_it_is_reported() -> None:
    """Heading 030 degrees; a scene without origin has no position, and none is told."""
    async with playing(settings=Settings()) as server:
        socket = await server.open(PATH)
        await heard(socket)
        while "navigation.headingTrue" not in (values := values_of(await heard(socket))):
            pass
        assert values["navigation.headingTrue"] == pytest.approx(math.pi / 6, rel=1e-12)
        assert values["navigation.speedOverGround"] == 0.0 and "navigation.position" not in values


async def test_own_ship_is_told_again_though_it_lies_still(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plotters drop what has grown old."""
    monkeypatch.setattr("radar_service.ports.signalk.signalk_port.REPEAT", 2)
    async with playing() as server:
        socket = await server.open(PATH)
        await heard(socket)
        for _ in range(3):
            assert await until(socket, "navigation.headingTrue") == pytest.approx(math.pi / 6, rel=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"path": GAIN, "value": 50, "auto": False}, {"path": GAIN, "value": {"value": "50"}},
        {"requestId": "r1", "put": {"path": GAIN, "value": {"value": 50}}},
    ],
)  # fmt: skip
async def test_a_client_changes_controls(change: dict[str, Any]) -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?subscribe=none")
        await heard(socket)
        await socket.say(text=json.dumps({"subscribe": [{"path": GAIN}]}))
        await heard(socket)
        await socket.say(text=json.dumps(change))
        answers = [await heard(socket) for _ in range(2 if "requestId" in change else 1)]
        deltas = [values_of(answer) for answer in answers if "updates" in answer]
        assert deltas == [{GAIN: {"value": 50.0, "auto": False}}]
        reports = [answer for answer in answers if "updates" not in answer]
        assert reports == (
            [{"requestId": "r1", "state": "COMPLETED", "statusCode": 200, "message": "OK"}] * ("put" in change)
        )


async def test_what_is_unsubscribed_comes_no_more() -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?subscribe=none")
        await heard(socket)
        rows = [{"path": GAIN}, {"path": "radars.sim-0.controls.rain"}]
        await socket.say(text=json.dumps({"context": "vessels.self", "subscribe": rows}))
        await heard(socket)
        for key, row in zip(("desubscribe", "unsubscribe"), rows, strict=True):
            await socket.say(text=json.dumps({"context": "*", key: [row]}))
        await socket.say(text=json.dumps({"subscribe": [{"path": "radars.sim-0.controls.sea"}]}))
        await heard(socket)
        await server.http.put(f"{BASE}/sim-0/controls", json={"gain": 5, "rain": 5, "sea": 5})
        assert values_of(await heard(socket)).keys() == {"radars.sim-0.controls.sea"}


RUBBISH = [
    ("rubbish", 400, "JSON"), ("[1]", 400, "object"), ('{"subscribe": 5}', 400, "subscribe"),
    ('{"subscribe": [5]}', 400, "row"), ('{"context": 5, "subscribe": [{"path": "*"}]}', 400, "row"),
    ('{"path": "radars.sim-9.controls.gain", "value": 5}', 404, "sim-9"), ('{"path": 5}', 404, "path"),
    (f'{{"path": "{GAIN}", "value": 500}}', 400, "gain: 500"), (f'{{"path": "{GAIN}"}}', 400, "neither"),
    ('{"path": "radars.sim-0.controls.volume", "value": 5}', 404, "volume"),
    ('{"path": "radars.sim-0.targets.5", "value": 5}', 404, "path"), ('{"a": 1, "a": 2}', 400, "a"),
    ("[" * 5000, 400, "JSON"), ("{}", 400, "nothing"), ('{"put": [1]}', 400, "nothing"),
]  # fmt: skip


async def test_rubbish_is_answered_and_the_stream_goes_on() -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?subscribe=none")
        await heard(socket)
        for message, status, word in RUBBISH:
            await socket.say(text=message)
            answer = await heard(socket)
            assert (answer["state"], answer["statusCode"]) == ("FAILED", status) and word in answer["message"], answer
        await socket.say(bytes=b"\xff\xfe")
        assert (await heard(socket))["statusCode"] == 400
        await socket.say(text=json.dumps({"subscribe": [{"path": GAIN}]}))
        assert GAIN in values_of(await heard(socket))


async def test_a_change_needs_the_token() -> None:
    async with playing(access=Access(TOKEN)) as server:
        for bearer, status in (({}, 403), ({"authorization": f"Bearer {TOKEN}"}, 200)):
            socket = await server.open(f"{PATH}?subscribe=none", **bearer)
            await heard(socket)
            await socket.say(text=json.dumps({"requestId": "1", "put": {"path": GAIN, "value": 7}}))
            assert (await heard(socket))["statusCode"] == status
        assert server.stations[0].controls()["gain"] == 7.0


async def test_a_wrong_query_is_refused() -> None:
    async with playing() as server:
        for query in ("subscribe=some", "sendCachedValues=maybe"):
            with pytest.raises(Closed):
                await server.open(f"{PATH}?{query}")


async def test_a_client_that_does_not_read_costs_nothing_and_reads_the_newest() -> None:
    async with playing() as server:
        socket = await server.open(f"{PATH}?subscribe=none")
        await heard(socket)
        await socket.say(text=json.dumps({"subscribe": [{"path": GAIN}]}))
        while not socket.holds_message:
            await asyncio.sleep(0)
        for gain in range(40):
            await server.http.patch("/api/radars/0/controls", json={"gain": gain})
        seen = [await until(socket, GAIN)]
        while seen[-1]["value"] != 39.0:
            seen.append(await until(socket, GAIN))
        assert len(seen) < 10


async def test_ships_with_ais_are_told_to_those_who_ask_for_them() -> None:
    """Own ship is there without; a scene with an origin and a body with an mmsi, which lies at anchor."""
    body = {"name": "ferry", "shape": "point", "rcs_dbsm": 20, "position_m": [0, 120, 0], "mmsi": 211000001}
    of = load_scene({"radar": RADAR, "origin": {"latitude_deg": 54.0, "longitude_deg": 8.0}, "body": [body]})
    context = "vessels.urn:mrn:imo:mmsi:211000001"
    async with playing(of, settings=FLAT_OUT) as server:
        alone, around = await server.open(PATH), await server.open(f"{PATH}?subscribe=all")
        await heard(alone)
        await heard(around)
        seen: dict[str, Any] = {}
        while not {"", "navigation.position"} <= seen.keys():
            delta = await heard(around)
            seen |= values_of(delta) if delta["context"] == context else {}
        assert seen[""] == {"name": "ferry".upper(), "mmsi": "211000001"}
        assert seen["navigation.position"]["latitude"] == pytest.approx(
            54.0 + 120 / 111_285, abs=2e-6
        )  # WGS 84 at 54 degrees
        assert seen["navigation.position"]["longitude"] == pytest.approx(8.0, abs=1e-9)
        while alone.holds_message:
            assert (await heard(alone))["context"] == "vessels.self"
