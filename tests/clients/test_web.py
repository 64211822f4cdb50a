"""The page in a real browser, against a radar whose picture is known: what stands where, and what it does in trouble."""

import json
import subprocess
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

import scenes
from tests.clients.chromium import CHROMIUM, Browser, Page
from tests.clients.fake_radar import Air, FakeRadar, Picture, Served, fake_app

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not CHROMIUM.exists(), reason=f"{CHROMIUM} is absent: install the Debian package chromium"),
]

TARGETS = ((30.0, 900.0), (120.0, 1500.0), (250.0, 600.0))  # degrees from north, m; no two alike, none on a symmetry
BARE = "rings=off&headline=off&sweep=off&afterglow=0"  # echoes alone, at full strength
DRAWN = "document.getElementById('scope').dataset.drawn === '{}'"  # epoch and next sequence number
# A blob's centroid errs by half a pixel, so does each edge of the ring that gives centre and scale, whose outermost
# pixel the frame of the scope may hide.
PIXELS = 1.5


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def air() -> Air:
    return Air()


@pytest.fixture(scope="module")
def served(air: Air) -> Iterator[Served]:
    running = Served(fake_app(air))
    yield running
    running.close()


@pytest.fixture
def radar(air: Air) -> FakeRadar:
    air.radar = FakeRadar()
    for bearing_deg, distance in TARGETS:
        air.radar.picture.spot(bearing_deg, distance)
    return air.radar


@pytest.fixture(scope="module")
def modules(browser: Browser, served: Served) -> Iterator[Page]:
    """A page whose modules can be imported."""
    page = browser.open(served.url)
    page.wait(DRAWN.format("one:720"))
    yield page
    page.close()


class Opened:
    """Pages of this test; each must have run without an error."""

    def __init__(self, browser: Browser, url: str) -> None:
        self._browser, self._url, self._pages = browser, url, list[Page]()
        self.refusal = "nothing"  # in the text of the one failure that a test means to see

    def __call__(self, query: str = "", drawn: str = "one:720", **size: Any) -> Page:
        page = self._browser.open(f"{self._url}?{query}", **size)
        self._pages.append(page)
        page.wait(DRAWN.format(drawn))
        return page

    def close(self) -> list[str]:
        faults = [fault for page in self._pages for fault in page.faults() if self.refusal not in fault]
        for page in self._pages:
            page.ask("localStorage.clear()")
            page.close()
        return faults


@pytest.fixture
def opened(browser: Browser, served: Served, radar: FakeRadar) -> Iterator[Opened]:
    pages = Opened(browser, served.url)
    yield pages
    assert pages.close() == []


def box(page: Page) -> tuple[float, float, float]:
    """Left and top edge of the scope and its side, in pixels."""
    x, y, side = page.ask("(({x, y, width}) => [x, y, width])(document.getElementById('scope').getBoundingClientRect())")
    return x, y, side


def seen(page: Page) -> NDArray[np.int16]:
    """The screen (height, width, 3), black outside the scope."""
    x, y, side = box(page)
    inside = slice(int(np.ceil(y)), int(y + side)), slice(int(np.ceil(x)), int(x + side))
    screen = page.look()
    scope = np.zeros_like(screen)
    scope[inside] = screen[inside]
    return scope


def echoes(screen: NDArray[np.int16]) -> NDArray[np.bool_]:
    """Pixels of a strong echo in the dusk palette: bright and yellow, which no furniture is."""
    inside: NDArray[np.bool_] = (screen[..., 0] > 150) & (screen[..., 0] - screen[..., 2] > 40)
    return inside


def measure(screen: NDArray[np.int16]) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Centre (x, y) and radius of the picture by its full ring, and centroids (n, 2) of the spots inside, all in pixels."""
    labels, count = ndimage.label(ndimage.binary_closing(echoes(screen)), np.ones((3, 3)))
    boxes = ndimage.find_objects(labels)
    ring = max(range(count), key=lambda i: boxes[i][0].stop - boxes[i][0].start)
    rows, columns = boxes[ring]
    centre = np.array([columns.start + columns.stop - 1, rows.start + rows.stop - 1]) / 2
    radius = (rows.stop - rows.start + columns.stop - columns.start) / 4
    spots = [ndimage.center_of_mass(labels == i + 1)[::-1] for i in range(count) if i != ring]
    return centre, radius, np.array(spots)


def expected(picture: Picture, centre: NDArray[np.float64], radius: float, up_deg: float) -> NDArray[np.float64]:
    """Where TARGETS (n, 2) belong, written out again: clockwise from the top of the screen, y downward."""
    bearing, distance = np.deg2rad(np.array(TARGETS)[:, 0] - up_deg), np.array(TARGETS)[:, 1]
    cell = (np.floor(distance / picture.step) + 0.5) * picture.step
    return centre + (cell / picture.range * radius)[:, None] * np.stack([np.sin(bearing), -np.cos(bearing)], axis=-1)


def off_by(found: NDArray[np.float64], wanted: NDArray[np.float64]) -> float:
    """The greatest distance from a wanted place to the nearest spot [pixels]; as many spots as places."""
    assert found.shape == wanted.shape
    return float(np.linalg.norm(found[:, None] - wanted, axis=-1).min(axis=0).max())


@pytest.mark.parametrize(
    ("renderer", "orientation", "heading_deg"),
    list(product(("webgl", "canvas"), ("north-up", "head-up"), (0.0, 70.0))),
)
def test_targets_stand_where_they_belong(
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


@pytest.fixture
def orientation(tmp_path: Path, heading_deg: float) -> Iterator[str]:
    """The address of the real service with the scene `orientation`, own ship turned to heading_deg."""
    text = (Path(scenes.__file__).parent / "orientation.toml").read_text()
    assert text.count("heading_deg = 0\n") == 1
    scene = tmp_path / "orientation.toml"
    scene.write_text(text.replace("heading_deg = 0\n", f"heading_deg = {heading_deg}\n"))
    command = [sys.executable, "-m", "radar_service", "serve", str(scene), "--port", "0", "--pace", "max"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        try:
            yield service.stdout.readline().split("open ")[1].strip()
        finally:
            service.terminate()


def strong_spots(page: Page) -> NDArray[np.float64]:
    """Centroids (n, 2) of the strong echoes, pixels right of and below own ship, the nearest first."""
    screen, (left, top, side) = seen(page), box(page)
    yellow = screen[..., 0] - screen[..., 2]  # no furniture has any
    labels, count = ndimage.label(yellow > 0.6 * yellow.max())  # the scene's three are equally strong, sidelobes faint
    places = np.array(ndimage.center_of_mass(labels > 0, labels, range(1, count + 1)))[:, ::-1] + 0.5
    spots: NDArray[np.float64] = places - (left + side / 2, top + side / 2)
    return spots[np.argsort(np.hypot(*spots.T))]


@pytest.mark.parametrize("heading_deg", [0.0, 70.0])
def test_scene_orientation_is_the_right_way_round(browser: Browser, orientation: str, heading_deg: float) -> None:
    for mode, up_deg in (("north-up", 0.0), ("head-up", heading_deg)):
        page = browser.open(f"{orientation}?{BARE}&orientation={mode}")
        page.wait("Number(document.getElementById('scope').dataset.drawn.split(':')[1]) > 1440")  # a whole scan
        spots, faults = strong_spots(page), page.faults()
        page.close()
        distance = np.hypot(*spots.T)
        bearing_deg = (np.rad2deg(np.arctan2(spots[:, 0], -spots[:, 1])) + up_deg) % 360
        assert faults == []
        assert bearing_deg == pytest.approx([30, 120, 250], abs=3.9 / 4)  # a quarter of the beamwidth
        assert distance / distance.max() == pytest.approx([1 / 3, 2 / 3, 1], abs=PIXELS / distance.max())


def test_draws_on_a_2d_canvas_where_there_is_no_webgl2(radar: FakeRadar, opened: Opened) -> None:
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


def test_picture_comes_back_after_the_gpu_was_lost(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.ask("window.gpu = document.getElementById('echoes').getContext('webgl2').getExtension('WEBGL_lose_context')")
    page.ask(f"{AFTER.format('lost')}, gpu.loseContext(), seen")
    page.ask(f"{AFTER.format('restored')}, gpu.restoreContext(), seen")
    centre, radius, spots = measure(seen(page))
    assert off_by(spots, expected(radar.picture, centre, radius, 0.0)) < PIXELS


def test_own_ship_is_the_centre_of_the_scope(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    centre, _, _ = measure(seen(page))
    x, y, side = box(page)
    assert np.abs(centre + 0.5 - (x + side / 2, y + side / 2)).max() < 1.0  # a pixel: the ring's edges are whole pixels


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
def test_afterglow_fades_what_is_older(radar: FakeRadar, opened: Opened, renderer: str) -> None:
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


def test_cursor_by_keyboard(opened: Opened) -> None:
    page = opened(f"{BARE}&unit=m")
    page.ask("document.getElementById('scope').focus()")
    for key in ["ArrowRight"] * 3 + ["ArrowUp"] * 2 + ["Enter"]:
        page.press(key)
    assert page.text("#marker-bearing") == "003.0° T  003.0° R"
    assert page.text("#marker-range") == "1065 m"  # half of 2048 m and two hundredths of it
    assert "003.0° T" in page.text("#spoken")
    page.press("Escape")
    assert page.text("#marker-bearing") == "–"


def test_controls_are_patched_and_refusals_shown(radar: FakeRadar, opened: Opened) -> None:
    opened.refusal = "422"
    page = opened(f"{BARE}&unit=m")
    page.ask("gain.value = 63, gain.dispatchEvent(new Event('input'))")
    page.wait("document.querySelector('#gain-value').value === '63' && !document.getElementById('notice').textContent")
    page.press("-")
    page.wait("document.getElementById('range').value === '2000'")
    page.press("p")
    page.wait("document.getElementById('pause').textContent === 'Resume'")
    page.wait("document.getElementById('banner').textContent === 'Paused'")
    page.ask("rpm.value = 13, rpm.dispatchEvent(new Event('change'))")
    page.wait("document.getElementById('notice').textContent.includes('unlucky')")
    assert radar.patched == [{"gain": 63}, {"range_m": 2000}, {"pace": {"state": "pause"}}, {"rpm": 13}]


def test_scene_is_put(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.wait("document.getElementById('scene').options.length === 2")
    page.ask("scene.value = 'other', document.getElementById('load-scene').click()")
    page.wait("!document.getElementById('load-scene').disabled")
    assert radar.scene == "other"


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
    wanted = centre + distance / 4096 * radius * np.array([[np.sin(bearing), -np.cos(bearing)]])
    assert off_by(spots, wanted) < PIXELS
    assert page.text("#lost-text") == "0"
    assert page.text("#warnings summary") == "1 warning"


def test_lost_spokes_are_counted_announced_or_not(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    radar.send(
        {"type": "gap", "epoch": "one", "first": 720, "count": 40, "reason": "slow"},
        radar.spokes(760, 20),
        radar.spokes(785, 20),
    )
    page.wait("document.getElementById('lost-text').textContent === '45 (5 unannounced)'")


def test_comes_back_by_itself_where_it_left_off(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    radar.next = 720
    radar.drop()
    page.wait(DRAWN.format("one:1440"))
    assert radar.joined[-1]["since"] == "one:720"
    assert page.text("#lost-text") == "0"
    page.wait("document.getElementById('connection').textContent === 'Connected'")


def test_radar_picker_appears_when_there_are_several(radar: FakeRadar, opened: Opened) -> None:
    alone = opened(BARE)
    assert alone.ask("document.getElementById('radar-row').offsetHeight") == 0
    radar.radars.append({"id": "1", "name": "aft radar"})
    page = opened(f"{BARE}&radar=1")
    assert page.ask("document.getElementById('radar').selectedOptions[0].textContent") == "aft radar"
    assert page.ask("document.getElementById('radar-row').offsetHeight") > 0


def test_works_at_phone_width(opened: Opened) -> None:
    page = opened(BARE, width=360, height=740, mobile=True)
    assert page.ask("document.documentElement.scrollWidth") == 360
    centre, radius, _ = measure(seen(page))
    assert centre[0] == pytest.approx(179.5, abs=1.0)  # half a pixel at each edge of the ring
    assert radius > 140


def test_every_control_has_a_name_and_takes_the_focus(opened: Opened) -> None:
    page = opened(BARE)
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


@pytest.mark.parametrize("palette", ["day", "dusk", "night"])
def test_stronger_echoes_are_brighter_in_every_palette(modules: Page, palette: str) -> None:
    modules.ask(f"document.documentElement.dataset.palette = '{palette}'")
    table = modules.ask("import('./palette.js').then(({echoColours}) => [...echoColours()])")
    linear = (np.array(table).reshape(256, 4)[:, :3] / 255) ** 2.2
    luminance = linear @ [0.2126, 0.7152, 0.0722]  # ITU-R BT.709: brightness is what every eye sees alike
    assert np.all(np.diff(luminance) > -2e-3)  # a step of a channel's 256 at full brightness is worth 2e-3 x 0.7
    contrast = (luminance[-1] + 0.05) / (luminance[0] + 0.05)
    assert contrast > 7  # WCAG 2.2, 1.4.6


def polar(modules: Page, script: str) -> Any:
    """What a script returns that uses `polar`, a picture of 4 rows and 2 columns, and `write`, which adds spokes to it."""
    setting = """import('./polar.js').then(({Polar}) => {
      const polar = new Polar(4, 2);
      const write = (scan, index, time, data, blind) =>
        polar.write({bins: 2, data: new Uint8Array(data), index, scan, time, blind});
      SCRIPT
    })"""
    return modules.ask(setting.replace("SCRIPT", script))


def test_spokes_of_a_blind_sector_are_blank(modules: Page) -> None:
    script = "write(0, 1, [1, 2], [9, 9, 9, 9]); write(1, 1, [5, 6], [7, 7, 7, 7], [true, false]); return [...polar.video];"
    assert polar(modules, script) == [0, 0, 0, 0, 7, 7, 0, 0]


def test_rows_that_missed_their_scans_are_not_shown_as_fresh(modules: Page) -> None:
    script = "write(0, 0, [0, 1], [9, 9, 9, 9]); write(3, 1, [13], [7, 7]); polar.age(4, 0); return [...polar.fade];"
    assert polar(modules, script) == [0, 255, 0, 0]  # 13 s are 3.25 scans; rows 2 and 3 were never written


def test_spokes_that_contradict_their_size_are_refused(modules: Page) -> None:
    script = "try { write(0, 0, [0], [9, 9, 9]); } catch (fault) { return fault.message; }"
    assert polar(modules, script) == "spokes: 3 bytes are not 1 spokes of 2 bins"


def test_msgpack_reads_what_the_service_writes(modules: Page) -> None:
    numbers: list[Any] = [0, 127, 128, 255, 256, 65535, 65536, 2**32, 2**53, -1, -32, -33, -128, -129, -32769, -(2**31) - 1]
    values = [
        *numbers,
        1.5,
        -1e300,
        None,
        True,
        False,
        "é",
        "x" * 40,
        "y" * 300,
        "z" * 70_000,
        list(range(20)),
        [0] * 70_000,
    ]
    message = {"values": values, "map": {f"k{i}": i for i in range(20)}, "single": [1.5]}
    packed = msgpack.packb(message)
    script = "import('./msgpack.js').then(({{decode}}) => JSON.stringify(decode(new Uint8Array({}).buffer)))"
    assert json.loads(modules.ask(script.format(list(packed)))) == message
    for data in (b"\xc4\x03abc", b"\xc5\x01\x00" + bytes(256), b"\xc6\x00\x01\x00\x00" + bytes(65536)):
        script = "import('./msgpack.js').then(({{decode}}) => [...decode(new Uint8Array({}).buffer)])"
        assert modules.ask(script.format(list(data))) == list(msgpack.unpackb(data))


@pytest.mark.parametrize(
    "data", [b"", b"\x92\x01", b"\x01\x01", b"\xc4\x05ab", b"\xa5ab", b"\xc1", b"\xd4\x00\x00", b"\x91" * 99 + b"\x01"]
)
def test_msgpack_refuses_what_is_broken(modules: Page, data: bytes) -> None:
    script = (
        "import('./msgpack.js').then(({{decode}}) => decode(new Uint8Array({}).buffer)).then(() => 'read', () => 'refused')"
    )
    assert modules.ask(script.format(list(data))) == "refused"


def test_waits_longer_after_each_failure(modules: Page) -> None:
    waits = modules.ask(
        "import('./feed.js').then(({backOff}) => [0, 1, 2, 3, 9].flatMap((n) => [backOff(n, 0), backOff(n, 1)]))"
    )
    assert waits == [0.375, 0.625, 0.75, 1.25, 1.5, 2.5, 3.0, 5.0, 7.5, 12.5]  # 0.5 s doubling to 10 s, a quarter either way


def test_a_feed_that_was_ended_hears_nothing_more(modules: Page) -> None:
    script = """import('./feed.js').then(({Feed}) => {
      const heard = [];
      const feed = new Feed(() => '', { hello: () => heard.push('hello'), state: (name) => heard.push(name) });
      feed.end();
      feed.receive(new Uint8Array(DATA).buffer);
      return heard;
    })"""
    message = msgpack.packb({"type": "hello", "protocol": 1, "epoch": "one"})
    assert modules.ask(script.replace("DATA", str(list(message)))) == []


@pytest.mark.parametrize(
    ("reach", "unit", "step"),
    [(5556.0, "nm", 926.0), (1389.0, "nm", 231.5), (44448.0, "nm", 7408.0), (4999.3, "m", 1000.0), (1000.0, "m", 200.0)],
)
def test_rings_stand_at_round_figures(modules: Page, reach: float, unit: str, step: float) -> None:
    got = modules.ask(f"import('./units.js').then(({{ringStep}}) => ringStep({reach}, '{unit}'))")
    assert got == pytest.approx(step, rel=1e-12)  # rounding of two products
