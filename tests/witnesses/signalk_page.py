"""mayara's web page as a witness of Signal K, in headless Chromium: its polar raster against the spokes that were sent.

The page is not of this project: MAYARA_GUI names its folder (web/gui of mayara-server, which speaks the Radar API 3.4.0).
"""

import base64
import json
import math
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from websockets.sync.client import connect

from tests.clients.chromium import Browser, Page
from tests.ports.signalk.protobuf import spokes

HEADING_DEG, HEIGHT, RANGE = 30.0, 15.0, 6000.0
POINTS = [
    (17.3, 1203.7),
    (61.9, 2840.2),
    (111.4, 4411.9),
    (203.2, 5302.4),
    (248.8, 1999.1),
    (291.1, 3607.7),
    (338.7, 2512.6),
]
PACE = "0.05"  # the page draws each message; by software on a busy machine it draws some 20 a second
PATIENCE_S = 300.0
SPOKES = "/signalk/v2/api/vessels/self/radars/sim-0/spokes"
DRAWN = 1500  # spokes: two revolutions, as the page clears what it drew before it knew the range
# Before the page knows that the radar transmits it discards spokes.
HOOK = """(() => { window.times = []; window.drawn = 0; const timer = setInterval(() => {
  const page = window.ppi; if (!page) return; clearInterval(timer); const draw = page.drawSpoke.bind(page);
  page.drawSpoke = (spoke) => {
    draw(spoke); if (page.powerMode === "transmit") times[spoke.angle] = Number(spoke.time), drawn++; }; }, 1); })();"""
RASTER = """(() => { let text = ""; const data = ppi.data;
  for (let at = 0; at < data.length; at += 8192) text += String.fromCharCode(...data.subarray(at, at + 8192));
  return JSON.stringify({data: btoa(text), times, azimuths: ppi.spokesPerRevolution}); })()"""


def scene() -> dict[str, Any]:
    """Points at odd places, of such cross-sections that no echo saturates the receiver; with noise no two scans are equal."""
    bodies = []
    for number, (bearing_deg, distance) in enumerate(POINTS):
        east, north = (distance * f(math.radians(bearing_deg)) for f in (math.sin, math.cos))
        power = round(18.0 + 40.0 * math.log10(distance / 5300.0), 1)
        bodies.append({"name": f"point {number}", "shape": "point", "rcs_dbsm": power, "position_m": [east, north, 6]})
    return {
        "name": "points", "origin": {"latitude_deg": 50.4, "longitude_deg": -1.3}, "environment": {"noise": True},
        "radar": {"range_max_m": RANGE, "height_m": HEIGHT}, "own_ship": {"heading_deg": HEADING_DEG}, "body": bodies,
    }  # fmt: skip


class Sent:
    """What a client of the spokes gets beside the page, by angle and time."""

    def __init__(self, host: str) -> None:
        self.spokes: dict[tuple[int, int], dict[str, Any]] = {}
        self._host, self._stop = host, threading.Event()
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self) -> None:
        with connect(f"ws://{self._host}{SPOKES}", max_size=None, compression=None) as socket:
            while not self._stop.is_set():
                for spoke in spokes(bytes(socket.recv(timeout=60))):  # type: ignore[arg-type]
                    self.spokes[spoke.get("angle", 0), spoke["time"]] = spoke

    def close(self) -> None:
        """Ends."""
        self._stop.set()
        self._thread.join()


def compared(page: Page, sent: Sent) -> str:
    """Compares the raster of the page with what was sent, and its echoes with the truth. Raises AssertionError."""
    known = json.loads(page.ask(RASTER))
    raster = np.frombuffer(base64.b64decode(known["data"]), np.uint8).reshape(known["azimuths"], -1)
    rows = [row for row in enumerate(known["times"]) if row in sent.spokes]
    for row in rows:
        own = np.frombuffer(sent.spokes[row]["data"], np.uint8)
        assert np.array_equal(raster[row[0]], np.pad(own, (0, raster.shape[1] - own.size))), row
    assert len(rows) > 0.9 * known["azimuths"], len(rows)
    spoke = sent.spokes[rows[0]]
    errors = [_error(raster, number, spoke["range"] / len(spoke["data"])) for number in range(len(POINTS))]
    assert max(abs(error) for pair in errors for error in pair) < 0.5, errors
    worst = [max(abs(pair[which]) for pair in errors) for which in (0, 1)]
    return (
        f"{len(rows)} of {known['azimuths']} rows have the bytes that were sent, and {len(POINTS)} echoes lie within "
        f"{worst[0]:.2f} of a spoke and {worst[1]:.2f} of a sample of the truth"
    )


def _error(raster: np.ndarray[Any, np.dtype[np.uint8]], number: int, step: float) -> tuple[float, float]:
    """How far the centre of an echo's power is from the truth, in spokes and samples."""
    bearing_deg, distance = POINTS[number]
    angle = (bearing_deg - HEADING_DEG) / 360.0 * len(raster)
    sample = math.hypot(distance, HEIGHT - 6.0) / step
    rows, columns = round(angle) + np.arange(-8, 9), int(sample) + np.arange(-8, 9)
    patch = raster[rows % len(raster)][:, columns]
    power = np.where(patch > 0, 10.0 ** (patch * 0.025), 0.0)  # 0.25 dB a level
    middle = (power.sum(axis=1) @ rows, power.sum(axis=0) @ (columns + 0.5))
    return float(middle[0] / power.sum() - angle), float(middle[1] / power.sum() - sample)


def judged(folder: Path, gui: Path) -> str:
    """Opens the page on a service, and compares. Raises AssertionError."""
    file = folder / "points.json"
    file.write_text(json.dumps(scene()))
    options = ["--port", "0", "--signalk", "--gui", str(gui), "--pace", PACE, "--fidelity", "fast"]
    command = [sys.executable, "-m", "radar_service", "serve", str(file), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        address = re.search(r"http://([\d.:]+)", service.stdout.readline())
        assert address is not None
        sent, browser = Sent(address[1]), Browser(folder / "profile")
        try:
            page = browser.open(f"http://{address[1]}/gui/viewer.html?id=sim-0&renderer=webgl", 520, 440, first=HOOK)
            until = time.monotonic() + PATIENCE_S
            while page.ask("window.drawn || 0") < DRAWN and time.monotonic() < until:
                time.sleep(5.0)
            page.look(folder / "mayara.png")
            return compared(page, sent)
        finally:
            browser.close()
            sent.close()
            service.terminate()
