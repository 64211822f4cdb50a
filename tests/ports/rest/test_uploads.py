"""Bodies of uploads: forms and JSON, good and bad."""

from typing import Any

import pytest

from radar_service.ports.rest.bodies import SMALL
from tests.ports.playing import playing
from tests.ports.rest.test_scene_routes import MESHED, TRIANGLE


@pytest.mark.parametrize(("method", "path"), [("PATCH", "radars/0/controls"), ("PUT", "radars/0/scene"), ("POST", "scenes")])
async def test_what_is_not_json_is_refused(method: str, path: str) -> None:
    async with playing() as server:
        for body in ("{", "[" * 100_000, "\x00", '{"scene": ' + '{"a":' * 50_000):
            headers = {"content-type": "application/json"}
            answer = await server.http.request(method, f"/api/{path}", content=body, headers=headers)
            line = answer.json()["detail"][0]
            if method == "PATCH" and len(body) > SMALL:
                assert answer.status_code == 413 and line.startswith("body: more than ")
            else:
                assert answer.status_code in (400, 422) and (len(body) > 1 or line.startswith("body: not JSON: "))


async def test_a_scene_with_its_mesh_comes_as_a_form() -> None:
    async with playing() as server:
        parts = [("scene", ("m.toml", MESHED)), ("files", ("thing.obj", TRIANGLE))]
        answer = await server.http.post("/api/scenes", data={"name": "meshed"}, files=parts)
        assert answer.status_code == 201 and answer.json()["bodies"] == 1, answer.text
        answer = await server.http.put("/api/radars/0/scene", json={"scene": "meshed"})
        assert answer.status_code == 200


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
        (
            "meshed",
            [("scene", ("m.toml", MESHED)), *[("files", (f"{n}.obj", TRIANGLE)) for n in range(65)]],
            "files: 65 files; at most 64",
        ),
    ],
)
async def test_a_bad_upload_is_refused_and_leaves_nothing(name: str, parts: Any, line: str) -> None:
    async with playing() as server:
        answer = await server.http.post("/api/scenes", data={"name": name}, files=parts)
        assert answer.status_code == 422 and answer.json()["detail"][0].startswith(line), answer.text
        assert "radar-scenes" not in answer.text  # the server's folders are nobody's business
        offers = (await server.http.get("/api/scenes")).json()
        assert all(entry["origin"] != "uploaded" for entry in offers)
