"""What the page shows to viewers who may see the truth: marks and names on the picture, the table, errors on purpose."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar
from tests.clients.screen import BARE, BROWSER, DRAWN, measure, seen

pytestmark = BROWSER

COLOUR = (0x86, 0xE3, 0x9A)  # of the truth in the dusk palette
HALF = 9  # CSS pixels, half the side of a mark
UNNAMED = "document.getElementById('unnamed-text').textContent === '{}'"


def with_truth(radar: FakeRadar, opened: Opened, query: str = BARE, **size: Any) -> Page:
    radar.gives_truth = True
    page = opened(f"{query}&truth=on&unit=m", **size)
    page.wait(f"{DRAWN.format('one:720')} && !document.getElementById('targets').hidden")
    assert [query.get("truth") for query in radar.joined[-2:]] == [None, "1"]  # first it must learn that it may ask
    return page


def send(radar: FakeRadar, page: Page, **bodies: dict[str, Any]) -> None:
    """Sends a truth message, and returns once the page has drawn it."""
    radar.send(radar.truth(**bodies))
    page.ask("document.getElementById('targets').open = true")
    page.wait(f"document.querySelectorAll('#targets tbody tr').length === {len(bodies)}")
    page.ask("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")


def at(bearing_deg: float, distance: float, **more: Any) -> dict[str, Any]:
    """A body at rest, or as `more` has it, at a bearing and a range from own ship [m]."""
    angle = np.deg2rad(bearing_deg)
    position = [distance * np.sin(angle), distance * np.cos(angle), 0.0]
    return {"position": position, "range": distance, "azimuth": angle % (2 * np.pi)} | more


def marked(screen: NDArray[np.int16]) -> NDArray[np.bool_]:
    """Pixels in the colour of the truth, or in a shade of it: lines have soft edges."""
    part = screen[..., 1] - np.maximum(screen[..., 0], screen[..., 2])
    lit: NDArray[np.bool_] = part > 0.4 * (COLOUR[1] - COLOUR[2])
    return lit


def around(lit: NDArray[np.bool_], centre: NDArray[np.float64], inner: int, outer: int) -> int:
    """How many pixels are lit in a square frame about a place, from `inner` to `outer` pixels off."""
    x, y = np.rint(centre).astype(int)
    whole, hole = (
        lit[y - outer : y + outer + 1, x - outer : x + outer + 1],
        lit[y - inner : y + inner + 1, x - inner : x + inner + 1],
    )
    return int(whole.sum() - hole.sum()) if inner else int(whole.sum())


def test_truth_is_listed_nearest_first_and_its_marks_leave_the_echo_free(radar: FakeRadar, opened: Opened) -> None:
    """Corners about it, and neither a ring, nor a vector, nor a name on it; what cannot be seen has dotted corners."""
    page = with_truth(radar, opened)
    coast = {"range": 20.0, "extent": 4000.0}
    ferry = at(90, 1024, velocity=[0.0, 5.0, 0.0], speed=5.0)
    send(radar, page, coast=coast, ferry=ferry, rock=at(180, 512, visible=False, reason="below horizon"))
    rows = page.ask(
        "[...document.querySelectorAll('#targets tbody tr')].map((row) => [...row.children].map((c) => c.textContent))"
    )
    assert rows == [
        ["rock", "512", "180.0°", "–", "below horizon"],
        ["ferry", "1024", "090.0°", "000° 10", "yes"],
        ["coast", "around", "–", "–", "yes"],  # its position, which is not the nearest point of it, is 20 m off
    ]
    assert page.text("#targets thead") == "NameRange, mBrgCourse, knVisible"
    assert page.ask("(({scrollWidth, clientWidth}) => scrollWidth - clientWidth)(document.querySelector('.table'))") == 0
    centre, radius, _ = measure(seen(page))
    ship = at(90, 1024, velocity=[0.0, 9.0, 0.0], speed=9.0)
    send(radar, page, ferry=ship, rock=at(180, 1024, visible=False, reason="shadowed"))
    lit, far = marked(seen(page)), radius * 1024 / 2778
    east, south = centre + [far, 0], centre + [0, far]
    for position in (east, south):
        assert around(lit, position, 0, HALF - 3) == 0
    full, dotted = (around(lit, position, HALF - 3, HALF + 2) for position in (east, south))
    assert full > 1.3 * dotted > 0
    x, y = np.rint(east).astype(int)
    assert lit[y - 35 : y - HALF - 2, x - 1 : x + 2].any() and not lit[y - HALF + 3 : y, x - 1 : x + 2].any()  # the vector
    page.ask("document.getElementById('truth').click()")
    page.wait("document.getElementById('targets').hidden")


def test_no_name_is_left_out_in_silence(radar: FakeRadar, opened: Opened) -> None:
    """Ten buoys within twenty pixels: names stand off, with lines; of two hundred the page counts those without room."""
    page = with_truth(radar, opened)
    page.wait(UNNAMED.format(""))
    send(radar, page, **{f"buoy number {k}": at(90 + k, 1024 + 5 * k) for k in range(10)})
    page.wait(UNNAMED.format("") + " && document.getElementById('unnamed-text').hidden")
    few = int(marked(seen(page)).sum())
    send(radar, page, **{f"buoy number {k}": at(90 + k / 50, 1024 + k / 5) for k in range(200)})
    page.wait("/^[0-9]+ names not drawn$/.test(document.getElementById('unnamed-text').textContent)")
    count = int(page.text("#unnamed-text").split()[0])
    assert 120 <= count < 200  # at most 80 names are drawn
    assert marked(seen(page)).sum() > few
    send(radar, page, alone=at(90, 1024))
    page.wait(UNNAMED.format(""))


PLACED = """import('./labels.js').then(({placeLabels}) => {
  const marks = MARKS.map(([x, y, width]) => ({x, y, half: 9, width}));
  const isInside = ([x, y, w, h]) => x >= 0 && y >= 0 && x + w <= 400 && y + h <= 400;
  return placeLabels(marks, isInside, TAKEN);
})"""


def placed(modules: Page, marks: list[list[float]], taken: Sequence[list[float]] = ()) -> list[dict[str, Any] | None]:
    return list(modules.ask(PLACED.replace("MARKS", str(marks)).replace("TAKEN", str(list(taken)))))


def test_labels_cover_neither_marks_nor_each_other(modules: Page) -> None:
    rng = np.random.default_rng(5)
    marks = [[*rng.uniform(150, 250, 2).tolist(), float(width)] for width in rng.uniform(20, 60, 25)]
    places = placed(modules, marks, [[180, 190, 40, 15]])
    boxes = [place["box"] for place in places if place] + [[180, 190, 40, 15]]
    boxes += [[x - 9, y - 9, 18, 18] for x, y, _ in marks]
    labels = sum(place is not None for place in places)
    assert labels > 12
    for k in range(labels):
        x, y, w, h = boxes[k]
        assert min(x, y, 400 - x - w, 400 - y - h) >= 0
        for other, (u, v, width, height) in enumerate(boxes):
            assert k == other or x + w <= u or u + width <= x or y + h <= v or v + height <= y, (k, other)


def test_a_label_stands_at_the_right_where_there_is_room_and_else_at_the_end_of_a_line(modules: Page) -> None:
    (alone,) = placed(modules, [[200, 200, 50]])
    assert alone and alone["align"] == "left" and alone["x"] == 212 and alone["y"] == 200 and alone["leader"] is None
    (left,) = placed(modules, [[390, 200, 50]])
    assert left and left["align"] == "right" and left["x"] == 378
    walls = [[212.0, 150.0, 100.0, 100.0], [100.0, 180.0, 88.0, 40.0]]
    (far,) = placed(modules, [[200, 200, 50]], walls)
    assert far and far["leader"] and far["leader"][0] != [200, 200]
    assert placed(modules, [[200, 200, 50], [30, 300, 900]])[1] is None  # wider than the picture


ERRORS = {"gyro": {"bias_deg": 20}, "feed": {"drop_rate": 0.1}}


def test_errors_on_purpose_are_told_beside_the_heading(radar: FakeRadar, opened: Opened) -> None:
    radar.gives_truth, radar.errors = True, ERRORS
    page = opened(BARE)
    page.wait("document.getElementById('errors-text').textContent === 'Errors: gyro, feed'")
    assert page.ask("document.getElementById('errors-text').offsetHeight") > 0
    radar.errors = {}
    radar.send(radar.hello())
    page.wait("document.getElementById('errors-text').hidden")


def test_a_service_without_truth_gives_neither_marks_nor_errors(radar: FakeRadar, opened: Opened) -> None:
    """A blind test stays blind."""
    radar.errors = ERRORS
    page = opened(f"{BARE}&truth=on")
    page.wait("document.getElementById('heading-text').textContent !== '–'")
    assert page.ask("document.getElementById('errors-text').hidden") and radar.asked_for_errors == 0
    assert page.ask("document.getElementById('truth').disabled")
    assert "truth" not in radar.joined[-1]
    assert "--truth" in page.ask("document.getElementById('truth-row').title")
