"""REST of radars: answers, refusals with their reason, and a feed that goes on."""

import asyncio
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from radar_service.world.error import SceneError
from tests.ports.asgi import Server
from tests.ports.playing import play, station
from tests.service.fake import AZIMUTHS, BINS, FakeEngine, factory, scene


def test_radars_are_listed_and_described() -> None:
    async def test(server: Server) -> None:
        listed = (await server.http.get("/api/radars")).json()
        one = (await server.http.get("/api/radars/0")).json()
        assert listed == [one] and one["id"] == "0" and one["feed"] == "/api/radars/0/feed"
        assert (one["azimuths"], one["bins"], one["state"]) == (AZIMUTHS, BINS, "paused")
        assert one["scene"]["name"] == "test scene" and one["encodings"] == ["u8", "u8-log", "f16", "f32", "c64"]

    play(test)


@pytest.mark.parametrize("path", ["", "/controls", "/truth", "/ppi.png"])
def test_an_unknown_radar_is_not_found(path: str) -> None:
    async def test(server: Server) -> None:
        answer = await server.http.get(f"/api/radars/7{path}")
        assert answer.status_code == 404 and answer.json() == {"detail": ['radar: there is no "7"; there are 0']}

    play(test)


def test_controls_change_one_by_one() -> None:
    async def test(server: Server) -> None:
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

    play(test)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ('{"gain": 140}', "gain: 140;"),
        ('{"gain": NaN}', "gain"),
        ('{"sea": "much"}', "sea: 'much';"),
        ('{"range_m": 5000}', "range_m: 5000; this radar allows 10 to 200 m"),
        ('{"range_m": -1}', "range_m"),
        ('{"rpm": 0}', "rpm"),
        ('{"pace": {"factor": 0}}', "pace.factor"),
        ('{"pace": {"factor": Infinity}}', "pace.factor"),
        ('{"pace": {"state": "hop"}}', "pace.state"),
        ('{"pace": {"state": "step", "steps": 0}}', "pace.steps"),
        ('{"colour": "red"}', "colour"),
        ("[1]", "body"),
    ],
)
def test_bad_controls_are_refused_with_the_key(change: str, key: str) -> None:
    async def test(server: Server) -> None:
        before = (await server.http.get("/api/radars/0/controls")).json()
        answer = await server.http.patch(
            "/api/radars/0/controls", content=change, headers={"content-type": "application/json"}
        )
        assert answer.status_code == 422 and any(line.startswith(key) for line in answer.json()["detail"]), answer.text
        assert (await server.http.get("/api/radars/0/controls")).json() == before

    play(test)


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
def test_a_rate_of_rotation_that_the_scene_file_could_not_have_is_refused(
    radar: dict[str, Any], rpm: float, refusal: str | None
) -> None:
    async def test(server: Server) -> None:
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

    slow = {"rpm": 20.0} | radar
    made = Station("0", FakeEngine(scene(**slow)), factory(), settings=Settings(pace=Pace("pause")))
    play(test, made)


@pytest.mark.parametrize(
    ("requested", "status", "line"),
    [
        ({"scene": "no such scene"}, 404, 'scene: there is no "no such scene"'),
        ({"scene": "../../etc/passwd"}, 404, "scene: there is no"),
        ({"scene": {"radar": {"azimuths": 10**9}}}, 422, "radar.azimuths"),
        ({"scene": {"body": [{"name": "a", "mesh": "/etc/passwd"}]}}, 422, "body[0].mesh"),
        ({"scene": 3}, 422, "scene"),
        ({}, 422, "scene"),
    ],
)
def test_a_bad_scene_is_refused_and_the_feed_goes_on(requested: dict[str, Any], status: int, line: str) -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        epoch = (await feed.until("hello"))["epoch"]
        answer = await server.http.put("/api/radars/0/scene", json=requested)
        assert answer.status_code == status and answer.json()["detail"][0].startswith(line), answer.text
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 2}})
        assert [(m["epoch"], m["first"]) for m in await feed.spokes(2)] == [(epoch, 0), (epoch, 1)]

    play(test)


def test_an_engine_that_dies_at_once_does_not_take_over() -> None:
    async def test(server: Server) -> None:
        answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": "x"}})
        assert answer.status_code == 422 and "the wheel came off" in answer.json()["detail"][0]
        assert (await server.http.get("/api/health")).json()["status"] == "ok"

    play(test, station(make=factory(dies_at=1)))


def test_truth_is_given_only_where_it_is_allowed() -> None:
    async def allowed(server: Server) -> None:
        state = (await server.http.get("/api/radars/0/truth?t=12.5")).json()
        assert state["time"] == 12.5 and state["bodies"][0]["name"] == "buoy"
        assert (await server.http.get("/api/radars/0/truth?t=nan")).status_code == 422

    async def forbidden(server: Server) -> None:
        answer = await server.http.get("/api/radars/0/truth")
        assert answer.status_code == 403 and "--truth" in answer.json()["detail"][0]

    play(allowed, station(allow_truth=True))
    play(forbidden)


def test_the_picture_shows_the_azimuths_received_so_far() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": AZIMUTHS // 2}})
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

    play(test)
