"""REST of scenes: uploaded, listed, run, deleted, and refused with the reason."""

import re
import sys
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.scene_file.readers.sandbox import Sandbox
from radar_service.service.jobs import RETRY_SECONDS
from radar_service.world.error import SceneError
from tests.ports.playing import playing, station
from tests.service.fake import FakeEngine, made_by

TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"


MESHED = b'name = "meshed"\n[[body]]\nname = "thing"\nmesh = "thing.obj"\nposition_m = [50, 50, 1]\n'


async def test_a_scene_that_the_engine_refuses_is_refused_with_its_words() -> None:
    def refuse(_: Any) -> FakeEngine:
        raise SceneError("body[0].mesh: too fine", "body[1].mesh: too coarse")

    async with playing(station(make=made_by(refuse))) as server:
        answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": "x"}})
        assert answer.status_code == 422
        assert answer.json() == {"detail": ["body[0].mesh: too fine", "body[1].mesh: too coarse"]}
        answer = await server.http.post("/api/scenes", json={"name": "kept", "scene": {"name": "x"}})
        assert answer.status_code == 422 and len(answer.json()["detail"]) == 2
        assert "kept" not in {entry["name"] for entry in (await server.http.get("/api/scenes")).json()}


async def test_an_upload_that_no_engine_takes_leaves_the_earlier_one_of_its_name() -> None:
    def picky(of: Any) -> FakeEngine:
        if of.name == "bad":
            raise SceneError("body[0].mesh: too fine")
        return FakeEngine(of)

    async with playing(station(make=made_by(picky))) as server:
        for title, status in (("good", 201), ("bad", 422)):
            answer = await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": title}})
            assert answer.status_code == status
        listed = {entry["name"]: entry for entry in (await server.http.get("/api/scenes")).json()}
        assert listed["mine"]["title"] == "good"


async def test_scenes_are_uploaded_listed_run_and_deleted(tmp_path: Path) -> None:
    (tmp_path / "local.toml").write_text('name = "from a folder"')
    (tmp_path / "broken.toml").write_text("name = ")
    async with playing(ports=PortHost((RestPort([tmp_path]), FeedPort()))) as server:
        answer = await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": "my own"}})
        assert answer.status_code == 201 and answer.json()["name"] == "mine"
        assert answer.json()["plan"] == (await server.http.get("/api/radars/0")).json()["plan"]  # of the same kind of engine
        listed = {entry["name"]: entry for entry in (await server.http.get("/api/scenes")).json()}
        assert listed["mine"]["title"] == "my own" and listed["mine"]["origin"] == "uploaded"
        assert listed["local"]["title"] == "from a folder" and listed["local"]["origin"] == "folder"
        assert listed["broken"]["problems"]
        answer = await server.http.put("/api/radars/0/scene", json={"scene": "mine"})
        assert answer.status_code == 200 and answer.json()["name"] == "my own"
        assert (await server.http.delete("/api/scenes/mine")).status_code == 204
        assert (await server.http.delete("/api/scenes/mine")).status_code == 404
        assert (await server.http.delete("/api/scenes/local")).status_code == 409
        assert "mine" not in {entry["name"] for entry in (await server.http.get("/api/scenes")).json()}


WITHOUT_TIME = [sys.executable, "-c", "import sys; sys.stdin.buffer.read()"]  # a child that waits for a processor


async def test_a_scene_with_its_mesh_comes_as_a_form_and_a_busy_machine_is_no_fault_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """While the machine is busy the answer is 503; afterwards the reader's own words, or that it is taken and runs."""
    sandboxes = [partial(Sandbox, backstop=0.05, command=WITHOUT_TIME), Sandbox, Sandbox]
    monkeypatch.setattr("radar_service.service.radio.scene_process_main.Sandbox", lambda: sandboxes.pop(0)())
    async with playing() as server:

        async def uploaded(mesh: bytes) -> Any:
            parts = [("scene", ("m.toml", MESHED)), ("files", ("thing.obj", mesh))]
            return await server.http.post("/api/scenes", data={"name": "meshed"}, files=parts)

        answer = await uploaded(TRIANGLE)
        assert answer.status_code == 503 and answer.headers["retry-after"] == str(RETRY_SECONDS)
        assert re.match("body.0..mesh: thing.obj: the machine is busy: .* try again later", answer.json()["detail"][0])
        answer = await uploaded(TRIANGLE + b"f 1 2 9\n")
        assert answer.status_code == 422 and "face" in answer.json()["detail"][0], answer.text
        answer = await uploaded(TRIANGLE)
        assert answer.status_code == 201 and answer.json()["bodies"] == 1, answer.text
        monkeypatch.undo()
        assert (await server.http.put("/api/radars/0/scene", json={"scene": "meshed"})).status_code == 200


async def test_a_mesh_that_breaks_its_reader_is_refused_and_the_feed_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """A soup of 60 000 triangles (3 MB) needs more than the 16 MiB that this server allows; the next upload is taken."""
    soup = np.zeros(60_000, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    soup["corners"] = np.random.default_rng(0).random((60_000, 3, 3))
    bomb = bytes(80) + np.uint32(60_000).tobytes() + soup.tobytes()
    closed: list[bool] = []

    class Limited(Sandbox):
        def __init__(self) -> None:
            super().__init__(memory=16 * 2**20)

        def close(self) -> None:
            super().close()
            closed.append(True)

    monkeypatch.setattr("radar_service.service.radio.scene_process_main.Sandbox", Limited)
    async with playing() as server:
        feed = await server.feed()
        epoch = (await feed.until("hello"))["epoch"]
        for content, status in ((bomb, 422), (TRIANGLE, 201)):
            ending = "stl" if content is bomb else "obj"
            parts = [("scene", ("m.toml", MESHED.replace(b"obj", ending.encode()))), ("files", (f"thing.{ending}", content))]
            answer = await server.http.post("/api/scenes", data={"name": "meshed"}, files=parts)
            assert answer.status_code == status, answer.text
        await server.step(2)
        assert [(m["epoch"], m["first"]) for m in await feed.spokes(2)] == [(epoch, 0), (epoch, 1)]
    assert len(closed) == 2  # one for each upload


BAD_FORMS: list[tuple[str, str, list[str], str]] = [  # name, name of the scene's file, those of meshes, and the refusal
    ("meshed", "m.toml", [], "body[0].mesh"), ("meshed", "m.exe", [], 'scene: the ending ".exe"'),
    ("meshed", "", ["thing.obj"], "scene, name: send"), ("meshed", "m.toml", ["../thing.obj"], "files: '../thing.obj'"),
    ("meshed", "m.toml", [".hidden"], "files: '.hidden'"), ("meshed", "m.toml", ["scene.toml"], "files: 'scene.toml'"),
    ("meshed", "m.toml", ["a.obj"] * 2, "files: each is a file"), ("../meshed", "m.toml", ["thing.obj"], "name: '../meshed'"),
    ("meshed", "m.toml", [f"{n}.obj" for n in range(65)], "files: 65 files; at most 64"),
]  # fmt: skip


async def test_a_bad_upload_is_refused_and_leaves_nothing() -> None:
    async with playing() as server:
        for name, scene, meshes, line in BAD_FORMS:
            parts = [("scene", (scene, MESHED))] * bool(scene) + [("files", (mesh, TRIANGLE)) for mesh in meshes]
            answer = await server.http.post("/api/scenes", data={"name": name}, files=parts)
            assert answer.status_code == 422 and answer.json()["detail"][0].startswith(line), answer.text
            assert "radar-scenes" not in answer.text  # the server's folders are nobody's business
        assert all(entry["origin"] != "uploaded" for entry in (await server.http.get("/api/scenes")).json())


async def test_what_is_not_json_is_refused() -> None:
    headers, routes = {"content-type": "application/json"}, ("PATCH radars/0/controls", "PUT radars/0/scene", "POST scenes")
    async with playing() as server:
        for route, body in product(routes, ("{", "[" * 60_000, "\x00", '{"scene": ' + '{"a":' * 10_000)):
            method, path = route.split()
            answer = await server.http.request(method, f"/api/{path}", content=body, headers=headers)
            assert answer.status_code in (400, 422)
            assert len(body) > 1 or answer.json()["detail"][0].startswith("body: not JSON: ")
