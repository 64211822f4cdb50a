"""What a mariner does with the page: framing, read-outs, trails, scenes, small screens; in a real browser."""

import threading

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.world.geo import geographic_from_map
from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar, Picture
from tests.clients.screen import BARE, BROWSER, DRAWN, PIXELS, blobs, box, expected, measure, off_by, seen

pytestmark = BROWSER

# Till the page has drawn what was sent to it: a 2D canvas draws twelve times a second only.
FRAMES = """new Promise((done) => {
  let left = 4;
  const next = () => (left-- ? requestAnimationFrame(next) : done(true));
  next();
})"""
CLICK = "document.getElementById('{}').click()"


def wheel(page: Page, x: float, y: float, pixels: float) -> None:
    """Turn the wheel over a place; up is negative."""
    page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=pixels)


def drag(page: Page, start: NDArray[np.float64], by: NDArray[np.float64]) -> None:
    """Pull the picture with the mouse."""
    for kind, at in (
        ("mousePressed", start),
        ("mouseMoved", start + by / 2),
        ("mouseMoved", start + by),
        ("mouseReleased", start + by),
    ):
        x, y = at.tolist()
        page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)


@pytest.mark.parametrize("renderer", ["webgl", "canvas"])
def test_targets_are_at_their_positions_zoomed_and_off_centre(radar: FakeRadar, opened: Opened, renderer: str) -> None:
    page = opened(f"{BARE}&renderer={renderer}&unit=m")
    centre, radius, _ = measure(seen(page))
    pull = np.array([-30.0, 20.0])
    drag(page, centre, pull)
    page.press("z")
    page.wait("document.getElementById('zoom-text').textContent === '2×'")
    ship = centre + 2 * pull
    points = expected(radar.picture, ship, 2 * radius, 0.0)
    points = points[np.hypot(*(points - centre).T) < radius * 3000 / 2778 - 20]  # within the rim: the scale is 3000 m
    page.ask(FRAMES)
    spots, _ = blobs(seen(page))
    assert len(points) == 3
    assert off_by(spots, points) < 2 * PIXELS  # what the ring's edges err by is doubled too
    x, y = points[0]
    page.click(x, y)
    assert page.text("#cursor-bearing").startswith("030.") or page.text("#cursor-bearing").startswith("029.")
    assert float(page.text("#cursor-range").removesuffix(" m")) == pytest.approx(898, abs=2 * PIXELS * 2778 / (2 * radius))
    assert page.text("#range-text") == "1500 m"
    assert page.text("#framing-text") == "2× of 3000 m"
    page.press("c")
    page.wait("document.getElementById('framing-text').textContent === ''")
    page.press("o")
    page.wait("document.getElementById('framing-text').textContent === 'Off centre'")


def test_the_wheel_zooms_about_the_pointer(opened: Opened) -> None:
    page = opened(f"{BARE}&unit=m")
    x, y, side = box(page)
    position = x + 0.6 * side, y + 0.3 * side
    page.click(*position)
    before = page.text("#cursor-bearing"), page.text("#cursor-range")
    wheel(page, *position, -400)
    page.wait("document.getElementById('zoom-text').textContent === '2×'")
    page.click(*position)
    assert (page.text("#cursor-bearing"), page.text("#cursor-range")) == before


def test_two_fingers_zoom(opened: Opened) -> None:
    page = opened(BARE, width=390, height=844, mobile=True)
    page.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    for kind, half in (("touchStart", 30), ("touchMove", 45), ("touchMove", 60), ("touchEnd", None)):
        fingers = [] if half is None else [{"x": 195 - half, "y": 190, "id": 0}, {"x": 195 + half, "y": 190, "id": 1}]
        page.call("Input.dispatchTouchEvent", type=kind, touchPoints=fingers)
    page.wait("document.getElementById('zoom-text').textContent === '2×'")
    both = [{"x": 150, "y": 190, "id": 0}, {"x": 240, "y": 190, "id": 1}]
    for kind, fingers in (("touchStart", both), ("touchEnd", [])):
        page.call("Input.dispatchTouchEvent", type=kind, touchPoints=fingers)
    assert page.text("#marker-range") == "–"  # neither a pinch nor two fingers are a tap
    page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": 200, "y": 150}])
    page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.wait("document.getElementById('marker-range').textContent !== '–'")


def test_the_keyboard_moves_the_cursor_and_reads_its_latitude_and_longitude(radar: FakeRadar, opened: Opened) -> None:
    radar.origin = {"latitude_deg": 50.3, "longitude_deg": -1.4}
    page = opened(f"{BARE}&unit=m")
    page.ask("document.getElementById('scope').focus()")
    for key in ["ArrowRight"] * 3 + ["ArrowUp"] * 2 + ["Enter"]:
        page.press(key)
    reach, bearing = 0.52 * 3000, np.deg2rad(3)
    latitude, longitude = geographic_from_map(reach * np.array([np.sin(bearing), np.cos(bearing)]), (50.3, -1.4))
    north, west = (latitude - 50) * 60, (1 + longitude) * -60
    assert page.text("#marker-bearing") == "003.0° T  003.0° R"
    assert page.text("#marker-range") == "1560 m"  # half of the scale of 3000 m and two hundredths of it
    assert "003.0° T" in page.text("#spoken")
    assert page.text("#marker-position") == f"50°{north:06.3f}′ N\n001°{west:06.3f}′ W"
    assert page.text("#position-text") == "50°18.000′ N\n001°24.000′ W"
    page.press("Escape")
    assert page.text("#marker-bearing") == "–"


@pytest.mark.parametrize("renderer", ["webgl", "canvas"])
def test_trails_show_where_a_target_was(radar: FakeRadar, opened: Opened, renderer: str) -> None:
    radar.heading_deg = 70.0
    page = opened(f"{BARE}&trails=60&renderer={renderer}&orientation=head-up")
    centre, radius, _ = measure(seen(page))
    point = expected(radar.picture, centre, radius, 70.0)[1]
    before = seen(page)[round(point[1]), round(point[0])]
    radar.picture.video[:, :-10] = 0  # all but the ring: the target has gone
    radar.send(*(radar.spokes(first, 60) for first in range(720, 1440, 60)))
    page.wait(DRAWN.format("one:1440"))
    page.ask(FRAMES)
    screen = seen(page)
    after, elsewhere = screen[round(point[1]), round(point[0])], screen[round(2 * centre[1] - point[1]), round(point[0])]
    assert before[0] > 200  # an echo is yellow
    assert after[2] > after[0] + 40 and after[2] > elsewhere[2] + 40  # its trail is blue, and the bare scope is dark
    page.ask(CLICK.format("clear-trails"))
    page.ask(FRAMES)
    assert np.array_equal(seen(page)[round(point[1]), round(point[0])], elsewhere)


DROP = """(() => {{
  const data = new DataTransfer();
  for (const [name, text] of {}) data.items.add(new File([text], name));
  for (const kind of ['dragover', 'drop']) {{
    document.body.dispatchEvent(new DragEvent(kind, {{dataTransfer: data, bubbles: true, cancelable: true}}));
  }}
}})()"""


def test_a_dropped_scene_is_uploaded_started_and_its_plan_shown(radar: FakeRadar, opened: Opened) -> None:
    opened.refusal = "422"
    page = opened(BARE)
    page.wait("document.getElementById('scene').options.length === 2")
    assert page.text("#scene-about") == "3 bodies"
    page.ask(DROP.format([["rock.obj", "v 0 0 0"], ["ferry.obj", "v 1 0 0"]]))
    page.wait("document.getElementById('scene-answer').textContent.includes('one scene')")
    page.ask(DROP.format([["x.toml", "bad"]]))
    page.wait("document.getElementById('scene-answer').textContent === 'x.toml is refused:\\nbody[0]: bad; mend it'")
    page.wait("document.activeElement.closest('[role=alert]')?.textContent.startsWith('x.toml is refused')")
    page.press("Escape")
    assert page.ask("document.querySelectorAll('.toast').length") == 0 and page.ask("document.activeElement.id") != "alerts"
    page.ask(DROP.format([["my bay (2).toml", "name = 'sent'"], ["rock.obj", "v 0 0 0"]]))
    page.wait(
        "document.getElementById('scene-answer').textContent.startsWith('my bay (2).toml is on the air as my bay -2-')"
    )
    files = [("scene", "my bay (2).toml", b"name = 'sent'"), ("files", "rock.obj", b"v 0 0 0")]
    assert radar.uploads[1:] == [("my bay -2-", files)]
    assert radar.scene == "my bay -2-"
    page.wait("document.activeElement.closest('[role=status]')?.textContent.startsWith('my bay (2).toml is on the air')")
    assert page.text("#plan summary") == "Plan: 1 of 2 modelled"
    assert [page.text(f"#plan li.{kind}") for kind in ("modelled", "not-modelled")] == [
        "beam, modelled:  sinc2",
        "rain, not modelled:  no rain",
    ]
    page.ask(CLICK.format("remove-scene"))
    page.wait("document.getElementById('scene-answer').textContent === 'my bay -2- is removed.'")
    assert radar.removed == ["my bay -2-"]
    radar.epoch = "two"  # as the answer has said; it begins at the end of a scan
    radar.send(radar.hello())
    page.wait("document.getElementById('scene-name').textContent === 'my bay -2-'")
    assert "another viewer" not in page.text("#toasts")


def test_the_page_says_how_far_the_service_falls_behind_and_what_to_do(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    for reached, fidelity, remedy in (
        (0.618, "balanced", "set Speed to ½×, or start the server with --fidelity fast"),
        (0.3, "fast", "set Speed to ¼×"),
        (0.2, "reference", "start the server with --fidelity fast"),
        (0.2, "fast", "take a smaller scene"),
    ):
        radar.fidelity, radar.health = fidelity, {"id": "0", "state": "behind", "factor_reached": reached}
        radar.send(radar.hello(), radar.spokes(720, 60))  # without a spoke the picture soon stands still
        page.press("-")  # whatever is commanded, the page asks how things stand
        text = f"Too slow: {reached:.2f}× of 1×. Remedy: {remedy}"
        page.wait(f"document.getElementById('banner').textContent === '{text}'")
        assert page.ask("document.getElementById('warning').classList.contains('mild') && !banner.hidden")


def live(radar: FakeRadar, first: int, seconds: float, levels: tuple[int, int]) -> threading.Thread:
    """Sends spokes from `first` as a radar of 24 rpm does, every scan at the other level."""
    period = 2.5 / radar.picture.azimuths

    def play() -> None:
        pause = threading.Event()
        for start in range(first, first + int(seconds / period), 6):
            radar.picture.video[:] = levels[start // radar.picture.azimuths % 2]
            radar.send(radar.spokes(start, 6))
            pause.wait(6 * period)

    thread = threading.Thread(target=play)
    thread.start()
    return thread


def test_the_picture_has_one_seam_at_the_sweep(radar: FakeRadar, opened: Opened) -> None:
    radar.picture = Picture(bins=64, step=2778 / 64, rim=False)
    radar.picture.video[:] = 70
    page = opened("rings=off&headline=off&afterglow=0&palette=dusk")
    left, top, side = box(page)
    bearing = np.deg2rad(np.arange(2, 358, 0.1))
    radii = np.linspace(0.25, 0.8, 12)[:, None] * (side / 2 - 33)
    columns = np.floor(left + side / 2 + radii * np.sin(bearing)).astype(int)
    rows = np.floor(top + side / 2 - radii * np.cos(bearing)).astype(int)
    player = live(radar, 720, 1.5, (70, 110))
    sweeps = []
    for _ in range(3):
        page.ask(FRAMES)
        screen = seen(page)
        colours = screen[rows, columns]
        is_line = colours[..., 2] > 90  # blue is 60 in either level's yellow and 196 in the sweep
        is_new = colours[..., 0] > 173  # red is 147 in level 70, 200 in level 110
        angles = [np.flatnonzero(line).mean() for line in is_line if line.any()]
        assert len(angles) > 6  # of 12 circles: one may slip between two faint pixels of the line
        sweep = np.median(angles)
        width = (
            np.rad2deg(1.5 / radii) + 1.5
        ) / 0.1  # samples: the line's pixel and a half, and three rows of half a degree
        old, new = np.arange(len(bearing)) > sweep + width, np.arange(len(bearing)) < sweep - width
        assert is_new[new].all() and not is_new[old].any()
        sweeps.append(sweep)
    player.join(10)
    assert np.diff(sweeps).min() >= 0


BOXES = """[...document.querySelectorAll('{}')].filter((one) => one.offsetWidth > 1 && one.checkVisibility())
  .map((one) => [one, one.getBoundingClientRect()])
  .map(([one, {{left, top, right, bottom}}]) => [one.id || one.textContent, left, top, right, bottom])"""
PANEL = "#panel h1, #panel p, #panel button, #panel .button, #panel select, #panel input, #panel output, #panel summary"
CUT = """[...document.querySelectorAll('button, select, .corner')]
  .filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.id)"""


def overlaps(boxes: list[tuple[str, float, float, float, float]]) -> list[tuple[str, str]]:
    """Names of boxes that cover more than a pixel of each other."""
    hits = []
    for k, (one, *a) in enumerate(boxes):
        for other, *b in boxes[k + 1 :]:
            if min(a[2], b[2]) - max(a[0], b[0]) > 1 and min(a[3], b[3]) - max(a[1], b[1]) > 1:
                hits.append((one, other))
    return hits


@pytest.mark.parametrize(("width", "height"), [(360, 640), (1400, 900)])
def test_nothing_overlaps_on_a_phone_or_a_desk(radar: FakeRadar, opened: Opened, width: int, height: int) -> None:
    radar.origin = {"latitude_deg": 50.3, "longitude_deg": -101.4}
    radar.warnings, radar.gives_truth = ["body[0]: open mesh"], True
    page = opened("truth=on", width=width, height=height, mobile=width < 500)
    left, top, side = box(page)
    page.click(left + 0.6 * side, top + 0.7 * side)
    page.press("z")
    page.wait(
        "document.getElementById('marker-position').textContent && document.getElementById('framing-text').textContent"
    )
    read_outs = page.ask(BOXES.format(".corner > *"))
    assert len(read_outs) >= 13
    if width < 500:
        assert overlaps([*page.ask(BOXES.format("#scope, #panel")), *read_outs]) == []
        assert side > min(0.99 * width, 0.43 * height)  # as wide as the screen, or all that 200 pixels for the panel leave
    else:
        middle = np.array([left + side / 2, top + side / 2])
        nearest = [np.hypot(*(np.clip(middle, corners[:2], corners[2:]) - middle)) for _, *corners in read_outs]
        assert overlaps(read_outs) == []
        assert min(nearest) > side / 2  # the bearing scale with its figures stays within
    lines = page.ask("[...document.querySelectorAll('.position')].map((one) => one.getClientRects()[0].height)")
    assert max(lines) < (20 if width < 500 else 50)  # a line on a phone, two on a desk
    assert overlaps(page.ask(BOXES.format(PANEL))) == []
    assert page.ask(CUT) == []
    assert page.ask("document.documentElement.scrollWidth") == width
    assert page.ask("document.documentElement.scrollHeight") == height
