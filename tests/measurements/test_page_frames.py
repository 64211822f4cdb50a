"""How smoothly the page draws 4096 azimuths of 1024 bins at 24 rpm, in headless Chromium; `pytest -m bench -s` prints it.

Without a GPU the drawing itself is done by the processor (SwiftShader), in a process beside the page's, which limits the
frames; the processor time of the page's main thread, which limits them where there is a GPU, is measured apart.
"""

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.clients.chromium import Browser, Page
from tests.clients.fake_radar import Air, FakeRadar, Picture, Served, fake_app

pytestmark = [pytest.mark.bench, pytest.mark.browser]

PERIOD = 60 / 24 / 4096  # s between spokes
BATCH = 25  # spokes: 15 ms
SECONDS = 6.0
WORK = 0.5 / 60  # s of processor time: half a frame at 60 Hz; measured 2.4 to 4.1 ms on two busy cores
RECORD = """new Promise((done) => {{
  const stamps = [];
  const next = (time) => {{
    stamps.push(time);
    if (time > stamps[0] + {}) done(stamps);
    else requestAnimationFrame(next);
  }};
  requestAnimationFrame(next);
}})"""


@pytest.fixture
def radar() -> Iterator[tuple[FakeRadar, str]]:
    """A radar on the air whose every tenth cell holds an echo, as a coast close by has."""
    air = Air()
    air.radar.picture = Picture(azimuths=4096, bins=1024, step=5.0, rim=False)
    rng = np.random.default_rng(1)
    video = air.radar.picture.video
    video[:] = rng.integers(40, 255, video.shape) * (rng.random(video.shape) < 0.1)
    served = Served(fake_app(air))
    yield air.radar, served.url
    served.close()


def play(radar: FakeRadar, stop: threading.Event) -> None:
    """Spokes in real time until told to stop."""
    began, number = time.monotonic(), radar.picture.azimuths
    while not stop.wait(max(0.0, began + (number - radar.picture.azimuths) * PERIOD - time.monotonic())):
        count = min(BATCH, radar.picture.azimuths - number % radar.picture.azimuths)
        radar.send(radar.spokes(number, count))
        number += count


def busy(page: Page) -> dict[str, float]:
    """Seconds of processor time of the page's main thread so far, by purpose."""
    return {one["name"]: float(one["value"]) for one in page.call("Performance.getMetrics")["metrics"]}


@pytest.mark.parametrize("side", [600, 1000])
@pytest.mark.parametrize("options", ["trails=0", "trails=60"])
def test_frames_of_a_fine_picture(radar: tuple[FakeRadar, str], tmp_path: Path, side: int, options: str) -> None:
    on_air, url = radar
    browser = Browser(tmp_path)
    page = browser.open(f"{url}?bins=1024&{options}", width=side + 320, height=side)
    page.call("Performance.enable", timeDomain="threadTicks")
    page.wait("document.getElementById('scope').dataset.drawn === 'one:4096'")
    stop = threading.Event()
    player = threading.Thread(target=play, args=(on_air, stop))
    player.start()
    try:
        page.ask(RECORD.format(2000))  # till it runs evenly
        before = busy(page)
        stamps = page.ask(RECORD.format(1000 * SECONDS))
        after = busy(page)
    finally:
        stop.set()
        player.join()
        page.close()
        browser.close()
    steps = np.diff(stamps)
    script, whole = ((after[name] - before[name]) / len(stamps) for name in ("ScriptDuration", "TaskDuration"))
    rate, median, late = 1000 / steps.mean(), np.median(steps), np.quantile(steps, 0.99)
    print(
        f"\n{side} px, {options}, load {os.getloadavg()[0]:.1f}: {rate:.0f} frames/s (median {median:.1f} ms, p99 {late:.0f} ms);"
        f" the main thread works {1000 * whole:.1f} ms a frame, {1000 * script:.1f} of it the page's code"
    )
    assert whole < WORK
