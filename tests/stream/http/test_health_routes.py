"""Health and probes."""

from tests.stream.asgi import Server
from tests.stream.http.playing import play


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
