"""REST of radars: answers, refusals with their reason, and a feed that goes on."""

import asyncio
import contextlib
import io
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from radar_service.ports.feed.feed_socket import ConnectionErrors
from radar_service.scene_file.load import load_scene
from radar_service.world.error import SceneError
from tests.ports.asgi import Server
from tests.ports.playing import playing, station
from tests.service.fake import AZIMUTHS, BINS, RADAR, scene

ERRORS, CONTROLS = "/api/radars/0/errors", "/api/radars/0/controls"
JSON = {"content-type": "application/json"}


async def test_radars_are_listed_and_described() -> None:
    async with playing() as server:
        listed = (await server.http.get("/api/radars")).json()
        one = (await server.http.get("/api/radars/0")).json()
        assert listed == [one] and one["id"] == "0" and one["feed"] == "/api/radars/0/feed"
        assert (one["azimuths"], one["bins"], one["state"]) == (AZIMUTHS, BINS, "paused")
        assert one["scene"]["name"] == "test scene" and one["encodings"] == ["u8", "u8-log", "f16", "f32", "c64"]


async def test_an_unknown_radar_is_not_found() -> None:
    async with playing() as server:
        paths = [("GET", path) for path in ("", "/controls", "/truth", "/ppi.png", "/errors")]
        for method, path in (*paths, ("PATCH", "/errors"), ("DELETE", "/errors")):
            answer = await server.http.request(method, f"/api/radars/7{path}", json={})
            assert answer.status_code == 404 and answer.json() == {"detail": ['radar: there is no "7"; there are 0']}


async def test_controls_change_one_by_one() -> None:
    async with playing() as server:
        expected = (await server.http.get("/api/radars/0/controls")).json()
        changes: list[dict[str, Any]] = [
            {"gain": 60}, {"gain_auto": True}, {"sea": 20, "rain": 5}, {"sea": 30, "sea_auto": True}, {"range_m": 150},
            {"transmit": False}, {},
        ]  # fmt: skip
        for change in changes:
            by_hand = {f"{name}_auto": False for name in ("gain", "sea") if name in change}
            expected |= by_hand | change
            answer = await server.http.patch("/api/radars/0/controls", json=change)
            assert answer.status_code == 200 and answer.json() == expected
        for change, pace in (
            ({"factor": 4}, {"state": "pause", "factor": 4}),
            ({"factor": "max"}, {"state": "pause", "factor": "max"}),
            ({"state": "step"}, {"state": "pause", "factor": "max"}),
            ({"state": "run", "factor": 1}, {"state": "run", "factor": 1}),
        ):
            answer = await server.http.patch("/api/radars/0/controls", json={"pace": change})
            assert answer.json() == expected | {"pace": pace}


async def test_bad_controls_are_refused_with_the_key() -> None:
    async with playing() as server:
        before = (await server.http.get(CONTROLS)).json()
        for change, key in (
            ('{"gain": 140}', "gain: 140;"), ('{"gain": NaN}', "gain"), ('{"sea": "much"}', "sea: 'much';"),
            ('{"range_m": 5000}', "range_m: 5000; this radar allows 10 to 200 m"), ('{"range_m": -1}', "range_m"),
            ('{"rpm": 0}', "rpm"), ('{"pace": {"factor": 0}}', "pace.factor"), ('{"pace": {"factor": Infinity}}', "pace.factor"),
            ('{"pace": {"state": "hop"}}', "pace.state"), ('{"pace": {"state": "step", "steps": 0}}', "pace.steps"),
            ('{"colour": "red"}', "colour"), ("[1]", "body"),
        ):  # fmt: skip
            answer = await server.http.patch(CONTROLS, content=change, headers=JSON)
            assert answer.status_code == 422 and any(line.startswith(key) for line in answer.json()["detail"]), answer.text
        assert (await server.http.get(CONTROLS)).json() == before


@pytest.mark.parametrize(
    ("radar", "rpm", "refusal"),
    [
        (
            {"prf_hz": 12.0},
            31.0,
            "rpm: 31 gives 12.4 spokes a second, more than the 12 pulses of the scene's prf_hz; give at most 30",
        ),
        ({"prf_hz": 12.0}, 30.0, None),  # exactly a pulse to a spoke
        ({}, 600.0, None),
    ],
)
async def test_a_rate_of_rotation_that_the_scene_file_could_not_have_is_refused(
    radar: dict[str, Any], rpm: float, refusal: str | None
) -> None:
    slow = {"rpm": 20.0} | radar
    async with playing(station(scene(**slow))) as server:
        before = (await server.http.get("/api/radars/0/controls")).json()
        answer = await server.http.patch("/api/radars/0/controls", json={"rpm": rpm, "gain": 61})
        after = (await server.http.get("/api/radars/0/controls")).json()
        if refusal is None:
            assert answer.status_code == 200 and after["rpm"] == pytest.approx(rpm)
            load_scene({"radar": {"azimuths": AZIMUTHS, "coarse_azimuths": True, "rpm": rpm} | radar})
            return
        assert answer.status_code == 422 and answer.json()["detail"][0].startswith(refusal), answer.text
        assert after == before  # not even what could have been had
        with pytest.raises(SceneError, match=r"radar\.prf_hz: 12 is less than a pulse"):
            load_scene({"radar": {"azimuths": AZIMUTHS, "coarse_azimuths": True, "rpm": rpm} | radar})


BAD_SCENES: list[tuple[dict[str, Any], int, str]] = [
    ({"scene": "no such scene"}, 404, 'scene: there is no "no such scene"'), ({}, 422, "scene"), ({"scene": 3}, 422, "scene"),
    ({"scene": "../../etc/passwd"}, 404, "scene: there is no"),
    ({"scene": {"radar": {"azimuths": 10**9}}}, 422, "radar.azimuths"),
    ({"scene": {"body": [{"name": "a", "mesh": "/etc/passwd"}]}}, 422, "body[0].mesh"),
]  # fmt: skip


async def test_a_bad_scene_is_refused_and_the_feed_goes_on() -> None:
    async with playing() as server:
        feed = await server.feed()
        epoch = (await feed.until("hello"))["epoch"]
        for requested, status, line in BAD_SCENES:
            answer = await server.http.put("/api/radars/0/scene", json=requested)
            assert answer.status_code == status and answer.json()["detail"][0].startswith(line), answer.text
        await server.step(2)
        assert [(m["epoch"], m["first"]) for m in await feed.spokes(2)] == [(epoch, 0), (epoch, 1)]


async def test_truth_is_given_only_where_it_is_allowed() -> None:
    async with playing(station(allow_truth=True)) as server:
        state = (await server.http.get("/api/radars/0/truth?t=12.5")).json()
        assert state["time"] == 12.5 and state["bodies"][0]["name"] == "buoy"
        assert (await server.http.get("/api/radars/0/truth?t=nan")).status_code == 422
    async with playing() as server:
        answer = await server.http.get("/api/radars/0/truth")
        assert answer.status_code == 403 and "--truth" in answer.json()["detail"][0]


async def test_the_picture_shows_the_azimuths_received_so_far() -> None:
    async with playing() as server:
        feed = await server.feed()
        await server.step(AZIMUTHS // 2)
        await feed.spokes(AZIMUTHS // 2)
        while (await server.http.get("/api/health")).json()["radars"][0]["simulated_s"] < 1.25:
            await asyncio.sleep(0.001)
        answer = await server.http.get("/api/radars/0/ppi.png?size=200")
        assert answer.headers["content-type"] == "image/png"
        picture = np.asarray(Image.open(io.BytesIO(answer.content)).convert("RGB")).astype(int)
        assert picture.shape == (200, 200, 3)
        east, west = picture[105:135, 135:165], picture[105:135, 35:65]  # below the labels of the rings
        assert np.ptp(west.mean(axis=(0, 1))) < 6  # grey: not received yet
        assert np.ptp(east.mean(axis=(0, 1))) > 30  # echoes in colour
        assert (await server.http.get("/api/radars/0/ppi.png?size=5")).status_code == 422
        assert (await server.http.get("/api/radars/0/ppi.png?range_m=nan")).status_code == 422


NONE: dict[str, Any] = dict.fromkeys(("gyro", "log", "position", "antenna", "feed"))


async def test_errors_are_told_changed_and_switched_off() -> None:
    async with playing(station(allow_truth=True)) as server:
        assert (await server.http.get(ERRORS)).json() == NONE
        gyro = {"bias_deg": 1.5, "calibration_deg": 0.0, "calibration_phase_deg": 0.0, "noise_deg": 0.0, "noise_time_s": 1.0,
                "latency_s": 0.0}  # fmt: skip
        answer = await server.http.patch(ERRORS, json={"gyro": {"bias_deg": 1.5}})
        assert answer.status_code == 200 and answer.json() == NONE | {"gyro": gyro}
        answer = (
            await server.http.patch(ERRORS, json={"feed": {"heading_lost_s": [[1, 2]], "stuck_sector_deg": [10, 20]}})
        ).json()
        assert answer["gyro"] == gyro and answer["feed"]["heading_lost_s"] == [[1, 2]] and answer["feed"]["late_s"] == 0.5
        assert (await server.http.get(ERRORS)).json() == answer
        assert (await server.http.patch(ERRORS, json={"gyro": None, "feed": {}})).json() == NONE
        assert (await server.http.patch(ERRORS, json={"profile": "imo-a823"})).json()["log"]["bias_kn"] == 0.5
        assert (await server.http.patch(ERRORS, json={})).json()["log"]["bias_kn"] == 0.5
        assert (await server.http.delete(ERRORS)).json() == NONE


async def test_bad_bodies_are_refused_and_change_nothing() -> None:
    async with playing(station(allow_truth=True)) as server:
        before = (await server.http.patch(ERRORS, json={"log": {"bias_kn": 2}})).json()
        for body, line in (
            ('{"gyro": {"bias_deg": 181}}', "gyro.bias_deg: 181; Input should be less than or equal to 180"),
            ('{"gyroscope": {}}', "gyroscope: {}; Extra inputs are not permitted"),
            ('{"feed": {"heading_lost_s": [[2, 1]]}}', "heading_lost_s[0]: 1 s is not after 2 s"),
            ('{"profile": "imo"}', "profile: 'imo'; Input should be 'imo-a823'"), ("[]", "body"), ("null", "body"),
            ("", "body"), ("{", "JSON"),
        ):  # fmt: skip
            answer = await server.http.patch(ERRORS, content=body, headers=JSON)
            assert answer.status_code in (422, 400) and line in " ".join(answer.json()["detail"]), answer.text
        assert (await server.http.get(ERRORS)).json() == before


async def test_blind_spokes_are_those_that_the_radar_does_not_transmit_in() -> None:
    """True sectors: 080 to 100 off a bow of 030, whatever is reported."""

    async def blind(server: Server) -> list[bool]:
        feed = await server.feed()
        await server.step(AZIMUTHS)
        return [
            flag for message in await feed.spokes(AZIMUTHS) for flag in message.get("blind") or [False] * message["count"]
        ]

    seen: list[list[bool]] = []
    changes: list[dict[str, Any]] = [{}, {"gyro": {"bias_deg": 90}}, {"feed": {"heading_lost_s": [[0, 1e9]]}}]
    for change in changes:
        async with playing() as server:
            await server.http.patch(ERRORS, json=change)
            seen.append(await blind(server))
    # azimuths 110 to 130, of steps of 15 only 120
    assert seen[0] == seen[1] == seen[2] == [15 * k == 120 for k in range(AZIMUTHS)]


async def test_a_slow_connection_carries_each_message(monkeypatch: pytest.MonkeyPatch) -> None:
    carried = list[int]()

    async def carry(_: ConnectionErrors, size: int) -> None:
        carried.append(size)

    monkeypatch.setattr(ConnectionErrors, "carry", carry)
    async with playing() as server:
        feed = await server.feed()
        sizes = [len(await feed.raw())]
        await server.step(AZIMUTHS)
        while len(sizes) < 3:
            sizes.append(len(await feed.raw()))
        assert carried[:3] == sizes


async def test_frames_take_no_short_cut_past_a_faulty_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    carried, written = list[int](), list[int]()

    async def carry(_: ConnectionErrors, size: int) -> None:
        carried.append(size)

    def write(frame: bytes) -> bool:
        written.append(len(frame))
        return True

    monkeypatch.setattr(ConnectionErrors, "carry", carry)
    websocket = SimpleNamespace(write_frame=write, on_end=lambda end: None, write_last=lambda: None)
    monkeypatch.setattr("radar_service.ports.feed.feed_socket.framed", lambda scope: websocket)
    async with playing(only := station()) as server:
        await server.http.patch(ERRORS, json={"feed": {"cut_after_s": 1e6}})
        await server.feed()
        await server.step(AZIMUTHS)
        while not only.transmitter.pacer.idle or len(written) < 5:
            await asyncio.sleep(0.001)
        assert len(written) == len(carried)


async def test_a_cut_connection_ends_without_a_bye_and_can_be_resumed() -> None:
    async with playing() as server:
        feed = await server.feed()
        hello = await feed.receive()
        await server.http.patch(ERRORS, json={"feed": {"cut_after_s": 0.1}})
        received: list[dict[str, Any]] = []
        while not feed.ended:
            await server.step(1)
            with contextlib.suppress(TimeoutError):
                received.append(await asyncio.wait_for(feed.receive(), 0.5))  # s, for what takes milliseconds or never comes
        while feed.holds_message:  # on a busy machine it takes longer
            received.append(await feed.receive())
        assert all(message["type"] == "spokes" for message in received)
        await server.http.delete(ERRORS)
        following = await server.feed(f"?since={hello['epoch']}:{len(received)}")
        assert (await following.until("spokes"))["first"] == len(received)  # the one that the cut has swallowed


async def test_a_radar_ashore_takes_no_errors_of_a_ships_sensors() -> None:
    ashore = load_scene({"radar": [RADAR | {"id": "shore", "platform": {"position_m": [0, 0]}}]})
    errors = "/api/radars/shore/errors"
    async with playing(station(ashore, "shore")) as server:
        answer = await server.http.patch(errors, json={"gyro": {"bias_deg": 20}})
        assert answer.status_code == 422 and "a fixed site has no gyro" in answer.json()["detail"][0]
        answer = await server.http.patch(errors, json={"profile": "imo-a823"})
        assert [name for name, table in answer.json().items() if table] == ["antenna"]
