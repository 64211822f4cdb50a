"""The page in a real browser, against a radar whose picture is known: what stands where, and what it does in trouble."""

from itertools import product

import numpy as np
import pytest
from scipy import ndimage

from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar, Picture
from tests.clients.screen import BARE, BROWSER, DRAWN, PIXELS, TARGETS, box, echoes, expected, measure, off_by, seen

pytestmark = BROWSER


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("renderer", "orientation", "heading_deg"),
    list(product(("webgl", "canvas"), ("north-up", "head-up"), (0.0, 70.0))),
)
def test_targets_are_at_their_bearings_and_ranges(
    radar: FakeRadar, opened: Opened, renderer: str, orientation: str, heading_deg: float
) -> None:
    radar.heading_deg = heading_deg
    page = opened(f"{BARE}&renderer={renderer}&orientation={orientation}")
    page.wait("!document.getElementById('echoes').hidden")
    centre, radius, spots = measure(seen(page))
    assert page.text("#renderer-text") == {"webgl": "WebGL2", "canvas": "2D canvas"}[renderer]
    up_deg = heading_deg if orientation == "head-up" else 0.0
    assert radius > 250  # of a screen 700 pixels high: a smaller picture would hide errors
    assert off_by(spots, expected(radar.picture, centre, radius, up_deg)) < PIXELS


def test_draws_on_a_2d_canvas_without_webgl2(radar: FakeRadar, opened: Opened) -> None:
    without = """const given = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
          return kind === 'webgl2' ? null : given.call(this, kind, ...rest);
        };"""
    page = opened(BARE, first=without)
    assert page.text("#renderer-text") == "2D canvas"
    centre, radius, spots = measure(seen(page))
    assert off_by(spots, expected(radar.picture, centre, radius, 0.0)) < PIXELS


AFTER = """window.seen = new Promise((done) => document.getElementById('echoes').addEventListener(
  'webglcontext{}', () => requestAnimationFrame(() => requestAnimationFrame(done)), {{once: true}}))"""


def test_picture_returns_after_the_gpu_was_lost(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.ask("window.gpu = document.getElementById('echoes').getContext('webgl2').getExtension('WEBGL_lose_context')")
    page.ask(f"{AFTER.format('lost')}, gpu.loseContext(), seen")
    page.ask(f"{AFTER.format('restored')}, gpu.restoreContext(), seen")
    centre, radius, spots = measure(seen(page))
    assert off_by(spots, expected(radar.picture, centre, radius, 0.0)) < PIXELS


@pytest.mark.sample(2)
@pytest.mark.parametrize("renderer", ["webgl", "canvas"])
@pytest.mark.parametrize("heading_deg", [0.0, 180.0])
def test_an_echo_across_north_is_whole(radar: FakeRadar, opened: Opened, renderer: str, heading_deg: float) -> None:
    radar.heading_deg, radar.picture = heading_deg, Picture()
    radar.picture.spot(0.0, 1000.0, halfwidth_deg=6.0)
    page = opened(f"{BARE}&renderer={renderer}&orientation=head-up")
    screen = seen(page)
    centre, radius, spots = measure(screen)
    assert spots.shape == (1, 2)
    assert abs(spots[0, 0] - centre[0]) < PIXELS
    half = 1000 / radar.picture.range * radius * np.sin(np.deg2rad(5))  # of the 6 degrees: the ends are rounded
    across = slice(round(centre[0] - half), round(centre[0] + half) + 1)
    assert echoes(screen)[round(spots[0, 1]), across].all()
    assert (spots[0, 1] < centre[1]) == (heading_deg == 0)


@pytest.mark.parametrize("renderer", ["webgl", "canvas"])
def test_a_target_of_one_cell_shows_when_cells_are_finer_than_pixels(
    radar: FakeRadar, opened: Opened, renderer: str
) -> None:
    radar.picture = Picture(bins=2048, step=1.0)
    ranges = range(200, 1900, 100)
    for distance in ranges:
        radar.picture.spot(90.0, distance + 0.5, halfwidth_deg=8.0, cells=1)
    page = opened(f"{BARE}&renderer={renderer}")
    screen = seen(page)
    centre, radius, _ = measure(screen)
    line = echoes(screen)[round(centre[1]), round(centre[0]) :]
    _, count = ndimage.label(line[: int(radius * 0.96)])
    assert count == len(ranges)


def test_more_azimuths_than_rows_share_them(radar: FakeRadar, opened: Opened) -> None:
    radar.picture = Picture(azimuths=8280, bins=128, step=16.0)
    for bearing_deg, distance in TARGETS:
        radar.picture.spot(bearing_deg, distance, cells=3)
    page = opened(BARE, drawn="one:8280")
    centre, radius, spots = measure(seen(page))
    assert off_by(spots, expected(radar.picture, centre, radius, 0.0)) < PIXELS


def brightness(page: Page, picture: Picture, bearing_deg: float) -> float:
    """Red of the ring's pixels about a bearing, north up."""
    left, top, side = box(page)
    screen, half = seen(page), side / 2
    x, y = left + half, top + half
    bearing = np.deg2rad(bearing_deg)
    along = np.arange(half * 0.8, half)
    line = screen[np.rint(y - along * np.cos(bearing)).astype(int), np.rint(x + along * np.sin(bearing)).astype(int)]
    return float(line[line[:, 0] - line[:, 2] > 20][:, 0].max())  # pixels at the ring's edges are dimmer


@pytest.mark.parametrize("renderer", ["webgl", "canvas"])
def test_afterglow_fades_older_echoes(radar: FakeRadar, opened: Opened, renderer: str) -> None:
    page = opened(f"{BARE.replace('afterglow=0', 'afterglow=1')}&renderer={renderer}")
    fresh, old = brightness(page, radar.picture, 352.0), brightness(page, radar.picture, 8.0)
    # Red is 4 on the bare scope and 255 in the strongest echo; the half-life is one scan. Fade and colour are whole numbers
    # of 1/255, and a pixel at the rim spans half a row.
    assert fresh == pytest.approx(4 + 251 * 2 ** -(8 / 360), abs=2)
    assert old == pytest.approx(4 + 251 * 2 ** -(352 / 360), abs=2)


def test_cursor_reads_range_and_bearing_and_a_click_sets_ebl_and_vrm(radar: FakeRadar, opened: Opened) -> None:
    radar.heading_deg = 70.0
    page = opened(f"{BARE}&unit=m")
    centre, radius, _ = measure(seen(page))
    x, y = np.rint(expected(radar.picture, centre, radius, 0.0)[1])
    page.click(x, y)
    reach = float(page.text("#cursor-range").removesuffix(" m"))
    bearing, relative = (float(figure.split("°")[0]) for figure in page.text("#cursor-bearing").split("  "))
    east, north = x - (centre[0] + 0.5), centre[1] + 0.5 - y  # a pixel's number is that of its upper left corner
    error = 1.0  # pixels: the ring's edges, half a pixel each
    assert reach == pytest.approx(np.hypot(east, north) / radius * radar.picture.range, rel=2 * error / radius)
    assert bearing == pytest.approx(np.rad2deg(np.arctan2(east, north)), abs=np.rad2deg(error / np.hypot(east, north)))
    assert relative == pytest.approx(bearing - 70, abs=0.11)  # each is rounded to a tenth
    assert page.text("#marker-bearing") == page.text("#cursor-bearing")


def test_controls_are_patched_and_refusals_shown(radar: FakeRadar, opened: Opened) -> None:
    opened.refusal = "422"
    page = opened(f"{BARE}&unit=m")
    page.wait("document.getElementById('scene').options.length === 2")
    page.ask("gain.value = 63, gain.dispatchEvent(new Event('input'))")
    page.wait("document.querySelector('#gain-value').value === '63'")
    page.ask("document.getElementById('scan_correlation').click(); 1")
    page.wait("document.getElementById('scan_correlation').ariaPressed === 'true'")
    page.press("-")
    page.wait("document.getElementById('range').value === '1500'")
    page.press("p")
    page.wait("document.getElementById('pause').ariaPressed === 'true'")
    page.wait("document.getElementById('banner').textContent === 'Paused'")
    page.ask("rpm.value = 13, rpm.dispatchEvent(new Event('change'))")
    page.wait("document.getElementById('alerts').textContent.includes('unlucky')")
    page.wait("document.getElementById('rpm').value === '24'")  # what was refused is taken back
    assert page.text("#pause") == "Pause"  # one label: the state is in aria-pressed
    page.ask("scene.value = 'other', document.getElementById('load-scene').click()")
    page.wait("!document.getElementById('load-scene').disabled")
    assert radar.scene == "other"
    assert radar.patched == [
        {"gain": 63},
        {"scan_correlation": True},
        {"range_m": 1500},
        {"pace": {"state": "pause"}},
        {"rpm": 13},
    ]


def test_new_epoch_replaces_the_picture(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    radar.epoch, radar.scene, radar.warnings = "two", "other scene", ["body[0]: open mesh"]
    radar.picture = Picture(azimuths=360, bins=256, step=16.0)
    radar.picture.spot(200.0, 3000.0)
    radar.send(radar.hello(), radar.spokes(0, 360))
    page.wait("document.getElementById('scene-name').textContent === 'other scene'")
    page.wait(DRAWN.format("two:360"))
    centre, radius, spots = measure(seen(page))
    bearing, distance = np.deg2rad(200.0), 3000.0 // 16 * 16 + 8
    position = centre + distance / 4096 * radius * np.array([[np.sin(bearing), -np.cos(bearing)]])
    assert off_by(spots, position) < PIXELS
    assert page.text("#lost-text") == "0"
    assert page.text("#warnings summary") == "1 warning"


def test_the_page_counts_on_with_the_next_spoke_and_anew_after_a_restart(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    lost = {"type": "gap", "epoch": "one", "first": 720, "count": 40, "reason": "slow"}
    radar.send(lost, radar.spokes(760, 20), radar.spokes(800, 40))
    page.wait("document.getElementById('lost-text').textContent === '60 (20 unannounced)'")
    page.ask("import('./toast.js').then(({toast}) => void toast('rpm: 13 is refused', {isAlert: true}))")
    page.ask("document.getElementById('scene-answer').textContent = 'old.toml is refused'")
    radar.next = 840
    radar.drop()  # and the same service answers again
    page.wait(DRAWN.format("one:1560"))
    assert radar.joined[-1]["since"] == "one:840" and page.text("#connection") == "Connected"
    assert page.text("#lost-text") == "60 (20 unannounced)" and page.text("#alerts p") == "rpm: 13 is refused"
    radar.epoch, radar.next = "two", 0
    radar.drop()
    page.wait(DRAWN.format("two:720"))
    page.wait("document.getElementById('lost-text').textContent === '0'")
    assert page.text("#alerts") == page.text("#scene-answer") == ""


def test_every_control_has_a_name_and_a_tooltip_and_takes_the_focus(radar: FakeRadar, opened: Opened) -> None:
    radar.radars.append({"id": "1", "name": "aft radar"})
    page = opened(BARE)
    page.wait("document.getElementById('gain') !== null")
    without_tooltip = page.ask(  # of its own, or of its row
        """[...document.querySelectorAll('#panel :is(button, select, input)')]
             .filter((control) => !control.closest('[title]:not([title=""])')).map((control) => control.id)"""
    )
    assert without_tooltip == []
    nameless = page.ask(
        """[...document.querySelectorAll('button, select, input, [tabindex="0"]')]
             .filter((one) => !one.getAttribute('aria-label') && !one.labels?.[0]?.textContent.trim())
             .filter((one) => !one.textContent.trim()).map((one) => one.id)"""
    )
    assert nameless == []
    reached = set()
    for _ in range(60):
        page.press("Tab")
        reached.add(page.ask("document.activeElement.id"))
    usable = page.ask(
        """[...document.querySelectorAll('button, select, input')]
             .filter((one) => one.offsetHeight && !one.disabled).map((one) => one.id)"""
    )
    assert set(usable) - reached == set()
