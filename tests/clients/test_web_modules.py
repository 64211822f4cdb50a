"""The page's modules one by one, imported in a real browser."""

import json
from typing import Any

import msgpack
import numpy as np
import pytest

from radar_service.display.palettes import PALETTES, colour_map
from radar_service.display.units import Unit, range_text, ring_step
from tests.clients.chromium import Page
from tests.clients.screen import BROWSER
from tests.display.test_units import RANGES

pytestmark = BROWSER


@pytest.mark.parametrize("palette", PALETTES)
def test_the_page_colours_echoes_as_pictures_do(modules: Page, palette: str) -> None:
    modules.ask(f"document.documentElement.dataset.palette = '{palette}'")
    table = modules.ask("import('./palette.js').then(({echoColours}) => [...echoColours()])")
    np.testing.assert_array_equal(np.array(table).reshape(256, 4)[:, :3], colour_map(palette))  # those of the Python client


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2.2)."""
    shares = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("palette", PALETTES)
def test_words_and_lines_stand_out_in_every_palette(modules: Page, palette: str) -> None:
    modules.ask(f"document.documentElement.dataset.palette = '{palette}'")
    words = ["text panel", "text page", "dim panel", "dim page", "good panel", "alarm panel", "text button", "text active"]
    marks = [
        "scale page",
        "edge panel",
        "edge button",
        *(f"{name} scope" for name in ("ring-text", "heading", "marker", "cursor", "truth")),
    ]
    names = sorted({f"--{name}" for pair in words + marks for name in pair.split()})
    script = f"import('./palette.js').then(({{colour}}) => {json.dumps(names)}.map((name) => colour(name)))"
    bright = dict(zip(names, map(luminance, modules.ask(script)), strict=True))
    for pairs, minimum in ((words, 4.5), (marks, 3.0)):  # WCAG 2.2, 1.4.3 and 1.4.11
        for pair in pairs:
            low, high = sorted(bright[f"--{name}"] for name in pair.split())
            assert (high + 0.05) / (low + 0.05) >= minimum, pair


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
    script = "try { polar.check({bins: 2, time: [0], data: new Uint8Array(3)}); } catch (fault) { return fault.message; }"
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
def test_msgpack_refuses_broken_data(modules: Page, data: bytes) -> None:
    script = (
        "import('./msgpack.js').then(({{decode}}) => decode(new Uint8Array({}).buffer)).then(() => 'read', () => 'refused')"
    )
    assert modules.ask(script.format(list(data))) == "refused"


def test_waits_longer_after_each_failure(modules: Page) -> None:
    waits = modules.ask(
        "import('./feed.js').then(({backOff}) => [0, 1, 2, 3, 9].flatMap((n) => [backOff(n, 0), backOff(n, 1)]))"
    )
    assert waits == [0.375, 0.625, 0.75, 1.25, 1.5, 2.5, 3.0, 5.0, 7.5, 12.5]  # 0.5 s doubling to 10 s, a quarter either way


def test_an_ended_feed_ignores_messages(modules: Page) -> None:
    script = """import('./feed.js').then(({Feed}) => {
      const calls = [];
      const feed = new Feed(() => '', { hello: () => calls.push('hello'), state: (name) => calls.push(name) });
      feed.end();
      feed.receive(new Uint8Array(DATA).buffer);
      return calls;
    })"""
    message = msgpack.packb({"type": "hello", "protocol": 1, "epoch": "one"})
    assert modules.ask(script.replace("DATA", str(list(message)))) == []


@pytest.mark.parametrize("unit", ["nm", "m"])
def test_pictures_have_the_rings_and_texts_of_the_page(modules: Page, unit: Unit) -> None:
    script = (
        "import('./units.js').then(({ringStep, rangeText}) => RANGES.map((m) => [ringStep(m, UNIT), rangeText(m, UNIT)]))"
    )
    got = modules.ask(script.replace("RANGES", str(list(RANGES))).replace("UNIT", repr(unit)))
    assert [text for _, text in got] == [range_text(distance, unit) for distance in RANGES]
    assert [step for step, _ in got] == pytest.approx([ring_step(distance, unit) for distance in RANGES], rel=1e-12)


FRAMES = """import('./detail.js').then(({Detail}) => {
  const detail = new Detail(), shares = [];
  let time = 0;
  const frames = (count, gap, drawn = true) => {  // gap: ms, by the share of the pixels that are drawn
    for (let k = 0; k < count; k++) detail.frame(time += gap(detail.share), drawn);
    shares.push(detail.share);
  };
  SCRIPT
  return shares;
})"""


@pytest.mark.parametrize(
    ("script", "shares"),
    [
        ("frames(1000, () => 16.7);", [1]),
        ("frames(1000, (share) => 33 * share ** 2);", [0.7]),  # 33 ms, then 16.2
        ("frames(1000, (share) => 50 * share ** 2);", [0.5]),  # 50, 24.5, 12.5
        ("frames(30, () => 33); frames(30, () => 33);", [1, 0.7]),  # one second tells nothing yet, two do
        ("frames(500, () => 33.3);", [1]),  # a screen of 30 Hz: coarser is no faster
        ("frames(500, () => 33.3, false);", [1]),
        ("frames(500, () => 300);", [1]),  # a hidden page
        ("frames(60, () => 33); detail.restart(); frames(1, () => 33);", [0.7, 1]),
    ],
)
def test_resolution_falls_if_that_makes_frames_faster(modules: Page, script: str, shares: list[float]) -> None:
    assert modules.ask(FRAMES.replace("SCRIPT", script)) == shares


def test_full_resolution_is_tried_again_after_growing_waits(modules: Page) -> None:
    """Of 400 s with frames of 33 ms at full detail and 16.2 at less: after 60, 120 and (next, beyond the end) 240 s of peace."""
    script = """let fine = 0, now = 0;
      for (let k = 0; now < 400_000; k++) {
        const before = detail.share;
        detail.frame((now += 33 * before ** 2), true);
        if (before < 1 && detail.share === 1) fine++;
      }
      shares.push(fine, detail.share);"""
    assert modules.ask(FRAMES.replace("SCRIPT", script)) == [2, 0.7]


def test_without_a_heading_the_ship_keeps_that_before(modules: Page) -> None:
    lost = {
        "heading": [16384, None],
        "course": [0, None],
        "azimuth": [0, 32768],
        "speed": [1, 2],
        "position": [[0, 0], [3, 4]],
    }
    script = f"""import('./status.js').then(({{shipOf}}) => {{
      const first = shipOf({json.dumps(lost)}, 0, null);
      return [first, shipOf({json.dumps(lost)}, 1, first)];
    }})"""
    first, second = modules.ask(script)
    assert (first["heading"], first["isLost"]) == (pytest.approx(np.pi / 2), False)
    assert (second["heading"], second["course"], second["isLost"]) == (first["heading"], first["course"], True)
    assert second["azimuth"] == pytest.approx(np.pi) and second["position"] == [3, 4]
