"""A whole service, with the processes of its radars: uploads, swaps, kills, and an end without remains."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.stream.processes.test_fork_server import is_gone, until

ROOT = Path(__file__).parents[3]
SCENE: dict[str, Any] = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [{"name": "p", "shape": "point", "position_m": [0, 300, 10], "rcs_dbsm": 10}],
}


def children(process: int) -> list[int]:
    """Processes that a process has started, and theirs."""
    direct: list[int] = []
    for listed in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            direct += [int(n) for n in listed.read_text().split()]
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
        while http.get("api/radars/0").json()["scene"]["name"] != "upload":
            pass
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
    assert process.wait(20) == 0
    until(lambda: all(is_gone(child) for child in remains))


def wait_for_spokes(url: str) -> None:
    """Returns when the number of spokes sent has grown by more than what may be on its way."""
    deadline = time.monotonic() + 20
    with httpx.Client(base_url=url, timeout=30) as http:
        start = http.get("api/health").json()["radars"][0]["spokes_sent"]
        while http.get("api/health").json()["radars"][0]["spokes_sent"] < start + 10:
            assert time.monotonic() < deadline


def test_nothing_outlives_a_killed_service(service: tuple[subprocess.Popen[str], str]) -> None:
    process, _ = service
    remains = children(process.pid)
    assert len(remains) == 3  # what starts others, a world, and its spare
    process.kill()
    process.wait(20)
    until(lambda: all(is_gone(child) for child in remains))
