"""A whole service, with the processes of its radars: uploads, swaps, kills, and an end without remains."""

import asyncio
import contextlib
import json
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import pytest

from clients.ppi.client import FeedClient
from tests.processes.test_fork_server import is_gone, until
from tests.scenes import ONE_TARGET, TWO_RADARS

ROOT = Path(__file__).parents[2]


def children(process: int) -> list[int]:
    """Processes that a process has started, and theirs."""
    direct: list[int] = []
    with contextlib.suppress(OSError):  # it ends meanwhile
        for thread in os.listdir(f"/proc/{process}/task"):
            with contextlib.suppress(OSError):
                direct += [int(n) for n in Path(f"/proc/{process}/task/{thread}/children").read_text().split()]
    return [n for child in direct for n in (child, *children(child))]


Service = tuple[subprocess.Popen[str], str]


@contextlib.contextmanager
def started(folder: Path) -> Iterator[Service]:
    """A service of one radar, which is killed at the end, and its address."""
    (folder / "one.json").write_text(json.dumps(ONE_TARGET))
    command = [
        sys.executable,
        "-m",
        "radar_service",
        "serve",
        str(folder / "one.json"),
        "--port",
        "0",
        "--truth",
        "--pace",
        "20",
    ]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield process, process.stdout.readline().split()[-1]
    process.kill()
    process.communicate()


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that tests share; nothing outlives it when it is killed."""
    with started(tmp_path_factory.mktemp("service")) as (process, url):
        yield process, url
        remains = children(process.pid)
        assert len(remains) >= 3  # what starts others, a world, and its spare
    until(lambda: all(is_gone(child) for child in remains))


def test_uploads_swaps_and_kills_and_an_end_without_remains(tmp_path: Path) -> None:
    """At the end a request still waits for its scene, and is answered."""
    with started(tmp_path) as (process, url), httpx.Client(base_url=url, timeout=30) as http:
        answer = http.post("api/scenes", json={"name": "mine", "scene": ONE_TARGET | {"name": "upload"}})
        assert answer.status_code == 201 and answer.json()["bodies"] == 1, answer.text
        assert http.put("api/radars/0/scene", json={"scene": "mine"}).json()["name"] == "upload"
        until(lambda: http.get("api/radars/0").json()["scene"]["name"] == "upload")
        assert http.get("api/radars/0/truth?t=1").json()["bodies"][0]["name"] == "p"
        assert http.get("api/radars/0/ppi.png?size=64").content.startswith(b"\x89PNG")
        until(lambda: len(children(process.pid)) == 3)  # the earlier world and the picture have ended
        helper, *worlds = children(process.pid)
        os.kill(worlds[0], signal.SIGKILL)
        until(lambda: http.get("api/health").json()["radars"][0]["restarts"] == 1)  # when what it had computed is sent
        wait_for_spokes(url)
        os.kill(helper, signal.SIGKILL)  # the process that starts others
        wait_for_spokes(url)
        assert http.patch("api/radars/0/controls", json={"rpm": 50}).status_code == 200  # a world by a new helper
        health = http.get("api/health").json()["radars"][0]
        assert health["fault"] is None and health["restarts"] == 1
        remains = children(process.pid)
        with ThreadPoolExecutor(1) as pool:
            swap = pool.submit(http.put, "api/radars/0/scene?job=mine", json={"scene": "harbour"})
            until(lambda: httpx.get(f"{url}api/jobs/mine").status_code == 200)
            process.terminate()
            assert process.wait(60) == 0
            assert (swap.result(20).status_code, swap.result().json()) == (409, {"detail": ["scene: the job was cancelled"]})
        until(lambda: all(is_gone(child) for child in remains))


def put(http: httpx.Client, scene: dict[str, Any]) -> Any:
    """What a service answers to a scene, when it is on the air."""
    answer = http.put(f"api/radars/{http.get('api/radars').json()[0]['id']}/scene", json={"scene": scene})
    assert answer.status_code == 200, answer.text
    until(lambda: {radar["scene"]["name"] for radar in http.get("api/radars").json()} == {scene["name"]})
    until(lambda: http.get("api/health/ready").json()["yes"])
    return answer.json()


def test_two_radars_of_one_world(service: Service) -> None:
    """They are listed by id, keep one time, and are given another scene together."""
    url = service[1]
    with httpx.Client(base_url=url, timeout=30) as http:
        put(http, TWO_RADARS)
        listed = http.get("api/radars").json()
        assert [(radar["id"], radar["name"], radar["feed"]) for radar in listed] == [
            ("bow", "radar bow", "/api/radars/bow/feed"), ("pier", "radar pier", "/api/radars/pier/feed"),
        ]  # fmt: skip
        hello, spoke = asyncio.run(first_spoke(f"{url}api/radars/pier"))
        assert hello["radar"]["id"] == "pier" and spoke.heading == pytest.approx(math.pi / 2, abs=1e-3)
        bodies = [http.get(f"api/radars/{radar}/truth?t=3").json()["bodies"] for radar in ("bow", "pier")]
        assert [[body["name"] for body in each] for each in bodies] == [["p"], ["tug", "p"]]
        assert http.patch("api/radars/pier/controls", json={"pace": {"state": "pause"}}).status_code == 200
        assert http.get("api/radars/bow/controls").json()["pace"]["state"] == "pause"
        other = TWO_RADARS | {"name": "again"}
        assert http.put("api/radars/pier/scene", json={"scene": other}).json()["name"] == "again"
        until(lambda: {radar["scene"]["name"] for radar in http.get("api/radars").json()} == {"again"})
        assert [radar["simulated_s"] for radar in http.get("api/health").json()["radars"]] == [0.0, 0.0]
        assert http.patch("api/radars/pier/controls", json={"pace": {"state": "run"}}).status_code == 200


def test_scenes_bring_one_to_three_radars_and_leave_no_process_behind(service: Service) -> None:
    """A radar has a process and a spare; one more starts them. What other radars had has ended, threads too."""
    process, url = service
    bow, pier = TWO_RADARS["radar"]
    scenes = {
        ids: ONE_TARGET
        | {
            "name": "".join(ids),
            "radar": [table | {"id": each} for each, table in zip(ids, (bow, pier, pier), strict=False)],
        }
        for ids in (("a",), ("a", "b"), ("b", "c", "d"))
    }
    with httpx.Client(base_url=url, timeout=60) as http:
        put(http, ONE_TARGET)
        until(lambda: len(children(process.pid)) == 3)
        threads = len(os.listdir(f"/proc/{process.pid}/task"))
        for ids in [*scenes, ("b", "c", "d"), ("a", "b")]:
            expected = ["0"] if len(ids) == 1 else list(ids)
            assert put(http, scenes[ids])["radars"] == expected == [radar["id"] for radar in http.get("api/radars").json()]
        assert http.get("api/radars/0").status_code == 404
        assert set(re.findall(r'radar_azimuths_total{radar="(.*?)"}', http.get("metrics").text)) == {"a", "b"}
        until(lambda: len(children(process.pid)) == 5)
        put(http, ONE_TARGET)
        until(lambda: len(children(process.pid)) == 3)
        until(lambda: len(os.listdir(f"/proc/{process.pid}/task")) <= threads + 8)  # a pool keeps up to its size


async def first_spoke(address: str) -> tuple[Any, Any]:
    async with FeedClient(address.replace("http://", "ws://")) as client:
        async for spoke in client.spokes():
            return client.hello, spoke
    raise AssertionError


def wait_for_spokes(url: str) -> None:
    """Returns when the number of spokes sent has grown by more than what may be on its way."""
    with httpx.Client(base_url=url, timeout=30) as http:
        start = http.get("api/health").json()["radars"][0]["spokes_sent"]
        until(lambda: http.get("api/health").json()["radars"][0]["spokes_sent"] >= start + 10)


def test_a_stop_while_the_first_scene_is_prepared(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "radar_service", "serve", "harbour", "--port", "0"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until(lambda: len(children(process.pid)) == 2)  # what starts others, and a world
    remains = children(process.pid)
    process.terminate()
    assert process.communicate(timeout=60) == ("", "") and process.returncode == 0
    until(lambda: all(is_gone(child) for child in remains))
