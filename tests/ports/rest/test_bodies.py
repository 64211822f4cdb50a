"""Bodies are bounded before they are read, here or in a process; in JSON each key stands once and values have their types."""

import asyncio
import errno
import json
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from starlette.types import Message, Scope
from websockets.asyncio.client import connect

from radar_service.ports.app import create_app
from radar_service.ports.rest.bodies import MAX_JSON_BYTES, SMALL, BodyLimitMiddleware, max_body, read_body
from radar_service.ports.rest.scene_store import MAX_UPLOAD_BYTES
from radar_service.ports.rest.schemas import SceneUpload
from tests.ports.playing import playing, station
from tests.ports.rest.test_command_routes import station as steerable
from tests.ports.serving import Address, Turns, dialled, radar, works

CASES = [
    (b'{"name": "a", "scene": {"name": "s"}}', 201, ""), (b'{"name": "a", "scene": 3}', 422, "scene: 3;"),
    (b"{", 400, "body: not JSON"), (b'{"name": "a", "scene": {}}', 422, "scene: it is empty; give it a name"),
    (b'{"name": "a", "scene": {"radar": {"azimuths": NaN}}}', 422, "radar.azimuths"),
]  # fmt: skip


@pytest.mark.parametrize(("size", "cases"), [(0, CASES), (SMALL + 1, CASES[:3])], ids=["here", "in a process"])
async def test_bodies_are_read_alike_here_and_in_a_process(size: int, cases: list[tuple[bytes, int, str]]) -> None:
    async with playing() as server:
        for body, status, line in cases:
            answer = await server.http.post(
                "/api/scenes", content=body.rjust(size), headers={"content-type": "application/json"}
            )
            assert answer.status_code == status, answer.text
            assert not line or answer.json()["detail"][0].startswith(line)
        kinds = [job["kind"] for job in (await server.http.get("/api/jobs")).json()]
        assert kinds.count("body") == len(cases) * (size > 0)


async def test_a_full_disk_is_an_answer_and_not_a_fault() -> None:
    """There is no room for the folder, for the body, and for the files of a form."""
    wheres, body = ("tempfile.mkdtemp", "pathlib.Path.open", "shutil.copyfileobj"), {"name": "a", "scene": {"name": "s"}}
    async with playing() as server:
        for where, number in product(wheres, (errno.ENOSPC, errno.EDQUOT)):

            def full(*_: object, number: int = number, **__: object) -> None:
                raise OSError(number, "No space left on device")

            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(where, full)
                form: dict[str, Any] = {"data": {"name": "a"}, "files": {"scene": ("m.toml", b"")}}
                answer = await server.http.post("/api/scenes", **(form if where.startswith("shutil") else {"json": body}))
            assert (answer.status_code, answer.json()["detail"]) == (
                507,
                ["body: the server's disk is full; try again later"],
            )
            assert (await server.http.post("/api/scenes", json=body)).status_code == 201


def test_the_scene_lies_beside_the_body(tmp_path: Path) -> None:
    (tmp_path / "body.json").write_text(json.dumps({"name": "a", "scene": {"name": "b"}}))
    fields, refusal = read_body(tmp_path / "body.json", SceneUpload)
    assert fields == {"name": "a", "scene": {}} and refusal is None
    assert json.loads((tmp_path / "scene.json").read_text()) == {"name": "b"}


FORM = "multipart/form-data; boundary=b"
PLACES = [
    ("POST", "/api/scenes", "application/json", MAX_JSON_BYTES), ("POST", "/api/scenes", FORM, MAX_UPLOAD_BYTES),
    ("PUT", "/api/radars/0/scene", "application/json", MAX_JSON_BYTES), ("PUT", "/api/radars/0/scene", FORM, MAX_JSON_BYTES),
    ("PATCH", "/api/radars/0/controls", "application/json", SMALL), ("PATCH", "/api/radars/0/controls", FORM, SMALL),
    ("POST", "/api/tickets", "application/json", SMALL), ("GET", "/api/scenes", FORM, SMALL),
    ("POST", "/api/scenes/x", FORM, SMALL), ("PUT", "/metrics", "", SMALL),
]  # fmt: skip
LONGEST_TURN = 0.2  # s of processor time: ten times what is needed, and a quarter of what the mildest attack took before


def scope(method: str, path: str, kind: str, length: str = "") -> Scope:
    headers = [(b"content-type", kind.encode())] + ([(b"content-length", length.encode())] if length else [])
    return {"type": "http", "method": method, "path": path, "headers": headers}


@pytest.mark.parametrize(("method", "path", "kind", "maximum"), PLACES)
def test_a_stated_length_is_refused_before_anything_is_read(method: str, path: str, kind: str, maximum: int) -> None:
    sent: list[Message] = []
    called: list[Scope] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        called.append(scope)

    async def receive() -> Message:
        raise AssertionError("the body was read")

    async def send(message: Message) -> None:
        sent.append(message)

    middleware = BodyLimitMiddleware(app)
    assert max_body(scope(method, path, kind)) == maximum
    asyncio.run(middleware(scope(method, path, kind, str(maximum)), receive, send))
    assert called and not sent
    for length in (str(maximum + 1), "9" * 5000):
        sent.clear()
        asyncio.run(middleware(scope(method, path, kind, length), receive, send))
        assert sent[0]["status"] == 413 and f"more than {maximum} bytes".encode() in sent[1]["body"]
    assert len(called) == 1


async def test_a_body_in_chunks_is_counted() -> None:
    async def body(kind: str, sent: list[bytes]) -> Any:
        if kind == FORM:
            yield PART
        while len(sent) < 500:
            sent.append(bytes(2**20))
            yield sent[-1]

    async with playing() as server:
        for method, path, kind, maximum in PLACES[:5]:
            sent: list[bytes] = []
            answer = await server.http.request(method, path, content=body(kind, sent), headers={"content-type": kind})
            assert answer.status_code == 413 and "body: more than" in answer.json()["detail"][0]
            assert len(sent) <= maximum // 2**20 + 1


HEAD = "{} {} HTTP/1.1\r\nhost: 127.0.0.1\r\ncontent-type: {}\r\n{}\r\n\r\n"
CHUNKED = "transfer-encoding: chunked"


def chunks(size: int) -> list[bytes]:
    """Chunks of one byte, 6 bytes each: 50,000 in 300 kB, more than asyncio reads at a time."""
    return [b"1\r\n \r\n" * 10_000] * (size // 60_000) + [b"0\r\n\r\n"]


def in_one(text: bytes, size: int) -> list[bytes]:
    return [text * (2**16 // len(text))] * (size // 2**16)


PART = b'--b\r\nContent-Disposition: form-data; name="scene"; filename="a.toml"\r\n\r\n'
BODIES: dict[str, tuple[str, str, str, list[bytes]]] = {
    "chunks of one byte": ("POST", "/api/scenes", "application/json", chunks(300_000)),
    "chunks of one byte, refused": ("POST", "/nowhere", "application/json", chunks(300_000)),
    "json of 11 MB": ("POST", "/api/scenes", "application/json", in_one(b"[" * 64, 11 * 2**20)),
    "json of 4 MB": ("PUT", "/api/radars/0/scene", "application/json", in_one(b'[{"a":1},', 2**22)),
    "a form of boundaries": ("POST", "/api/scenes", FORM, [PART, *in_one(b"\r\n--\r\n-b", 2**23)]),
    "a form of parts": ("POST", "/api/scenes", FORM, in_one(PART + b"\r\n", 2**21)),
    "a form of headers": ("POST", "/api/scenes", FORM, [b"--b\r\n", *in_one(b"a:b\r\n", 2**21)]),
}  # fmt: skip


def post(address: Address, name: str) -> bytes:
    """Sends the body while the server takes it; returns the beginning of the answer."""
    method, path, kind, pieces = BODIES[name]
    framing = CHUNKED if name.startswith("chunks") else f"content-length: {sum(map(len, pieces))}"
    with dialled(address) as connection:
        try:
            connection.sendall(HEAD.format(method, path, kind, framing).encode())
            for piece in pieces:
                connection.sendall(piece)
            return connection.recv(2**16)
        except OSError:  # the server has answered and closed
            return b""


def test_no_body_silences_the_feed() -> None:
    async def listen(address: Address) -> None:
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed", compression=None) as feed:
            await feed.recv()
            for name in BODIES:
                posting = asyncio.create_task(asyncio.to_thread(post, address, name))
                while not posting.done():
                    await feed.recv()
                assert (await posting)[:12] in (b"", *(f"HTTP/1.1 {code}".encode() for code in (400, 404, 405, 413, 422)))
            for _ in range(5):
                await feed.recv()

    with radar(turns=(turns := Turns())) as address:
        asyncio.run(asyncio.wait_for(listen(address), 60))
        assert works(address)
    assert 0.0 < turns.longest < LONGEST_TURN


Route = tuple[str, str]
WRONG: dict[str, tuple[object, ...]] = {
    "number": (True, "90", "1e3", [1]), "integer": (True, "2", 2.5), "boolean": (1, 0, "true", "on"), "string": (7, True),
}  # fmt: skip
JSON = {"content-type": "application/json"}
NUMBERED = {"radar": "0", "name": "buoy"}


def openapi() -> dict[str, Any]:
    return create_app([station()]).openapi()


def json_routes() -> list[Route]:
    """Method and path of each route that takes JSON."""
    return [
        (method.upper(), path.format(**NUMBERED))
        for path, methods in openapi()["paths"].items()
        for method, its in methods.items()
        if "application/json" in its.get("requestBody", {}).get("content", {})
    ]


def wrong_bodies() -> Iterator[tuple[str, str, object, str]]:
    """Method, path and a body with one value of a wrong type, and its key."""
    document = openapi()
    for path, methods in document["paths"].items():
        for method, its in methods.items():
            schema = its.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
            for keys, kinds in leaves(schema, document["components"]["schemas"]):
                for wrong in {repr(value): value for kind in kinds for value in WRONG[kind]}.values():
                    if not any(fits(wrong, kind) for kind in kinds):
                        yield method.upper(), path.format(**NUMBERED), nested(keys, wrong), keys[0]


def leaves(schema: Mapping[str, Any], named: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], set[str]]]:
    """The paths of keys to plain values, and their types."""
    choices = [resolved(choice, named) for choice in resolved(schema, named).get("anyOf", [schema])]
    if (kinds := {choice.get("type") for choice in choices} & WRONG.keys()) and not has_constants(choices):
        yield (), kinds
    for choice in choices:
        for key, value in choice.get("properties", {}).items():
            yield from (((key, *keys), kinds) for keys, kinds in leaves(value, named))


def resolved(schema: Mapping[str, Any], named: Mapping[str, Any]) -> Mapping[str, Any]:
    return named[schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema


def has_constants(choices: list[Mapping[str, Any]]) -> bool:
    return any("enum" in choice for choice in choices)


def fits(value: object, kind: str) -> bool:
    types: dict[str, tuple[type, ...]] = {"number": (int, float), "integer": (int,), "boolean": (bool,), "string": (str,)}
    return isinstance(value, types[kind]) and isinstance(value, bool) == (kind == "boolean")


def nested(keys: tuple[str, ...], value: object) -> object:
    return {keys[0]: nested(keys[1:], value)} if keys else value


async def test_a_value_of_another_type_is_refused_everywhere() -> None:
    bodies = list(wrong_bodies())
    assert {("PATCH", "/api/radars/0/own-ship"), ("PATCH", "/api/radars/0/controls"), ("PATCH", "/api/radars/0/errors")} <= {
        body[:2] for body in bodies
    }
    async with playing(steerable()) as server:
        for method, path, body, key in bodies:
            answer = await server.http.request(method, path, json=body)
            assert answer.status_code == 422, (path, body, answer.text)
            assert any(line.startswith(key) for line in answer.json()["detail"]), (path, body, answer.text)


async def test_a_position_is_two_numbers() -> None:
    async with playing(steerable()) as server:
        for position in ([True, 1], ["1", 1], "12"):
            answer = await server.http.patch("/api/radars/0/own-ship", json={"position_m": position})
            assert answer.status_code == 422 and answer.json()["detail"][0].startswith("position_m")


async def test_a_key_that_occurs_twice_is_refused_and_named_on_every_route() -> None:
    routes = json_routes()
    assert len(routes) >= 6
    async with playing(steerable()) as server:
        for method, path in routes:
            for body in ('{"scene": {"a": 1, "a": 2}}', '{"gain": 1, "gain": 2}'):
                key = "a" if "scene" in body else "gain"
                answer = await server.http.request(method, path, content=body, headers=JSON)
                assert answer.status_code == 422, (method, path, answer.text)
                assert answer.json() == {"detail": [f'body: the key "{key}" occurs twice in one table; remove one']}


async def test_a_number_that_is_not_finite_is_refused_and_named() -> None:
    places = [
        ("own-ship", '{"course_deg": X}', "course_deg"), ("bodies/buoy", '{"speed_kn": X}', "speed_kn"),
        ("own-ship", '{"position_m": [X, 0]}', "position_m"), ("controls", '{"gain": X}', "gain"),
        ("errors", '{"gyro": {"bias_deg": X}}', "gyro.bias_deg"),
    ]  # fmt: skip
    async with playing(steerable()) as server:
        for (path, body, key), number in product(places, ("NaN", "Infinity", "-Infinity", "1e999")):
            answer = await server.http.patch(f"/api/radars/0/{path}", content=body.replace("X", number), headers=JSON)
            assert answer.status_code == 422 and answer.json()["detail"][0].startswith(key), answer.text
