"""The REST interface in process: what it answers, what it refuses and why, and that the feed goes on untouched."""

import asyncio
import io
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from radar_service.scene.error import SceneError
from radar_service.scene.files.sandbox import Sandbox
from radar_service.scene.load import load_scene
from radar_service.stream import scenes as scenes_module
from radar_service.stream.app import create_app
from radar_service.stream.pace import Pace
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from tests.stream.asgi import Server, running
from tests.stream.fake import AZIMUTHS, BINS, FakeEngine, factory, scene

TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"
MESHED = b'name = "meshed"\n[[body]]\nname = "thing"\nmesh = "thing.obj"\nposition_m = [50, 50, 1]\n'


def station(**options: Any) -> Station:
    settings = options.pop("settings", Settings(pace=Pace("pause")))
    return Station("0", FakeEngine(scene()), options.pop("make", factory()), settings=settings, **options)


def play(test: Callable[[Server], Awaitable[None]], only: Station | None = None, **options: Any) -> None:
    async def body() -> None:
        async with running(create_app([only or station()], **options)) as server:
            await test(server)

    asyncio.run(asyncio.wait_for(body(), 20))


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
            {"gain": 60}, {"sea": 20, "rain": 5}, {"range_m": 150}, {"transmit": False}, {},
        ]  # fmt: skip
        for change in changes:
            expected |= change
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
    ("change", "place"),
    [
        ('{"gain": 140}', "gain: 140;"),
        ('{"gain": NaN}', "gain"),
        ('{"sea": "much"}', "sea: 'much';"),
        ('{"range_m": 5000}', "range_m: 5000; this radar sees from 10 to 200 m"),
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
def test_bad_controls_are_refused_with_the_place(change: str, place: str) -> None:
    async def test(server: Server) -> None:
        before = (await server.http.get("/api/radars/0/controls")).json()
        answer = await server.http.patch(
            "/api/radars/0/controls", content=change, headers={"content-type": "application/json"}
        )
        assert answer.status_code == 422 and any(line.startswith(place) for line in answer.json()["detail"]), answer.text
        assert (await server.http.get("/api/radars/0/controls")).json() == before

    play(test)


@pytest.mark.parametrize(
    ("radar", "rpm", "said"),
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
    radar: dict[str, Any], rpm: float, said: str | None
) -> None:
    async def test(server: Server) -> None:
        before = (await server.http.get("/api/radars/0/controls")).json()
        answer = await server.http.patch("/api/radars/0/controls", json={"rpm": rpm, "gain": 61})
        after = (await server.http.get("/api/radars/0/controls")).json()
        if said is None:
            assert answer.status_code == 200 and after["rpm"] == pytest.approx(rpm)
            load_scene({"radar": {"azimuths": AZIMUTHS, "coarse_azimuths": True, "rpm": rpm} | radar})
            return
        assert answer.status_code == 422 and answer.json()["detail"][0].startswith(said), answer.text
        assert after == before  # not even what could have been had
        with pytest.raises(SceneError, match=r"radar\.prf_hz: 12 is less than a pulse"):
            load_scene({"radar": {"azimuths": AZIMUTHS, "coarse_azimuths": True, "rpm": rpm} | radar})

    slow = {"rpm": 20.0} | radar
    made = Station("0", FakeEngine(scene(**slow)), factory(), settings=Settings(pace=Pace("pause")))
    play(test, made)


@pytest.mark.parametrize("body", ["{", "[" * 100_000, "\x00", '{"scene": ' + '{"a":' * 50_000])
@pytest.mark.parametrize(("method", "path"), [("PATCH", "radars/0/controls"), ("PUT", "radars/0/scene"), ("POST", "scenes")])
def test_what_is_not_json_is_refused(method: str, path: str, body: str) -> None:
    async def test(server: Server) -> None:
        answer = await server.http.request(
            method, f"/api/{path}", content=body, headers={"content-type": "application/json"}
        )
        assert answer.status_code in (400, 422) and answer.json()["detail"]

    play(test)


@pytest.mark.parametrize(
    ("wanted", "status", "line"),
    [
        ({"scene": "no such scene"}, 404, 'scene: there is no "no such scene"'),
        ({"scene": "../../etc/passwd"}, 404, "scene: there is no"),
        ({"scene": {"radar": {"azimuths": 10**9}}}, 422, "radar.azimuths"),
        ({"scene": {"body": [{"name": "a", "mesh": "/etc/passwd"}]}}, 422, "body[0].mesh"),
        ({"scene": 3}, 422, "scene"),
        ({}, 422, "scene"),
    ],
)
def test_a_bad_scene_is_refused_and_the_feed_goes_on(wanted: dict[str, Any], status: int, line: str) -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        epoch = (await feed.until("hello"))["epoch"]
        answer = await server.http.put("/api/radars/0/scene", json=wanted)
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


def test_a_scene_that_the_engine_refuses_is_refused_with_its_words() -> None:
    def refuse(_: Any) -> FakeEngine:
        raise SceneError("body[0].mesh: too fine", "body[1].mesh: too coarse")

    async def test(server: Server) -> None:
        answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": "x"}})
        assert answer.status_code == 422
        assert answer.json() == {"detail": ["body[0].mesh: too fine", "body[1].mesh: too coarse"]}
        answer = await server.http.post("/api/scenes", json={"name": "kept", "scene": {"name": "x"}})
        assert answer.status_code == 422 and len(answer.json()["detail"]) == 2
        assert "kept" not in {offer["name"] for offer in (await server.http.get("/api/scenes")).json()}

    play(test, station(make=refuse))


def test_an_upload_that_no_engine_takes_leaves_the_earlier_one_of_its_name() -> None:
    def picky(of: Any) -> FakeEngine:
        if of.name == "bad":
            raise SceneError("body[0].mesh: too fine")
        return factory()(of)

    async def test(server: Server) -> None:
        for title, status in (("good", 201), ("bad", 422)):
            answer = await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": title}})
            assert answer.status_code == status
        listed = {offer["name"]: offer for offer in (await server.http.get("/api/scenes")).json()}
        assert listed["mine"]["title"] == "good"

    play(test, station(make=picky))


def test_scenes_are_uploaded_listed_run_and_deleted(tmp_path: Path) -> None:
    (tmp_path / "local.toml").write_text('name = "from a folder"')
    (tmp_path / "broken.toml").write_text("name = ")

    async def test(server: Server) -> None:
        answer = await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": "my own"}})
        assert answer.status_code == 201 and answer.json()["name"] == "mine"
        assert answer.json()["plan"] == (await server.http.get("/api/radars/0")).json()["plan"]  # of the same kind of engine
        listed = {offer["name"]: offer for offer in (await server.http.get("/api/scenes")).json()}
        assert listed["mine"]["title"] == "my own" and listed["mine"]["origin"] == "uploaded"
        assert listed["local"]["title"] == "from a folder" and listed["local"]["origin"] == "folder"
        assert listed["broken"]["problems"]
        answer = await server.http.put("/api/radars/0/scene", json={"scene": "mine"})
        assert answer.status_code == 200 and answer.json()["name"] == "my own"
        assert (await server.http.delete("/api/scenes/mine")).status_code == 204
        assert (await server.http.delete("/api/scenes/mine")).status_code == 404
        assert (await server.http.delete("/api/scenes/local")).status_code == 409
        assert "mine" not in {offer["name"] for offer in (await server.http.get("/api/scenes")).json()}

    play(test, scene_folders=[tmp_path])


def test_a_scene_with_its_mesh_comes_as_a_form() -> None:
    async def test(server: Server) -> None:
        parts = [("scene", ("m.toml", MESHED)), ("files", ("thing.obj", TRIANGLE))]
        answer = await server.http.post("/api/scenes", data={"name": "meshed"}, files=parts)
        assert answer.status_code == 201 and answer.json()["bodies"] == 1, answer.text
        answer = await server.http.put("/api/radars/0/scene", json={"scene": "meshed"})
        assert answer.status_code == 200

    play(test)


def test_a_mesh_that_breaks_its_reader_is_refused_and_the_feed_goes_on() -> None:
    """A soup of 200 000 triangles (10 MB) needs more than the 48 MiB that this server allows; the next upload is taken."""
    soup = np.zeros(200_000, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    soup["corners"] = np.random.default_rng(0).random((200_000, 3, 3))
    bomb = bytes(80) + np.uint32(200_000).tobytes() + soup.tobytes()
    limited = Sandbox(memory=48 * 2**20)

    async def test(server: Server) -> None:
        feed = await server.feed()
        epoch = (await feed.until("hello"))["epoch"]
        for content, status in ((bomb, 422), (TRIANGLE, 201)):
            ending = "stl" if content is bomb else "obj"
            parts = [("scene", ("m.toml", MESHED.replace(b"obj", ending.encode()))), ("files", (f"thing.{ending}", content))]
            answer = await server.http.post("/api/scenes", data={"name": "meshed"}, files=parts)
            assert answer.status_code == status, answer.text
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 2}})
        assert [(m["epoch"], m["first"]) for m in await feed.spokes(2)] == [(epoch, 0), (epoch, 1)]

    play(test, sandbox=limited)
    assert limited._child is None  # it goes with the server


@pytest.mark.parametrize(
    ("name", "parts", "line"),
    [
        ("meshed", [("scene", ("m.toml", MESHED))], "body[0].mesh"),
        ("meshed", [("scene", ("m.exe", MESHED))], 'scene: the ending ".exe"'),
        ("meshed", [("files", ("thing.obj", TRIANGLE))], "scene, name: send"),
        ("meshed", [("scene", ("m.toml", MESHED)), ("files", ("../thing.obj", TRIANGLE))], "files: '../thing.obj'"),
        ("meshed", [("scene", ("m.toml", MESHED)), ("files", (".hidden", TRIANGLE))], "files: '.hidden'"),
        ("meshed", [("scene", ("m.toml", MESHED)), ("files", ("scene.toml", TRIANGLE))], "files: 'scene.toml'"),
        ("meshed", [("scene", ("m.toml", MESHED)), *[("files", ("a.obj", TRIANGLE))] * 2], "files: each is a file"),
        ("../meshed", [("scene", ("m.toml", MESHED)), ("files", ("thing.obj", TRIANGLE))], "name: '../meshed'"),
    ],
)
def test_a_bad_upload_is_refused_and_leaves_nothing(name: str, parts: Any, line: str) -> None:
    async def test(server: Server) -> None:
        answer = await server.http.post("/api/scenes", data={"name": name}, files=parts)
        assert answer.status_code == 422 and answer.json()["detail"][0].startswith(line), answer.text
        assert "radar-scenes" not in answer.text  # the server's folders are nobody's business
        offers = (await server.http.get("/api/scenes")).json()
        assert all(offer["origin"] != "uploaded" for offer in offers)

    play(test)


def test_the_shelf_of_uploads_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes_module, "MAX_UPLOADS", 1)

    async def test(server: Server) -> None:
        for name, status in (("a", 201), ("a", 201), ("b", 409)):
            assert (await server.http.post("/api/scenes", json={"name": name, "scene": {}})).status_code == status

    play(test)


def test_a_body_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.stream.app.MAX_UPLOAD_BYTES", 1000)

    async def test(server: Server) -> None:
        body = json.dumps({"name": "a", "scene": {"name": "x" * 2000}})
        answer = await server.http.post("/api/scenes", content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 413

    play(test)


def test_uploads_go_with_the_server() -> None:
    kept: list[Path] = []

    async def test(server: Server) -> None:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": {}})

    make = scenes_module.SceneShelf.__init__

    def noting(shelf: Any, *arguments: Any) -> None:
        make(shelf, *arguments)
        kept.append(shelf._home)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scenes_module.SceneShelf, "__init__", noting)
        play(test)
    assert kept and not kept[0].exists()


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


def test_the_picture_shows_what_has_been_swept() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": AZIMUTHS // 2}})
        await feed.spokes(AZIMUTHS // 2)
        while (await server.http.get("/api/health")).json()["radars"][0]["simulated_s"] < 1.25:
            await asyncio.sleep(0)
        answer = await server.http.get("/api/radars/0/ppi.png?size=200")
        assert answer.headers["content-type"] == "image/png"
        picture = np.asarray(Image.open(io.BytesIO(answer.content)).convert("RGB")).astype(int)
        assert picture.shape == (200, 200, 3)
        east, west = picture[105:135, 135:165], picture[105:135, 35:65]  # below the labels of the rings
        assert np.ptp(west.mean(axis=(0, 1))) < 6  # grey: not swept yet
        assert np.ptp(east.mean(axis=(0, 1))) > 30  # echoes in colour
        assert (await server.http.get("/api/radars/0/ppi.png?size=5")).status_code == 422
        assert (await server.http.get("/api/radars/0/ppi.png?range_m=nan")).status_code == 422

    play(test)


def test_health_counts() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed()
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 7}})
        await feed.spokes(7)
        answer = await server.http.get("/api/health")
        assert answer.status_code == 200 and answer.json()["status"] == "ok"
        radar = answer.json()["radars"][0]
        assert (radar["state"], radar["next"], radar["clients"], radar["views"]) == ("paused", 7, 1, 1)

    play(test)


def test_a_page_of_another_site_may_not_command() -> None:
    async def test(server: Server) -> None:
        elsewhere, here = {"origin": "http://elsewhere.example"}, {"origin": "http://radar"}
        for method, path in (
            ("PATCH", "radars/0/controls"),
            ("POST", "scenes"),
            ("DELETE", "scenes/a"),
            ("PUT", "radars/0/scene"),
        ):
            answer = await server.http.request(method, f"/api/{path}", json={}, headers=elsewhere)
            assert answer.status_code == 403
        assert (await server.http.patch("/api/radars/0/controls", json={}, headers=here)).status_code == 200

    play(test)


def test_every_answer_carries_the_security_headers() -> None:
    async def test(server: Server) -> None:
        for path in ("/api/health", "/api/radars/9", "/nowhere"):
            headers = (await server.http.get(path)).headers
            assert headers["content-security-policy"].startswith("default-src 'self'")
            assert headers["x-content-type-options"] == "nosniff"

    play(test)


def test_the_page_is_served() -> None:
    async def test(server: Server) -> None:
        answer = await server.http.get("/")
        assert answer.status_code == 200 and "text/html" in answer.headers["content-type"]
        assert (await server.http.get("/../pyproject.toml")).status_code == 404

    play(test)


def test_openapi_tells_every_answer_and_gives_examples() -> None:
    async def test(server: Server) -> None:
        schema = (await server.http.get("/api/openapi.json")).json()
        expected = {
            ("/api/health", "get"): {"200", "503"},
            ("/api/health/alive", "get"): {"200"},
            ("/api/health/ready", "get"): {"200", "503"},
            ("/api/tickets", "post"): {"201"},
            ("/api/scenes", "get"): {"200"},
            ("/api/scenes", "post"): {"201", "400", "409", "413", "422"},
            ("/api/scenes/{name}", "delete"): {"204", "404", "409", "422"},
            ("/api/radars", "get"): {"200"},
            ("/api/radars/{radar}", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "patch"): {"200", "400", "404", "413", "422"},
            ("/api/radars/{radar}/scene", "put"): {"200", "400", "404", "413", "422"},
            ("/api/radars/{radar}/truth", "get"): {"200", "403", "404", "422"},
            ("/api/radars/{radar}/ppi.png", "get"): {"200", "404", "422"},
        }
        told = {
            (path, method): set(about["responses"])
            for path, ways in schema["paths"].items()
            for method, about in ways.items()
        }
        assert told == {way: answers | {"401", "421"} for way, answers in expected.items()}
        for path, method in (("/api/radars/{radar}/controls", "patch"), ("/api/radars/{radar}/scene", "put")):
            body = schema["paths"][path][method]["requestBody"]["content"]["application/json"]["schema"]["$ref"]
            assert schema["components"]["schemas"][body.rsplit("/", 1)[1]]["examples"]
        problem = schema["paths"]["/api/radars/{radar}/scene"]["put"]["responses"]["422"]["content"]["application/json"]
        assert problem["schema"]["$ref"].endswith("/Problem")

    play(test)
