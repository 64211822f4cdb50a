"""A feed while strangers attack the service: python -m tests.measurements.strangers [--attack 67] [--rest 20] [--runs 9].

100 clients follow the open sea at 288 spokes/s of 1 KiB. Runs without strangers take turns with runs in which strangers
flood with pings, post bodies of 60 MB, upload worlds of 4 and 5 million triangles, request pictures of 2048 pixels, and swap
the scene 200 times in all. Afterwards each child process is killed. The last lines name what is beyond its limit;
the status is then 1.

Loopback only. Service, clients and strangers are processes. Strangers run where nothing else does, leave a processor free, and
make what they send once, because in truth they are other machines. --strangers chooses among them, `planning` and `small` too.
"""

import argparse
import contextlib
import io
import json
import math
import os
import re
import selectors
import signal
import subprocess
import sys
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from functools import lru_cache
from statistics import median
from typing import Any

import httpx
import numpy as np
from PIL import Image

from radar_service.processes.limits import leave_processor_free, set_session_niceness
from radar_service.service.radio.preparation import KEPT_SECONDS
from tests.measurements.load import UPGRADE, Listener, Message
from tests.measurements.load_table import memory
from tests.ports.serving import dialled
from tests.ports.test_running import children

CLIENTS, SWAPS = 100, 200
QUERY = "encoding=u8&bins=1024"
USUAL = "pings,bodies,uploads,pictures,swaps"
WARM_UP = 60.0  # s until the history of the view is full
SETTLING = 3.0  # s after strangers have gone
LOWEST = 19  # niceness
KILL_SECONDS = 5.0  # that the feed is watched after a kill
KILLED = (1, 2, 1, 0)  # the world, its spare, the world that has none now, and the process that starts others
RADAR = {"bandwidth_hz": 10e6, "sample_rate_hz": 15e6, "range_max_m": 12000, "beamwidth_deg": 2.0, "height_m": 22}
SMALL = {"name": "small", "radar": RADAR,
         "body": [{"name": "p", "shape": "point", "position_m": [0, 3000, 10], "rcs_dbsm": 30}]}  # fmt: skip
LIMITS = {"unannounced": 0.0, "ratio of p99": 3.0, "silence_s": 0.5, "growth": 1.2, "tasks": 0.0, "threads": 0.0,
          "descriptors": 0.0, "processes": 0.0, "after_kill_s": 2.0}  # fmt: skip


class Follower(Listener):
    """A client through epochs. It reads (number of the epoch, simulated time [s]) of each message."""

    def __init__(self, address: tuple[str, int], query: str) -> None:
        super().__init__(address, query)
        self.epochs = 0

    def _counted(self, message: Message) -> Any:
        if message.type == "hello":
            self.next, self.epochs = -1, self.epochs + 1
        return [(self.epochs, time) for time in super()._counted(message)]


class Crowd:
    """All clients, and what they have received since `begin`."""

    def __init__(self, address: tuple[str, int], clients: int) -> None:
        self.followers = [Follower(address, QUERY) for _ in range(clients)]
        self.begin()

    def begin(self) -> None:
        """Starts a run."""
        self._late: dict[int, list[float]] = defaultdict(list)
        self._last = dict.fromkeys(self.followers, time.monotonic())
        self._silence = 0.0
        self._before = self._totals()

    def read(self, follower: Follower) -> None:
        """Reads what has come for a client."""
        heard: Any = follower.read()
        now = time.monotonic()
        for epoch, simulated in heard:
            self._late[epoch].append(now - simulated)
            self._silence, self._last[follower] = max(self._silence, now - self._last[follower]), now

    def result(self) -> dict[str, float]:
        """Returns the figures of the run. A message is late against the best of its epoch."""
        now = time.monotonic()
        late = [1000.0 * (np.array(some) - min(some)) for some in self._late.values()] or [np.zeros(1)]
        spokes, lost, holes = (int(n) for n in self._totals() - self._before)
        silence = max(self._silence, *(now - last for last in self._last.values()))
        p50, p99 = np.percentile(np.concatenate(late), (50, 99))
        return {"p50_ms": round(p50, 1), "p99_ms": round(p99, 1), "silence_s": round(silence, 3), "spokes": spokes,
                "lost": lost, "unannounced": holes}  # fmt: skip

    def _totals(self) -> Any:
        return np.sum([(f.spokes, f.lost, f.holes) for f in self.followers], axis=0)


def follow(host: str, port: int, clients: int) -> None:
    """Is the life of the clients: each line of input ends a run, prints its figures and begins another."""
    crowd = Crowd((host, port), clients)
    with selectors.DefaultSelector() as poll:
        for follower in crowd.followers:
            poll.register(follower.socket, selectors.EVENT_READ, follower)
        poll.register(sys.stdin, selectors.EVENT_READ)
        while True:
            for key, _ in poll.select():
                if key.data:
                    crowd.read(key.data)
                elif not sys.stdin.readline():
                    return
                else:
                    print(json.dumps(crowd.result()), flush=True)
                    crowd.begin()


def moving_boxes(count: int) -> dict[str, Any]:
    """A scene of so many boxes of steel under way."""
    boxes = [
        {"name": f"box {k}", "shape": "box", "length_m": 20, "width_m": 6, "height_m": 6, "material": "steel",
         "position_m": [100.0 * (k % 20) - 1000, 500 + 100.0 * (k // 20), 3], "course_deg": 7 * k % 360, "speed_kn": 10}
        for k in range(count)
    ]  # fmt: skip
    return {"name": f"{count} boxes", "radar": RADAR, "body": boxes}


@lru_cache
def world(triangles: float) -> dict[str, Any]:
    """The form of an upload: a height map with so many triangles."""
    side = round((triangles / 2) ** 0.5) + 1
    wave = np.sin(np.arange(side) / 50.0)
    picture = Image.fromarray((30_000 + 20_000 * np.outer(wave, wave)).astype(np.uint16))
    picture.save(content := io.BytesIO(), "PNG")
    land = {"name": "land", "shape": None, "heightmap": "land.png", "low_m": 1, "high_m": 90, "extent_m": [4000, 4000],
            "position_m": [6000, 0, 0], "material": "rock"}  # fmt: skip
    scene = SMALL | {"body": [{key: value for key, value in land.items() if value is not None}]}
    return {"data": {"name": "world"}, "files": [("scene", ("world.json", json.dumps(scene))),
                                                 ("files", ("land.png", content.getvalue()))]}  # fmt: skip


@lru_cache
def big_body(size: int) -> bytes:
    """JSON of so many bytes."""
    return b'{"name": "x", "scene": [' + b"[]," * (size // 3)


class Strangers:
    """Threads that attack a service until `stop`. answers: counts them by kind."""

    def __init__(self, address: tuple[str, int], swaps: int, seconds: float) -> None:
        self._address, self._seconds, self._between = address, seconds, seconds / swaps
        self._stopped, self._began = threading.Event(), time.monotonic()
        self.answers: Counter[str] = Counter()

    def attack(self, kinds: list[str]) -> None:
        """Attacks for the given time; each kind has threads of its own."""
        threads = [threading.Thread(target=self._again, args=(kind,)) for kind in kinds for _ in range(AT_ONCE.get(kind, 1))]
        for thread in threads:
            thread.start()
        self._stopped.wait(self._seconds)
        self._stopped.set()
        self._cancel()
        for thread in threads:
            thread.join()

    def _cancel(self) -> None:
        """Ends what would take until long after the run."""
        with httpx.Client(base_url=f"http://{self._address[0]}:{self._address[1]}/api", timeout=60) as http:
            for job in http.get("jobs").json():
                if job["state"] in ("waiting", "running"):
                    http.delete(f"jobs/{job['id']}")

    def _again(self, kind: str) -> None:
        turns = 0
        with httpx.Client(base_url=f"http://{self._address[0]}:{self._address[1]}/api", timeout=120) as http:
            while not self._stopped.is_set():
                try:
                    answer = getattr(self, f"_{kind}")(http, turns)
                except (OSError, httpx.TransportError):  # the service has answered and closed
                    answer = "closed"
                self.answers[f"{kind} {answer}"] += 1
                turns += 1

    def _pings(self, http: httpx.Client, turn: int) -> str:
        self._stopped.wait(0.1)
        with dialled(self._address) as connection:
            connection.sendall(UPGRADE.format(query="encoding=u8", host=self._address[0]).encode())
            while True:
                connection.sendall(b"\x89\x80abcd" * 10_000)

    def _bodies(self, http: httpx.Client, turn: int) -> int:
        body = big_body((60, 8, 11)[turn % 3] * 10**6)
        if turn % 3 == 2:
            return http.put("radars/0/scene", content=body, headers={"content-type": "application/json"}).status_code
        return http.post("scenes", content=body, headers={"content-type": "application/json"}).status_code

    def _uploads(self, http: httpx.Client, turn: int) -> int:
        return http.post("scenes", **world((5e6, 3.9e6)[turn % 2])).status_code

    def _pictures(self, http: httpx.Client, turn: int) -> int:
        return http.get("radars/0/ppi.png", params={"size": 2048 - turn % 64}).status_code

    def _swaps(self, http: httpx.Client, turn: int) -> int:
        self._stopped.wait(max(0.0, self._began + turn * self._between - time.monotonic()))
        return http.put("radars/0/scene", json={"scene": "open-sea" if turn % 2 else SMALL}).status_code

    def _planning(self, http: httpx.Client, turn: int) -> int:
        return http.post("scenes", json={"name": "boxes", "scene": moving_boxes(300)}).status_code

    def _small(self, http: httpx.Client, turn: int) -> int:
        return http.post("scenes", json={"name": f"small {threading.get_native_id()}", "scene": SMALL}).status_code


AT_ONCE = {"pictures": 8, "small": 5, "pings": 2}


@contextlib.contextmanager
def process(*arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """A process of Python with pipes, until it is no longer needed."""
    with subprocess.Popen(
        [sys.executable, "-m", *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as started:
        try:
            yield started
        finally:
            started.terminate()


class Bench:
    """A service, its clients, and the figures of all runs."""

    def __init__(self, service: "subprocess.Popen[str]", crowd: "subprocess.Popen[str]", http: httpx.Client) -> None:
        self.service, self.crowd, self.http = service, crowd, http

    def run(self, during: Callable[[], object]) -> dict[str, Any]:
        """Returns what clients received while something happened."""
        self._line()
        during()
        return self._line()

    def state(self, settling: float = SETTLING) -> dict[str, float]:
        """Returns what the service has when no job has run for `settling` [s]."""
        while any(job["state"] in ("waiting", "running") for job in self.http.get("/api/jobs").json()):
            time.sleep(0.1)
        time.sleep(settling)
        base = f"/proc/{self.service.pid}"
        tasks = re.search(r"^radar_tasks (\S+)", self.http.get("/metrics").text, re.MULTILINE)
        assert tasks
        return {"tasks": float(tasks[1]), "resident": memory(self.service.pid), "threads": len(os.listdir(f"{base}/task")),
                "descriptors": len(os.listdir(f"{base}/fd")), "processes": len(children(self.service.pid))}  # fmt: skip

    def kill(self, process: int) -> dict[str, Any]:
        """Returns what clients received while a process of the service was killed."""

        def during() -> None:
            os.kill(process, signal.SIGKILL)
            time.sleep(KILL_SECONDS)

        return self.run(during)

    def _line(self) -> dict[str, Any]:
        assert self.crowd.stdin and self.crowd.stdout
        self.crowd.stdin.write("\n")
        self.crowd.stdin.flush()
        return dict(json.loads(self.crowd.stdout.readline()))


def bench(options: argparse.Namespace) -> list[str]:
    """Prints all figures; returns what is beyond its limit."""
    scene = ("radar_service", "serve", "open-sea", "--port", "0", "--connections", "1000")
    with process(*scene) as service:
        assert service.stdout
        host, _, port = service.stdout.readline().split("http://")[1].strip(" /\n").partition(":")
        following = ("tests.measurements.strangers", "follow", host, port, str(options.clients))
        with process(*following) as crowd, httpx.Client(base_url=f"http://{host}:{port}", timeout=60) as http:
            return _verdict(Bench(service, crowd, http), options, (host, port))


def _verdict(made: Bench, options: argparse.Namespace, address: tuple[str, str]) -> list[str]:
    swaps = math.ceil(SWAPS / options.runs)
    command = ("attack", *address, str(options.attack), str(swaps), options.strangers)
    quiet, attacked, states = [], [], []
    time.sleep(WARM_UP)
    for number in range(options.runs):
        quiet.append(made.run(lambda: time.sleep(options.rest)))
        print(f"{number} without: {quiet[-1]}", flush=True)
        answers: list[str] = []
        attacked.append(made.run(lambda: answers.append(_attacked(command))))  # noqa: B023
        is_compared = number in (0, options.runs - 1)
        states.append(made.state(KEPT_SECONDS + SETTLING if is_compared else SETTLING))
        print(f"{number} with:    {attacked[-1]} {answers[0].strip()} {states[-1]}", flush=True)
    kills = [made.kill(children(made.service.pid)[number]) for number in KILLED]
    print(f"kills: {kills}; load average {os.getloadavg()[0]:.1f}")
    first, last = states[0], states[-1]
    return _beyond({
        "unannounced": sum(run["unannounced"] for run in [*quiet, *attacked, *kills]),
        "ratio of p99": median(run["p99_ms"] for run in attacked) / median(run["p99_ms"] for run in quiet),
        "silence_s": max(run["silence_s"] for run in attacked), "growth": last["resident"] / first["resident"],
        "after_kill_s": max(run["silence_s"] for run in kills),
    } | {name: last[name] - first[name] for name in ("tasks", "threads", "descriptors", "processes")})  # fmt: skip


def _beyond(figures: dict[str, float]) -> list[str]:
    print(json.dumps({name: round(value, 3) for name, value in figures.items()}))
    return [f"{name}: {value:g}, more than {LIMITS[name]:g}" for name, value in figures.items() if value > LIMITS[name]]


def _attacked(command: tuple[str, ...]) -> str:
    """Lets strangers attack; returns their answers."""
    attack = [sys.executable, "-m", "tests.measurements.strangers", *command]
    return subprocess.run(attack, stdout=subprocess.PIPE, text=True, check=True, start_new_session=True).stdout


def attack(host: str, port: str, seconds: str, swaps: str, kinds: str) -> None:
    """Is the life of the strangers; prints their answers."""
    os.nice(LOWEST)
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    leave_processor_free()
    set_session_niceness(LOWEST)
    strangers = Strangers((host, int(port)), int(swaps), float(seconds))
    strangers.attack(kinds.split(","))
    print(json.dumps(dict(sorted(strangers.answers.items()))))


def main(arguments: list[str]) -> int:
    """Returns 1 where something is beyond its limit."""
    if arguments[:1] == ["follow"]:
        follow(arguments[1], int(arguments[2]), int(arguments[3]))
        return 0
    if arguments[:1] == ["attack"]:
        attack(*arguments[1:])
        return 0
    parser = argparse.ArgumentParser(prog="python -m tests.measurements.strangers", description=__doc__)
    parser.add_argument("--attack", type=float, default=67.0, help="seconds of a run with strangers (default 67)")
    parser.add_argument("--rest", type=float, default=20.0, help="seconds of a run without (default 20)")
    parser.add_argument("--runs", type=int, default=9, help="of each kind (default 9)")
    parser.add_argument("--clients", type=int, default=CLIENTS, help=f"default {CLIENTS}")
    parser.add_argument("--strangers", default=USUAL, help=f"default {USUAL}")
    beyond = bench(parser.parse_args(arguments))
    print(*beyond, sep="\n")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
