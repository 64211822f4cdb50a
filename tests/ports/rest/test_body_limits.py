"""Bodies are bounded before they are read, and reading them silences nobody."""

import asyncio
from typing import Any

import pytest
from starlette.types import Message, Scope
from websockets.asyncio.client import connect

from radar_service.ports.rest.bodies import MAX_JSON_BYTES, SMALL
from radar_service.ports.rest.body_limits import BodyLimitMiddleware, max_body
from radar_service.ports.rest.scene_store import MAX_UPLOAD_BYTES
from tests.ports.http.loopback import Address, radar, works
from tests.ports.playing import playing
from tests.ports.serving import Turns, dialled

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
    """About `size` bytes, in pieces of 64 KiB."""
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
