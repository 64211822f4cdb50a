"""The page on screens of every shape, with colours of the user, and under the rules of axe-core."""

import os
from pathlib import Path

import numpy as np
import pytest

from radar_service.display.palettes import PALETTES
from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar
from tests.clients.screen import BROWSER, box, seen

pytestmark = BROWSER

AXE = Path(os.environ.get("AXE_CORE", "absent"))  # axe.min.js of axe-core; .ci/run fetches it
# 1280 x 800 at 200 %; a phone on its side, tablets upright and lying, a small phone.
SHAPES = [(640, 400), (667, 375), (768, 1024), (820, 1180), (1024, 768), (360, 640)]
SIZE = "(({{width, height}}) => [width, height])(document.getElementById('{}').getBoundingClientRect())"
INSIDE = """[...document.querySelectorAll('#panel, #scope, .corner, .corner *')].filter((one) => {
    const {left, top, right, bottom} = one.getBoundingClientRect();
    return left < 0 || top < 0 || right > innerWidth + 0.5 || bottom > innerHeight + 0.5;
}).map((one) => one.id)"""


def resize(page: Page, width: int, height: int) -> None:
    """Gives the page another screen, and waits for its layout."""
    page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
    page.ask("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


DRAWN_AT_ONCE = """new Promise((done) => {
  const overlay = document.getElementById('overlay');
  const look = () => overlay.getContext('2d').getImageData(0, 0, overlay.width, overlay.height).data.some((one) => one > 0);
  new ResizeObserver(() => overlay.width === 300 && done(look())).observe(scope);
  scope.style.width = '300px';
})"""


def test_picture_and_panel_have_room_on_every_shape_of_screen(radar: FakeRadar, opened: Opened) -> None:
    radar.origin = {"latitude_deg": 50.3, "longitude_deg": -101.4}
    page = opened()
    for width, height in SHAPES:
        resize(page, width, height)
        left, top, side = box(page)
        page.click(left + 0.6 * side, top + 0.7 * side)
        page.wait("document.getElementById('marker-position').textContent")
        diameter = 2 * page.ask("Math.min(scope.clientWidth, scope.clientHeight) / 2 - (scope.clientWidth > 500 ? 33 : 30)")
        assert diameter >= min(width, height) / 2, (width, height)
        assert min(page.ask(SIZE.format("panel"))) >= 200, (width, height)
        assert page.ask(INSIDE) == [], (width, height)
        scrolled = page.ask("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
        assert scrolled == [width, height]
        echoes = page.ask("[echoes.width, echoes.height]")
        assert echoes == [round(side), round(side)]
        assert np.count_nonzero(seen(page)[..., 0] > 200) > 100
    assert page.ask(DRAWN_AT_ONCE)  # a canvas that changes its size is empty until it is drawn


def colours(page: Page, script: str) -> list[str]:
    """Computed background colours."""
    shown = page.ask(f"({script}).map((one) => getComputedStyle(one).backgroundColor)")
    return [str(colour) for colour in shown]


def test_forced_colours_show_pressed_buttons_and_sliders(opened: Opened) -> None:
    page = opened("palette=night", width=1000, height=700)
    page.call("Emulation.setEmulatedMedia", features=[{"name": "forced-colors", "value": "active"}])
    pressed, other, panel = colours(page, "[transmit, pause, document.getElementById('panel')]")
    assert pressed != other
    left, top, right, bottom = page.ask(
        "(({left, top, right, bottom}) => [left, top, right, bottom])(gain.getBoundingClientRect())"
    )
    row = page.look()[round((top + bottom) / 2), round(left) : round(right)]
    kinds = {tuple(pixel.tolist()) for pixel in row}
    assert panel == "rgb(255, 255, 255)" or panel == "rgb(0, 0, 0)"
    assert len(kinds) >= 2 and tuple(int(part) for part in panel[4:-1].split(",")) not in {
        tuple(row[k].tolist()) for k in (len(row) // 4, len(row) // 2, 3 * len(row) // 4)
    }  # track and thumb stand out from the panel
    page.call("Emulation.setEmulatedMedia", features=[])


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is absent: AXE_CORE names no axe.min.js; .ci/run fetches it")
def test_axe_finds_no_violation_in_any_palette(radar: FakeRadar, opened: Opened) -> None:
    radar.gives_truth, radar.warnings = True, ["body[0]: open mesh"]
    radar.radars.append({"id": "1", "name": "aft radar"})
    page = opened("truth=on&radar=7", width=1280, height=800)
    radar.send(radar.truth(ferry={"range": 1000.0}))
    page.ask("document.querySelectorAll('details').forEach((one) => (one.open = true))")
    page.wait("document.querySelectorAll('#targets tbody tr').length === 1 && document.querySelector('.toast')")
    page.ask(f"{AXE.read_text(encoding='utf-8')}; 0")
    for palette in PALETTES:
        page.ask(f"palette.value = '{palette}', palette.dispatchEvent(new Event('change'))")
        found = page.ask(
            "axe.run().then(({violations}) => violations.map((one) => "
            "`${one.id}: ${one.help}: ${one.nodes.map((node) => node.html.slice(0, 120)).join(' | ')}`))"
        )
        assert found == [], palette
