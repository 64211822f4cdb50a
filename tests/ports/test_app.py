"""The whole application: the page."""

from tests.ports.playing import playing


async def test_the_page_is_served() -> None:
    async with playing() as server:
        answer = await server.http.get("/")
        assert answer.status_code == 200 and "text/html" in answer.headers["content-type"]
        assert (await server.http.get("/../pyproject.toml")).status_code == 404
