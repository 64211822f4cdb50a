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
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from clients.ppi.client import FeedClient
from tests.processes.test_fork_server import is_gone, until
from tests.scenes import TWO_RADARS

ROOT = Path(__file__).parents[2]
SCENE: dict[str, Any] = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [{"name": "p", "shape": "point", "position_m": [0, 300, 10], "rcs_dbsm": 10}],
}


def children(process: int) -> list[int]:
    """Processes that a process has started, and theirs."""
    direct: list[int] = []
    with contextlib.suppress(OSError):  # it ends meanwhile
        for thread in os.listdir(f"/proc/{process}/task"):
            with contextlib.suppress(OSError):
                direct += [int(n) for n in Path(f"/proc/{process}/task/{thread}/children").read_text().split()]
    return [n for child in direct for n in (child, *children(child))]


@pytest.fixture
def service(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    (tmp_path / "one.json").write_text(json.dumps(SCENE))
    command = [sys.executable, "-m", "radar_service", "serve", str(tmp_path / "one.json"), "--port", "0", "--truth"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield process, process.stdout.readline().split()[-1]
    process.kill()
    process.communicate()


def test_uploads_swaps_and_kills_and_an_end_without_remains(service: tuple[subprocess.Popen[str], str]) -> None:
    process, url = service
    with httpx.Client(base_url=url, timeout=30) as http:
        answer = http.post("api/scenes", json={"name": "mine", "scene": SCENE | {"name": "upload"}})
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
    process.terminate()
    assert process.wait(60) == 0
    until(lambda: all(is_gone(child) for child in remains))


def test_two_radars_of_one_world(tmp_path: Path) -> None:
    """They are listed by id, keep one time, and are given another scene together."""
    (tmp_path / "two.json").write_text(json.dumps(TWO_RADARS))
    command = [sys.executable, "-m", "radar_service", "serve", str(tmp_path / "two.json"), "--port", "0", "--truth"]
    process = subprocess.Popen([*command, "--pace", "max"], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        url = process.stdout.readline().split()[-1]
        with httpx.Client(base_url=url, timeout=30) as http:
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
    finally:
        process.terminate()
        process.communicate(timeout=60)


def test_scenes_bring_one_to_three_radars_and_leave_no_process_behind(
    service: tuple[subprocess.Popen[str], str], tmp_path: Path
) -> None:
    """A radar has a process and a spare; one more starts them. What other radars had has ended, threads too."""
    process, url = service
    bow, pier = TWO_RADARS["radar"]
    scenes = {
        ids: SCENE
        | {
            "name": "".join(ids),
            "radar": [table | {"id": each} for each, table in zip(ids, (bow, pier, pier), strict=False)],
        }
        for ids in (("a",), ("a", "b"), ("b", "c", "d"))
    }
    with httpx.Client(base_url=url, timeout=60) as http:
        until(lambda: len(children(process.pid)) == 3)
        threads = len(os.listdir(f"/proc/{process.pid}/task"))
        here = "0"
        for ids in [*scenes, ("b", "c", "d"), ("a", "b")]:
            answer = http.put(f"api/radars/{here}/scene", json={"scene": scenes[ids]})
            assert answer.status_code == 200, answer.text
            expected = ["0"] if len(ids) == 1 else list(ids)
            assert answer.json()["radars"] == expected == [radar["id"] for radar in http.get("api/radars").json()]
            until(lambda: http.get("api/health/ready").json()["yes"])
            here = expected[-1]
        assert http.get("api/radars/0").status_code == 404
        assert set(re.findall(r'radar_azimuths_total{radar="(.*?)"}', http.get("metrics").text)) == {"a", "b"}
        until(lambda: len(children(process.pid)) == 5)
        http.put("api/radars/a/scene", json={"scene": SCENE})
        until(lambda: len(children(process.pid)) == 3)
        until(lambda: len(os.listdir(f"/proc/{process.pid}/task")) <= threads + 8)  # a pool keeps up to its size


async def first_spoke(address: str) -> tuple[Any, Any]:
    """The hello of a feed, and a spoke of it."""
    async with FeedClient(address.replace("http://", "ws://")) as client:
        async for spoke in client.spokes():
            return client.hello, spoke
    raise AssertionError


def wait_for_spokes(url: str) -> None:
    """Returns when the number of spokes sent has grown by more than what may be on its way."""
    with httpx.Client(base_url=url, timeout=30) as http:
        start = http.get("api/health").json()["radars"][0]["spokes_sent"]
        until(lambda: http.get("api/health").json()["radars"][0]["spokes_sent"] >= start + 10)


def test_nothing_outlives_a_killed_service(service: tuple[subprocess.Popen[str], str]) -> None:
    process, _ = service
    until(lambda: len(children(process.pid)) == 3)  # what starts others, a world, and its spare
    remains = children(process.pid)
    process.kill()
    process.wait(60)
    until(lambda: all(is_gone(child) for child in remains))


def test_a_stop_answers_the_request_that_waits_for_a_scene(service: tuple[subprocess.Popen[str], str]) -> None:
    process, url = service
    remains = children(process.pid)
    answers = list[httpx.Response]()

    def swap() -> None:
        with httpx.Client(base_url=url, timeout=30) as http:
            answers.append(http.put("api/radars/0/scene?job=mine", json={"scene": "harbour"}))

    swapping = threading.Thread(target=swap)
    swapping.start()
    with httpx.Client(base_url=url, timeout=30) as http:
        until(lambda: http.get("api/jobs/mine").status_code == 200)
    process.terminate()
    assert process.wait(60) == 0
    swapping.join(20)
    assert (answers[0].status_code, answers[0].json()["detail"]) == (409, ["scene: the job was cancelled"])
    until(lambda: all(is_gone(child) for child in remains))


def test_a_stop_while_the_first_scene_is_prepared(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "radar_service", "serve", "harbour", "--port", "0"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until(lambda: len(children(process.pid)) == 2)  # what starts others, and a world
    remains = children(process.pid)
    process.terminate()
    assert process.communicate(timeout=60) == ("", "") and process.returncode == 0
    until(lambda: all(is_gone(child) for child in remains))
