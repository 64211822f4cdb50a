"""Bodies of uploads: forms and JSON, good and bad."""

from itertools import product

from radar_service.ports.rest.bodies import SMALL
from tests.ports.playing import playing
from tests.ports.rest.test_scene_routes import MESHED, TRIANGLE


async def test_what_is_not_json_is_refused() -> None:
    headers, routes = {"content-type": "application/json"}, ("PATCH radars/0/controls", "PUT radars/0/scene", "POST scenes")
    async with playing() as server:
        for route, body in product(routes, ("{", "[" * 100_000, "\x00", '{"scene": ' + '{"a":' * 50_000)):
            method, path = route.split()
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
