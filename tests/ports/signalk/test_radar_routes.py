"""The HTTP routes of the Signal K Radar API, and its spokes: answers and statuses as the specification has them."""

import asyncio
from typing import Any

import pytest

from radar_service.service.access import Access
from tests.ports.asgi import Closed
from tests.ports.playing import FLAT_OUT
from tests.ports.signalk.playing import BASE, playing
from tests.ports.signalk.protobuf import spokes
from tests.service.fake import AZIMUTHS, scene

TOKEN, READING = "command-" * 3, "reading-" * 3
OK = {"state": "COMPLETED", "statusCode": 200, "message": "OK"}


def assert_failed(answer: Any, status: int, *words: str) -> None:
    body = answer.json()
    assert answer.status_code == status and (body["state"], body["statusCode"]) == ("FAILED", status), body
    assert all(word in body["message"] for word in words), body


async def test_a_client_finds_the_radars() -> None:
    async with playing(scene(), scene("second")) as server:
        found = (await server.http.get("/signalk")).json()
        assert found["endpoints"] == {
            "v1": {
                "version": "1.7.0", "signalk-http": "http://radar/signalk/v1/api/", "signalk-ws": "ws://radar/signalk/v1/stream",
            },
            "v2": {"version": "v2", "signalk-http": f"http://radar{BASE}", "signalk-ws": "ws://radar/signalk/v1/stream"},
        }  # fmt: skip
        assert (await server.http.get("/signalk/v1/api/self")).json() == "vessels.self"
        assert found["server"]["id"] and (await server.http.head(BASE)).status_code == 200
        listing = (await server.http.get(BASE)).json()
        assert listing["version"] == "3.4.0" and list(listing["radars"]) == ["sim-0", "sim-1"]
        one = (await server.http.get(f"{BASE}/sim-1")).json()
        assert one == listing["radars"]["sim-1"] and one.keys() == {"name", "brand", "model", "radarIpAddress", "replay"}
        assert isinstance(one["radarIpAddress"], str) and one["replay"] is False


async def test_capabilities_have_all_that_clients_read() -> None:
    async with playing() as server:
        known = (await server.http.get(f"{BASE}/sim-0/capabilities")).json()
        assert (known["spokesPerRevolution"], known["maxSpokeLength"], known["supportedRanges"]) == (AZIMUTHS, 20, [200])
        legend = known["legend"]
        assert len(legend["pixels"]) == legend["pixelColors"] == known["pixelValues"] == legend["historyStart"] == 252
        assert legend["pixels"][0] == {"type": "normal", "color": "#00000000"}
        assert all(len(pixel["color"]) == 9 and pixel["type"] == "normal" for pixel in legend["pixels"])
        assert 0 < legend["lowReturn"] < legend["mediumReturn"] < legend["strongReturn"] < 251
        assert legend["dopplerApproaching"] is None is legend["dopplerReceding"]
        values = (await server.http.get(f"{BASE}/sim-0/controls")).json()
        assert values.keys() == known["controls"].keys() and values["power"] == {"value": 2}
        for name, definition in known["controls"].items():
            assert ("auto" in values[name]) == definition.get("hasAuto", False), name


async def test_controls_are_read_and_changed_alone_and_together() -> None:
    async with playing() as server:
        path = f"{BASE}/sim-0/controls"
        assert (await server.http.get(f"{path}/Gain")).json() == {"value": 45.0, "auto": True}
        assert (await server.http.put(f"{path}/gain", json={"value": "60"})).json() == OK
        assert (await server.http.get(f"{path}/gain")).json() == {"value": 60.0, "auto": False}
        assert (await server.http.put(path, json={"rain": {"value": 7}, "gain": 50, "power": "standby"})).json() == OK
        assert server.stations[0].controls()["rain"] == 7.0 and not server.stations[0].controls()["transmit"]
        assert_failed(await server.http.put(path, json={"rain": 9, "volume": 1}), 404, "volume")
        assert server.stations[0].controls()["rain"] == 7.0  # nothing is applied where one is not known
        answer = await server.http.put(path, json={"rain": 9, "gain": 500, "sea": "x"})
        assert_failed(answer, 400, "gain: 500", "sea: 'x'")
        assert server.stations[0].controls()["rain"] == 9.0


REFUSED = [
    ("GET", "sim-9", b"", 404, "sim-0"), ("GET", "sim-9/capabilities", b"", 404, "sim-9"),
    ("GET", "sim-9/controls", b"", 404, "sim-9"), ("GET", "sim-0/controls/volume", b"", 404, "power"),
    ("PUT", "sim-0/controls/gain", b"{", 400, "JSON"), ("PUT", "sim-0/controls/gain", b"", 400, "JSON"),
    ("PUT", "sim-0/controls/gain", b'{"value": 1, "value": 2}', 400, "value"),
    ("PUT", "sim-0/controls/gain", b"[[" * 20_000, 400, "JSON"), ("PUT", "sim-0/controls/rotationSpeed", b"3", 400, "read-only"),
    ("PUT", "sim-0/controls/range", b"201", 400, "range_m: 201"), ("PUT", "sim-0/controls", b"[1]", 400, "object"),
    ("GET", "sim-0/targets", b"", 501, "targets"), ("GET", "sim-9/targets", b"", 404, "sim-9"),
    ("POST", "sim-0/targets", b'{"bearing": 1, "distance": 9}', 501, "targets"),
    ("POST", "sim-0/targets/acquire", b"{}", 501, "targets"), ("DELETE", "sim-0/targets/5", b"", 501, "targets"),
]  # fmt: skip


async def test_refusals_have_one_shape() -> None:
    async with playing() as server:
        for method, path, body, status, word in REFUSED:
            assert_failed(await server.http.request(method, f"{BASE}/{path}", content=body), status, word)
        assert_failed(await server.http.get("/signalk/v1/api/vessels/"), 404, "/signalk/v1/stream")


async def test_changes_need_the_token() -> None:
    async with playing(access=Access(TOKEN, READING)) as server:
        path = f"{BASE}/sim-0/controls/gain"
        assert (await server.http.get(path)).status_code == 401
        reader, commander = ({"authorization": f"Bearer {token}"} for token in (READING, TOKEN))
        assert (await server.http.get(path, headers=reader)).status_code == 200
        assert (await server.http.put(path, json=3, headers=reader)).status_code == 401
        assert (await server.http.put(path, json=3, headers=commander)).json() == OK
        with pytest.raises(Closed):
            await server.open(f"{BASE}/sim-0/spokes")


async def test_what_the_server_refuses_has_the_shape_too() -> None:
    bearer = {"authorization": f"Bearer {TOKEN}"}
    async with playing(access=Access(TOKEN, hosts=frozenset(["radar"]))) as server:
        for method, headers, content, status in (
            ("PUT", {}, b"3", 401), ("PUT", {"origin": "http://elsewhere"}, b"3", 403), ("DELETE", bearer, b"", 405),
            ("GET", {"host": "elsewhere.example"}, b"", 421), ("PUT", bearer, b" " * 70_000, 413),
        ):  # fmt: skip
            path = f"{BASE}/sim-0/controls/gain"
            assert_failed(await server.http.request(method, path, headers=headers, content=content), status)
        other = await server.http.request("PUT", "/api/radars/0/scene", content=b"{}", headers={"host": "elsewhere.example"})
        assert other.json().keys() == {"detail"}  # elsewhere nothing is written anew


async def test_spokes_come_by_websocket() -> None:
    """All bearings of a revolution, in order; a message is of one revolution and of one range."""
    async with playing(settings=FLAT_OUT, wait_for=1) as server:
        socket = await server.open(f"{BASE}/sim-0/spokes")
        await socket.say(text="anything")
        await socket.say(bytes=b"\x00\xff")
        bearings: list[int] = []
        while len(bearings) < 3 * AZIMUTHS:
            message = spokes(await socket.raw())
            assert 0 < len(message) <= 32 and len({spoke["range"] for spoke in message}) == 1
            own = [spoke.get("bearing", 0) for spoke in message]
            assert own == sorted(own)
            bearings += own
        assert bearings[: 3 * AZIMUTHS] == [number % AZIMUTHS for number in range(3 * AZIMUTHS)]


async def test_there_are_no_spokes_of_another_radar() -> None:
    async with playing() as server:
        socket = await server.open(f"{BASE}/sim-9/spokes")
        with pytest.raises(Closed) as closed:
            await socket.raw()
        assert closed.value.code == 4404


async def test_a_scene_with_other_spokes_has_another_id() -> None:
    """What a client read once of a radar stays true under its id: the old one is no more."""
    async with playing(settings=FLAT_OUT) as server:
        old = await server.open(f"{BASE}/sim-0/spokes")
        spokes(await old.raw())
        other = {"radar": {"azimuths": 48, "range_max_m": 200, "coarse_azimuths": True}, "own_ship": {"heading_deg": 30}}
        await server.http.put("/api/radars/0/scene", json={"scene": other})
        while list((await server.http.get(BASE)).json()["radars"]) != ["sim-0-v2"]:
            await asyncio.sleep(0.01)
        known = (await server.http.get(f"{BASE}/sim-0-v2/capabilities")).json()
        assert known["spokesPerRevolution"] == 48
        new = await server.open(f"{BASE}/sim-0-v2/spokes")
        assert max([spoke.get("bearing", 0) for _ in range(60) for spoke in spokes(await new.raw())]) == 47
        assert_failed(await server.http.get(f"{BASE}/sim-0/capabilities"), 404)
