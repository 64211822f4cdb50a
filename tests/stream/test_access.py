"""Who may do what, decided before anything is read; and that no secret is told."""

import asyncio
import hmac
from collections.abc import Awaitable, Callable

import pytest

from radar_service.stream import access as access_module
from radar_service.stream import guard
from radar_service.stream.access import MAX_TICKETS, TICKET_SECONDS, Access, checked_token, is_loopback
from radar_service.stream.app import create_app
from radar_service.stream.pace import Pace
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from tests.stream.asgi import Closed, Server, running
from tests.stream.fake import FakeEngine, factory, scene

COMMAND, READ = "command-" * 3, "reading-" * 3
PAUSED = Settings(pace=Pace("pause"))
CHANGES = [
    ("PATCH", "/api/radars/0/controls", {"gain": 60}), ("PUT", "/api/radars/0/scene", {"scene": {"name": "x"}}),
    ("POST", "/api/scenes", {"name": "mine", "scene": {}}), ("DELETE", "/api/scenes/mine", None),
]  # fmt: skip
VIEWS = ["/api/radars", "/api/radars/0", "/api/radars/0/controls", "/api/scenes", "/api/health", "/api/radars/0/ppi.png",
         "/api/openapi.json"]  # fmt: skip


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


def play(test: Callable[[Server], Awaitable[None]], access: Access) -> None:
    async def body() -> None:
        only = Station("0", FakeEngine(scene()), factory(), settings=PAUSED)
        async with running(create_app([only], access=access)) as server:
            await test(server)

    asyncio.run(asyncio.wait_for(body(), 20))


@pytest.mark.parametrize(("method", "path", "body"), CHANGES)
def test_what_changes_something_needs_the_token(method: str, path: str, body: object) -> None:
    async def test(server: Server) -> None:
        for headers in ({}, bearer(READ), bearer(COMMAND[:-1]), bearer(COMMAND + "x"), {"authorization": COMMAND},
                        {"authorization": f"Basic {COMMAND}"}, bearer("")):  # fmt: skip
            answer = await server.http.request(method, path, json=body, headers=headers)
            assert answer.status_code == 401 and answer.headers["www-authenticate"] == "Bearer"
            assert answer.json()["detail"][0].startswith("token: needed to command")
        assert all(offer["origin"] != "uploaded" for offer in (await server.http.get("/api/scenes")).json())
        answer = await server.http.request(method, path, json=body, headers=bearer(COMMAND))
        assert answer.status_code in (200, 201, 404)

    play(test, Access(COMMAND))


def test_seeing_is_free_until_it_too_has_a_token() -> None:
    async def free(server: Server) -> None:
        for path in VIEWS:
            assert (await server.http.get(path)).status_code == 200
        assert (await (await server.feed()).receive())["type"] == "hello"

    async def guarded(server: Server) -> None:
        for path in VIEWS:
            assert (await server.http.get(path)).status_code == 401
            for token in (READ, COMMAND):
                assert (await server.http.get(path, headers=bearer(token))).status_code == 200
        assert (await server.http.get("/")).status_code == 200  # the page, which asks for it
        assert (await server.http.get("/api/health/alive")).json() == {"yes": True}
        assert (await server.http.get("/api/health/ready")).status_code == 200
        assert (await server.http.patch("/api/radars/0/controls", json={}, headers=bearer(READ))).status_code == 401

    play(free, Access(COMMAND))
    play(guarded, Access(COMMAND, READ))


def test_a_websocket_opens_by_header_or_by_a_ticket_that_works_once() -> None:
    async def test(server: Server) -> None:
        for query in ("", "?ticket=", "?ticket=guessed", f"?ticket={READ}", f"?token={READ}"):
            with pytest.raises(Closed):
                await server.feed(query)
        assert (await (await server.feed(authorization=f"Bearer {READ}")).receive())["type"] == "hello"
        assert (await server.http.post("/api/tickets")).status_code == 401
        ticket = (await server.http.post("/api/tickets", headers=bearer(READ))).json()["ticket"]
        assert (await (await server.feed(f"?ticket={ticket}")).receive())["type"] == "hello"
        with pytest.raises(Closed):
            await server.feed(f"?ticket={ticket}")

    play(test, Access(COMMAND, READ))


def test_lossless_holds_up_everybody_and_so_needs_the_token_to_command() -> None:
    async def test(server: Server) -> None:
        refused = await server.feed("?mode=lossless")
        assert "needs the token to command" in (await refused.receive())["reason"]
        with pytest.raises(Closed) as closed:
            await refused.receive()
        assert closed.value.code == 4403
        allowed = await server.feed("?mode=lossless", authorization=f"Bearer {COMMAND}")
        assert (await allowed.receive())["mode"] == "lossless"
        ticket = (await server.http.post("/api/tickets", headers=bearer(COMMAND))).json()["ticket"]
        assert (await (await server.feed(f"?mode=lossless&ticket={ticket}")).receive())["mode"] == "lossless"

    play(test, Access(COMMAND))


def test_a_ticket_lasts_only_so_long_and_their_number_is_bounded() -> None:
    access, now = Access(COMMAND, READ), 0.0
    kept, late = access.ticket("command", lambda: now), access.ticket("read", lambda: now)
    assert access.redeem(kept, lambda: TICKET_SECONDS) == "command"
    assert access.redeem(late, lambda: TICKET_SECONDS + 0.1) is None
    first = access.ticket("read", lambda: now)
    for _ in range(MAX_TICKETS):
        access.ticket("read", lambda: now)
    assert access.redeem(first, lambda: now) is None and len(access._tickets) == MAX_TICKETS
    access.ticket("read", lambda: TICKET_SECONDS * 2)
    assert len(access._tickets) == 1


def test_every_secret_is_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bytes] = []
    true_compare = hmac.compare_digest

    def compare(a: bytes, b: bytes) -> bool:
        seen.append(b)
        return true_compare(a, b)

    monkeypatch.setattr(access_module.hmac, "compare_digest", compare)
    for given in (COMMAND, READ, "neither"):
        seen.clear()
        Access(COMMAND, READ).rank(f"Bearer {given}")
        assert sorted(seen) == sorted([COMMAND.encode(), READ.encode()])


@pytest.mark.parametrize("bad", ["", "short", "x" * 15, "x" * 513, "with space " * 3, "tab\t" * 8, "ünïcödé" * 4])
def test_a_weak_token_is_refused_without_repeating_it(bad: str) -> None:
    with pytest.raises(ValueError, match="^token: ") as caught:
        checked_token(bad)
    assert not bad or bad not in str(caught.value)
    assert checked_token("x" * 16) == "x" * 16


@pytest.mark.parametrize(
    ("host", "passes"),
    [
        ("127.0.0.1:8000", True), ("localhost", True), ("LOCALHOST:8000", True), ("[::1]:8000", True), ("10.0.0.7", True),
        ("radar.lan", True), ("Radar.LAN:80", True), ("evil.example", False), ("127.0.0.1.evil.example:8000", False),
        ("localhost.evil.example", False), ("", False), ("radar.lan.evil.example", False),
    ],
)  # fmt: skip
def test_only_names_of_this_server_are_answered(host: str, passes: bool) -> None:
    async def test(server: Server) -> None:
        answer = await server.http.get("/api/radars", headers={"host": host})
        assert answer.status_code == (200 if passes else 421)
        if passes:
            await server.feed(host=host)
            return
        with pytest.raises(Closed):
            await server.feed(host=host, origin=f"http://{host}")

    play(test, Access(hosts=frozenset({"radar.lan"})))


@pytest.mark.parametrize(
    ("host", "only_here"),
    [("127.0.0.1", True), ("127.8.9.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("::", False),
     ("192.168.1.5", False), ("radar.lan", False), ("", False)],
)  # fmt: skip
def test_loopback_is_known(host: str, only_here: bool) -> None:
    assert is_loopback(host) is only_here


def test_no_secret_shows_in_a_representation_or_an_answer() -> None:
    async def test(server: Server) -> None:
        for path in (*VIEWS, "/", "/api/nothing"):
            answer = await server.http.get(path, headers=bearer(READ))
            assert COMMAND not in answer.text and READ not in answer.text

    play(test, Access(COMMAND, READ))


def test_a_body_that_stops_coming_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guard, "BODY_SECONDS", 0.01)
    heard = []

    async def app(scope: object, receive: Callable[[], Awaitable[dict[str, object]]], send: object) -> None:
        heard.append((await receive())["type"])
        heard.append((await receive())["type"])

    async def stalling() -> dict[str, object]:
        if not heard:
            return {"type": "http.request", "body": b"{", "more_body": True}
        await asyncio.Event().wait()
        return {}

    async def send(_: object) -> None: ...

    wall = guard.Guard(app, Access())  # type: ignore[arg-type]
    asyncio.run(wall({"type": "http", "method": "PUT", "path": "/", "headers": []}, stalling, send))  # type: ignore[arg-type]
    assert heard == ["http.request", "http.disconnect"]
