"""The main path of the page in Firefox: it loads, the picture moves, a control is changed."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.clients.fake_radar import FakeRadar, Served
from tests.clients.firefox import FIREFOX, Firefox
from tests.clients.screen import DRAWN, PIXELS, blobs, expected, off_by

FRAMES = 30  # looks, two frames each: four seconds at 15 Hz

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not FIREFOX.exists(), reason=f"{FIREFOX} is absent: install the Debian package firefox-esr"),
]


@pytest.fixture
def firefox(tmp_path: Path) -> Iterator[Firefox]:
    opened = Firefox(tmp_path)
    yield opened
    opened.close()


def test_main_path_in_firefox(radar: FakeRadar, served: Served, firefox: Firefox) -> None:
    firefox.open(f"{served.url}?rings=off&headline=off&sweep=off&afterglow=0")
    firefox.wait(DRAWN.format("one:720"))
    left, top, side = firefox.ask(
        "(({left, top, width}) => [left, top, width])(document.getElementById('scope').getBoundingClientRect())"
    )
    centre, radius = np.array([left + side / 2, top + side / 2]) - 0.5, side / 2 - 33

    def spots() -> np.ndarray:
        firefox.ask("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
        screen = firefox.look()
        screen[np.hypot(*(np.indices(screen.shape[:2]) - centre[::-1, None, None])) > 0.9 * radius] = 0
        return blobs(screen)[0]

    def shows(turn: float) -> bool:
        """Whether the screen shows the picture, a few frames after it was drawn: a busy compositor is behind the page."""
        at = expected(radar.picture, centre, radius, turn)
        looks = (spots() for _ in range(FRAMES))
        return any(seen.shape == at.shape and off_by(seen, at) < PIXELS for seen in looks)

    assert shows(0.0)
    radar.picture.video[:] = np.roll(radar.picture.video, 180, axis=0)  # a quarter turn
    radar.send(*(radar.spokes(first, 60) for first in range(720, 1440, 60)))
    firefox.wait(DRAWN.format("one:1440"))
    assert shows(-90.0)
    firefox.ask("gain.focus()")
    firefox.press("ArrowRight")
    firefox.wait("document.getElementById('gain-value').value === '51'")
    firefox.press("-")
    firefox.wait("document.getElementById('range').selectedOptions[0].textContent === '0.75 NM'")
    assert radar.patched == [{"gain": 51}, {"range_m": 1389}]
