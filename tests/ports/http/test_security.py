"""Who may do what is decided before anything is read, and no answer holds a secret."""

import logging

import pytest

from radar_service.service.access import Access
from tests.ports.asgi import Closed
from tests.ports.playing import playing

COMMAND, READ = "command-" * 3, "reading-" * 3


CHANGES = [
    ("PATCH", "/api/radars/0/controls", {"gain": 60}), ("PUT", "/api/radars/0/scene", {"scene": {"name": "x"}}),
    ("POST", "/api/scenes", {"name": "mine", "scene": {"name": "s"}}), ("DELETE", "/api/scenes/mine", None),
    ("PATCH", "/api/radars/0/errors", {}), ("DELETE", "/api/radars/0/errors", None),
]  # fmt: skip


VIEWS = ["/api/radars", "/api/radars/0", "/api/radars/0/controls", "/api/scenes", "/api/health", "/api/openapi.json"]


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


async def test_what_changes_something_needs_the_token() -> None:
    async with playing(access=Access(COMMAND)) as server:
        for method, path, body in CHANGES:
            for headers in ({}, bearer(READ), bearer(COMMAND[:-1]), bearer(COMMAND + "x"), {"authorization": COMMAND},
                            {"authorization": f"Basic {COMMAND}"}, bearer("")):  # fmt: skip
                answer = await server.http.request(method, path, json=body, headers=headers)
                assert answer.status_code == 401 and answer.headers["www-authenticate"] == "Bearer"
                assert answer.json()["detail"][0].startswith("token: needed to command")
        assert all(entry["origin"] != "uploaded" for entry in (await server.http.get("/api/scenes")).json())
        for method, path, body in CHANGES:
            answer = await server.http.request(method, path, json=body, headers=bearer(COMMAND))
            assert answer.status_code in (200, 201, 204)


async def test_seeing_is_free_until_it_too_has_a_token() -> None:
    async with playing(access=Access(COMMAND)) as server:
        for path in VIEWS:
            assert (await server.http.get(path)).status_code == 200
        assert (await (await server.feed()).receive())["type"] == "hello"
    async with playing(access=Access(COMMAND, READ)) as server:
        assert (await server.http.get("/api/radars/0/ppi.png")).status_code == 401
        for path in VIEWS:
            assert (await server.http.get(path)).status_code == 401
            for token in (READ, COMMAND):
                assert (await server.http.get(path, headers=bearer(token))).status_code == 200
        assert (await server.http.get("/")).status_code == 200  # the page, which asks for it
        assert (await server.http.get("/api/health/alive")).json() == {"yes": True}
        assert (await server.http.get("/api/health/ready")).status_code == 200
        assert (await server.http.patch("/api/radars/0/controls", json={}, headers=bearer(READ))).status_code == 401


async def test_a_websocket_opens_by_header_or_by_a_ticket_that_works_once() -> None:
    async with playing(access=Access(COMMAND, READ)) as server:
        for query in ("", "?ticket=", "?ticket=guessed", f"?ticket={READ}", f"?token={READ}"):
            with pytest.raises(Closed):
                await server.feed(query)
        assert (await (await server.feed(authorization=f"Bearer {READ}")).receive())["type"] == "hello"
        assert (await server.http.post("/api/tickets")).status_code == 401
        ticket = (await server.http.post("/api/tickets", headers=bearer(READ))).json()["ticket"]
        assert (await (await server.feed(f"?ticket={ticket}")).receive())["type"] == "hello"
        with pytest.raises(Closed):
            await server.feed(f"?ticket={ticket}")


async def test_lossless_holds_up_everybody_and_so_needs_the_token_to_command() -> None:
    async with playing(access=Access(COMMAND)) as server:
        refused = await server.feed("?mode=lossless")
        assert "needs the token to command" in (await refused.receive())["reason"]
        with pytest.raises(Closed) as closed:
            await refused.receive()
        assert closed.value.code == 4403
        allowed = await server.feed("?mode=lossless", authorization=f"Bearer {COMMAND}")
        assert (await allowed.receive())["mode"] == "lossless"
        ticket = (await server.http.post("/api/tickets", headers=bearer(COMMAND))).json()["ticket"]
        assert (await (await server.feed(f"?mode=lossless&ticket={ticket}")).receive())["mode"] == "lossless"


async def test_only_names_of_this_server_are_answered() -> None:
    own = ("127.0.0.1:8000", "localhost", "LOCALHOST:8000", "[::1]:8000", "10.0.0.7", "radar.lan", "Radar.LAN:80")
    others = ("evil.example", "127.0.0.1.evil.example:8000", "localhost.evil.example", "", "radar.lan.evil.example")
    async with playing(access=Access(hosts=frozenset({"radar.lan"}))) as server:
        for host in own:
            assert (await server.http.get("/api/radars", headers={"host": host})).status_code == 200, host
            await server.feed(host=host)
        for host in others:
            assert (await server.http.get("/api/radars", headers={"host": host})).status_code == 421, host
            with pytest.raises(Closed):
                await server.feed(host=host, origin=f"http://{host}")


async def test_no_secret_shows_in_a_representation_an_answer_or_a_log(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG), caplog.at_level(logging.DEBUG, "radar_service"):
        async with playing(access=Access(COMMAND, READ)) as server:
            for path in (*VIEWS, "/", "/api/nothing"):
                for token in (READ, READ + "x"):
                    answer = await server.http.get(path, headers=bearer(token))
                    assert COMMAND not in answer.text and READ not in answer.text
    assert "refused" in caplog.text and COMMAND not in caplog.text and READ not in caplog.text


async def test_a_page_of_another_site_may_neither_command_nor_listen() -> None:
    async with playing() as server:
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
        with pytest.raises(Closed, match="403"):
            await server.feed(**elsewhere)
        assert (await (await server.feed(**here)).receive())["type"] == "hello"


async def test_every_answer_carries_the_security_headers() -> None:
    async with playing() as server:
        for path in ("/api/health", "/api/radars/9", "/nowhere"):
            headers = (await server.http.get(path)).headers
            assert headers["content-security-policy"].startswith("default-src 'self'")
            assert headers["x-content-type-options"] == "nosniff"
