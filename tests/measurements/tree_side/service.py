"""What a service sends: its feeds in several views, with commands, errors on purpose and truth, its REST, and its replays."""

import contextlib
import json
import re
import subprocess
import sys
import urllib.request
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from websockets.sync.client import connect

from tests.measurements.tree_side.kept import Kept
from tests.measurements.tree_side.messages import Messages
from tests.measurements.tree_side.worlds import two_radars

SPOKES = 360  # three scans
VIEWS = {
    "field": "encoding=c64",
    "video": "encoding=u8",
    "sector": "encoding=u8-log&bins=100&sector=30,200",
    "small": "encoding=f16&bins=64&compress=deflate",
}
SOURCES = {"sources": "encoding=f32&labels=1&powers=all"}
TRUTH = {"truth": "encoding=u8&bins=8&truth=1"}
SILENCE = 60.0  # s after which a feed is given up
STARTED = re.compile(r"http://([\d.]+:\d+)")


@contextlib.contextmanager
def served(*arguments: str, pace: str = "max") -> Iterator[tuple[str, int]]:
    """HOST:PORT of a service of this tree, and the number of its process."""
    with subprocess.Popen(
        [sys.executable, "-m", "radar_service", *arguments, "--port", "0", "--pace", pace],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        try:
            assert process.stdout is not None
            found = next(filter(None, map(STARTED.search, process.stdout)))
            yield found.group(1), process.pid
        finally:
            process.terminate()
            process.wait(30)


def request(address: str, path: str, method: str = "GET", body: object = None) -> Any:
    """The answer of REST as plain data."""
    data = None if body is None else json.dumps(body).encode()
    asked = urllib.request.Request(f"http://{address}{path}", data, {"content-type": "application/json"}, method=method)
    with urllib.request.urlopen(asked, timeout=60) as answer:
        return json.loads(answer.read())


def feeds(kept: Kept, name: str, address: str, radars: Sequence[str], views: dict[str, str], spokes: int) -> None:
    """Keeps what a client of each view of each radar receives from number 0 on."""
    received = {(radar, view): Messages() for radar in radars for view in views}
    with ThreadPoolExecutor(len(received)) as pool:
        ends = [pool.submit(_receive, address, key[0], views[key[1]], spokes, its) for key, its in received.items()]
    for end in ends:
        end.result()
    for (radar, view), messages in received.items():
        for part, data in messages.packed().items():
            kept.bytes(f"{name}/{radar}/{view}/{part}", data)


def _receive(address: str, radar: str, query: str, spokes: int, messages: Messages) -> None:
    url = f"ws://{address}/api/radars/{radar}/feed?mode=lossless&{query}"
    with connect(url, max_size=None, proxy=None) as socket:
        while messages.next < spokes:
            data = socket.recv(timeout=SILENCE)
            assert isinstance(data, bytes)
            messages.take(data)


def service(kept: Kept, folder: Path) -> None:
    """Two radars, without errors and with them; commands and controls come before the first spoke."""
    for errors in (False, True):
        name = f"service/{'errors' if errors else 'plain'}"
        scene = folder / f"{'errors' if errors else 'plain'}.json"
        scene.write_text(json.dumps(two_radars(errors)))
        views = VIEWS | SOURCES | TRUTH
        with served("serve", str(scene), "--truth", "--seed", "1", "--wait-for", str(len(views))) as (address, _):
            commanded(kept, name, address)
            feeds(kept, name, address, ("bow", "pier"), views, SPOKES)


def commanded(kept: Kept, name: str, address: str) -> None:
    """Commands and controls of a service that waits for its clients, and what it answers."""
    radars = "/api/radars"
    answers = {
        "controls": request(address, f"{radars}/bow/controls", "PATCH", {"gain": 60, "rain": 10, "interference_rejection": True}),
        "stretch": request(address, f"{radars}/pier/controls", "PATCH", {"echo_stretch": 1, "scan_correlation": True}),
        "own-ship": request(address, f"{radars}/bow/own-ship", "PATCH", {"course_deg": 70, "speed_kn": 11}),
        "ship": request(address, f"{radars}/pier/bodies/ship", "PATCH", {"course_deg": 20, "turn_rate_deg_s": 4}),
        "limits": request(address, f"{radars}/bow/bodies/buoy"),
        "errors": request(address, f"{radars}/bow/errors"),
        "scenes": request(address, "/api/scenes"),
    }  # fmt: skip
    kept.record(f"{name}/answers", answers)


def replayed(kept: Kept, recording: Path) -> None:
    """A recording, by the feed."""
    views = VIEWS | SOURCES
    with served("replay", str(recording), "--truth", "--wait-for", str(len(views))) as (address, _):
        radar = request(address, "/api/radars")[0]["id"]
        feeds(kept, "replay", address, (radar,), views, SPOKES)
