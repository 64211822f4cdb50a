"""REST as a port: alone it serves all but the feed."""

import asyncio
import threading
from pathlib import Path
from typing import Any

import pytest

from radar_service.ports.app import create_app
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.processes.call import Progress
from radar_service.service.scene_request import SceneRequest
from tests.ports.asgi import Closed, running
from tests.ports.playing import playing, station
from tests.service.fake import FakeEngine, factory


async def test_alone_it_serves_all_but_the_feed(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('name = "mine"\n')
    port = RestPort([tmp_path])
    home = port.store.home
    async with running(create_app([station()], PortHost((port,)))) as server:
        assert home.is_dir()
        for path in ("/api/radars/0", "/api/health", "/metrics", "/docs"):
            assert (await server.http.get(path)).status_code == 200
        assert "mine" in {entry["name"] for entry in (await server.http.get("/api/scenes")).json()}
        assert '"kind"' in await (await server.open("/api/changes")).text()
        with pytest.raises((Closed, AssertionError)):
            await server.feed()
    assert not home.exists()


async def test_openapi_lists_every_answer_and_gives_examples() -> None:
    async with playing() as server:
        schema = (await server.http.get("/api/openapi.json")).json()
        expected = {
            ("/api/health", "get"): {"200", "503"},
            ("/api/health/alive", "get"): {"200"},
            ("/api/health/ready", "get"): {"200", "503"},
            ("/api/tickets", "post"): {"201"},
            ("/api/scenes", "get"): {"200"},
            ("/api/scenes", "post"): {"201", "400", "409", "413", "422", "503", "507"},
            ("/api/scenes/{name}", "delete"): {"204", "404", "409", "422"},
            ("/api/radars", "get"): {"200"},
            ("/api/radars/{radar}", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/radars/{radar}/scene", "put"): {"200", "400", "404", "409", "413", "422", "503", "507"},
            ("/api/radars/{radar}/truth", "get"): {"200", "403", "404", "422"},
            ("/api/radars/{radar}/ppi.png", "get"): {"200", "404", "422", "503"},
            ("/api/radars/{radar}/errors", "get"): {"200", "403", "404", "422"},
            ("/api/radars/{radar}/errors", "patch"): {"200", "400", "404", "413", "422"},
            ("/api/radars/{radar}/errors", "delete"): {"200", "404", "422"},
            ("/api/radars/{radar}/own-ship", "get"): {"200", "403", "404", "409", "422"},
            ("/api/radars/{radar}/own-ship", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/radars/{radar}/bodies/{name}", "get"): {"200", "403", "404", "409", "422"},
            ("/api/radars/{radar}/bodies/{name}", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/jobs", "get"): {"200"},
            ("/api/jobs/{job}", "get"): {"200", "404", "422"},
            ("/api/jobs/{job}", "delete"): {"204", "404", "422"},
        }
        described = {
            (path, method): set(about["responses"])
            for path, ways in schema["paths"].items()
            for method, about in ways.items()
        }
        assert described == {way: answers | {"401", "421"} for way, answers in expected.items()}

        def body(path: str, method: str) -> dict[str, Any]:
            return schema["paths"][path][method]["requestBody"]["content"]["application/json"]["schema"]

        change = body("/api/radars/{radar}/controls", "patch")["$ref"]
        assert schema["components"]["schemas"][change.rsplit("/", 1)[1]]["examples"]
        assert body("/api/radars/{radar}/scene", "put")["examples"]
        problem = schema["paths"]["/api/radars/{radar}/scene"]["put"]["responses"]["422"]["content"]["application/json"]
        assert problem["schema"]["$ref"].endswith("/Problem")


async def test_health_counts() -> None:
    async with playing() as server:
        feed = await server.feed()
        await server.step(7)
        await feed.spokes(7)
        answer = await server.http.get("/api/health")
        assert answer.status_code == 200 and answer.json()["status"] == "ok"
        radar = answer.json()["radars"][0]
        assert (radar["state"], radar["next"], radar["clients"], radar["views"]) == ("paused", 7, 1, 1)


PUT = "/api/radars/0/scene"
MANY = 12  # two run, eight wait


class Slow:
    """Makes engines, each when the test says so; a cancelled one ends as a killed process does."""

    def __init__(self) -> None:
        self.go, self.running = threading.Event(), threading.Semaphore(0)

    def __call__(self, order: SceneRequest, progress: Progress) -> FakeEngine:
        progress.stage("preparing and planning")
        ended = threading.Event()
        progress.ends_with(lambda: (ended.set(), self.go.set()))  # type: ignore[func-returns-value]
        self.running.release()
        assert self.go.wait(60)
        if ended.is_set():
            raise RuntimeError("its process has ended")
        return factory()(order, progress)

    async def begun(self) -> None:
        while not self.running.acquire(blocking=False):
            await asyncio.sleep(0.001)


@pytest.mark.parametrize(("method", "path"), [("PUT", PUT), ("POST", "/api/scenes")])
async def test_a_job_is_followed_and_cancelled_and_the_old_scene_goes_on(method: str, path: str) -> None:
    slow = Slow()
    async with playing(station(make=slow)) as server:
        body = {"scene": {"name": "x"}} | ({"name": "mine"} if method == "POST" else {})
        request = asyncio.create_task(server.http.request(method, f"{path}?job=my-job", json=body))
        await slow.begun()
        told = (await server.http.get("/api/jobs/my-job")).json()
        assert (told["state"], told["doing"]) == ("running", "preparing and planning") and told["seconds"] >= 0
        assert (await server.http.get("/api/jobs")).json()[0]["id"] == "my-job"
        assert (await server.http.request(method, f"{path}?job=my-job", json=body)).status_code == 409
        assert (await server.http.delete("/api/jobs/my-job")).status_code == 204
        answer = await request
        assert answer.status_code == 409 and "cancelled" in answer.json()["detail"][0]
        assert (await server.http.get("/api/jobs/my-job")).json()["state"] == "cancelled"
        assert (await server.http.get("/api/radars/0")).json()["scene"]["name"] == "test scene"


async def test_unknown_jobs_and_odd_names_are_refused() -> None:
    async with playing() as server:
        for method in ("GET", "DELETE"):
            assert (await server.http.request(method, "/api/jobs/none")).status_code == 404
        answer = await server.http.put(f"{PUT}?job=../x", json={"scene": {}})
        assert answer.status_code == 422 and (await server.http.get("/api/jobs")).json() == []


async def test_too_many_at_once_are_told_when_to_try_again_and_the_others_end() -> None:
    """Twelve uploads at once; the service answers other requests meanwhile."""
    slow = Slow()
    async with playing(station(make=slow)) as server:
        uploads = [
            asyncio.create_task(server.http.post("/api/scenes", json={"name": f"n{n}", "scene": {"name": "s"}}))
            for n in range(MANY)
        ]
        for _ in range(2):
            await slow.begun()
        while sum(upload.done() for upload in uploads) < MANY - 10:
            await asyncio.sleep(0.001)
        assert (await server.http.get("/api/scenes")).status_code == 200
        assert (await server.http.get("/api/health")).status_code == 200
        slow.go.set()
        answers = await asyncio.gather(*uploads)
        refused = [answer for answer in answers if answer.status_code == 503]
        assert len(refused) == MANY - 10 and all(int(answer.headers["retry-after"]) > 0 for answer in refused)
        assert sorted({answer.status_code for answer in answers}) == [201, 503]
