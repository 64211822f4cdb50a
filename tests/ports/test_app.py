"""The whole application: the page."""

from tests.ports.asgi import Server
from tests.ports.playing import play


def test_the_page_is_served() -> None:
    async def test(server: Server) -> None:
        answer = await server.http.get("/")
        assert answer.status_code == 200 and "text/html" in answer.headers["content-type"]
        assert (await server.http.get("/../pyproject.toml")).status_code == 404

    play(test)
