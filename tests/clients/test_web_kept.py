"""Echoes and trails survive a change of range, of motion and of orientation; standby blanks them; in a real browser."""

import json
from typing import Any

import numpy as np
import pytest

from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar, Picture
from tests.clients.screen import BARE, BROWSER, DRAWN, PIXELS, box, echoes, expected, off_by, seen
from tests.clients.screen import blobs as spots_of

pytestmark = BROWSER

SCALE = 2778.0  # m, of the picture: 1.5 NM
FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done))))"


def middle(page: Page) -> tuple[np.ndarray, float]:
    """Own ship's point and the rim's radius on the screen [pixels]."""
    left, top, side = box(page)
    return np.array([left + side / 2, top + side / 2]) - 0.5, side / 2 - (33 if side > 500 else 30)


def test_echoes_survive_a_shorter_range_and_return_with_the_longer_one(radar: FakeRadar, opened: Opened) -> None:
    radar.range_max, whole = SCALE, radar.picture
    page = opened(BARE)
    radar.epoch, radar.picture = "two", Picture(bins=512, step=SCALE / 1024)
    radar.send(radar.hello())  # and no spoke: all that shows was known before
    page.wait("document.getElementById('range-text').textContent === '0.75 NM'")
    page.ask(FRAMES)
    centre, radius = middle(page)
    near = expected(whole, centre, 2 * radius, 0.0)[[0, 2]]  # the third target is beyond this range
    screen = seen(page)
    screen[np.hypot(*(np.indices(screen.shape[:2]) - centre[::-1, None, None])) > radius] = 0
    assert off_by(spots_of(screen)[0], near) < PIXELS
    radar.epoch, radar.picture = "three", whole
    radar.send(radar.hello())
    page.wait("document.getElementById('range-text').textContent === '1.5 NM'")
    page.ask(FRAMES)
    all_of_it = expected(whole, centre, radius, 0.0)
    screen = seen(page)
    screen[np.hypot(*(np.indices(screen.shape[:2]) - centre[::-1, None, None])) > 0.9 * radius] = 0  # without the rim's ring
    assert off_by(spots_of(screen)[0], all_of_it) < PIXELS


def test_another_scene_starts_black_and_standby_blanks(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.ask("transmit.click(), document.getElementById('banner').style.visibility = 'hidden'")  # it is yellow too
    page.wait("document.getElementById('banner').textContent === 'Standby'")
    page.ask(FRAMES)
    assert not echoes(seen(page)).any()
    page.ask("transmit.click()")
    page.wait("document.getElementById('transmit').ariaPressed === 'true'")
    radar.send(*(radar.spokes(first, 60) for first in range(720, 1440, 60)))
    page.wait(DRAWN.format("one:1440"))
    assert echoes(seen(page)).any()
    radar.epoch, radar.scene = "two", "other"
    radar.send(radar.hello())
    page.wait("document.getElementById('scene-name').textContent === 'other'")
    page.ask(FRAMES)
    assert not echoes(seen(page)).any()


def test_true_motion_keeps_the_map_and_moves_own_ship(radar: FakeRadar, opened: Opened) -> None:
    page = opened(f"{BARE}&motion=true")
    assert page.text("#mode-text") == "N-UP TM"
    centre, radius = middle(page)
    radar.send(radar.spokes(720, 60) | {"position": [[0.0, 0.0]] * 59 + [[300.0, 500.0]]})
    page.wait(DRAWN.format("one:780"))
    moved = np.array([300.0, -500.0]) * radius / SCALE  # on the screen, y downward
    page.ask(FRAMES)
    page.click(*(centre + moved + 0.5).tolist())
    far = float(page.text("#cursor-range").removesuffix(" NM")) * 1852
    assert far < 2 * SCALE / radius  # own ship is there, to two pixels
    radar.send(radar.spokes(780, 60) | {"position": [[300.0, 2400.0]] * 60})
    page.wait(DRAWN.format("one:840"))
    page.press("h")
    assert page.text("#mode-text") == "H-UP RM" and page.ask("motion.disabled")


def test_sea_stabilisation_measures_against_the_water(radar: FakeRadar, opened: Opened) -> None:
    """The ship lies still in a stream of 4 m/s to the north: over ground the map is at rest, through the water it moves with the
    stream, and own ship to the south of it. With no stream in the scene the numbers are those over ground."""
    radar.stream = [0.0, 4.0]
    page = opened(f"{BARE}&motion=true&stabilisation=sea")
    read = ["#stabilisation-text", "#course-label", "#speed-label"]
    assert [page.text(each) for each in read] == ["SEA STAB", "CTW", "STW"]
    still = {"speed": [0.0] * 60, "heading": [16384] * 60, "course": [16384] * 60}
    radar.send(radar.spokes(720, 60) | still | {"time": [2.5] * 60})
    page.wait(DRAWN.format("one:780"))
    page.ask(FRAMES)
    assert (page.text("#course-text"), page.text("#speed-text")) == ("180.0°", "7.8 kn")
    centre, radius = middle(page)
    radar.send(radar.spokes(780, 60) | still | {"time": [2.5] * 59 + [102.5]})
    page.wait(DRAWN.format("one:840"))
    page.ask(FRAMES)
    south = np.array([0.0, 400.0]) * radius / SCALE  # 100 s of the stream, on the screen
    page.click(*(centre + south + 0.5).tolist())
    assert float(page.text("#cursor-range").removesuffix(" NM")) * 1852 < 2 * SCALE / radius  # two pixels
    assert page.text("#stream-text") == "000°  7.8 kn"
    page.ask("stabilisation.value = 'ground', stabilisation.onchange()")
    assert [page.text(each) for each in read] == ["GND STAB", "COG", "SOG"]


PICTURE = """import('./picture.js').then(({Picture}) => {
  const settings = {trails: '60', trailmotion: 'true'}, picture = new Picture(settings);
  const hello = (range, bins, time = 0, name = 'bay') => picture.adopt({
    radar: {id: '0', azimuths: 360, rpm: 24}, scene: {name}, seed: 0, clocks: {simulated_s: time},
    encoding: {bins, range_first_m: range / bins / 2, range_step_m: range / bins, range_m: range}});
  const spoke = (index, time, level, bin, position = [0, 0]) => {
    const {bins} = picture.polar, {first, step, range} = picture.grid, data = new Uint8Array(bins);
    data[bin] = level;
    picture.write({data, bins, index, scan: Math.floor(time / 2.5), time: [time], azimuth: [index / 360 * 65536],
      position: [position], range_first_m: first, range_step_m: step, range}, 0, 1);
  };
  const cells = (index) => [...picture.polar.video.slice(index * picture.polar.bins, (index + 1) * picture.polar.bins)]
    .flatMap((level, n) => (level ? [[n, level]] : []));
  const trail = (degrees, range) => picture.trails?.at(degrees / 180 * Math.PI, range) ?? null;
  SCRIPT
})"""


def picture(modules: Page, script: str) -> Any:
    """Result of a script with a picture of 360 spokes."""
    return modules.ask(PICTURE.replace("SCRIPT", script))


def test_cells_keep_their_ranges_on_another_grid(modules: Page) -> None:
    script = """hello(1000, 100); spoke(90, 1, 200, 31); spoke(90, 1, 200, 31);
      const before = cells(90);
      hello(500, 100); const shorter = cells(90);
      hello(1000, 100); const again = cells(90);
      hello(4000, 50); const longer = cells(90);
      hello(1000, 100, 0, 'sea'); return [before, shorter, again, longer, cells(90)];"""
    cell = [[31, 200]]
    assert picture(modules, script) == [cell, [[62, 200], [63, 200]], cell, [[3, 200]], []]  # 310 to 320 m


def test_cells_beyond_a_shorter_range_are_kept_for_four_scans(modules: Page) -> None:
    script = """return [9, 11].map((wait) => {
        hello(1000, 100, 1, `bay ${wait}`); spoke(90, 1, 200, 81);
        hello(500, 100, 1, `bay ${wait}`); spoke(90, 1 + wait, 100, 20);
        hello(1000, 100, 1 + wait, `bay ${wait}`); return cells(90); });"""
    assert picture(modules, script) == [[[10, 100], [81, 200]], [[10, 100]]]


def test_a_scene_that_starts_again_keeps_the_age_of_its_cells(modules: Page) -> None:
    script = """hello(1000, 100); spoke(90, 100, 200, 31); spoke(180, 102.5, 200, 31);
      hello(1000, 100, 0); spoke(270, 0, 9, 9); picture.polar.age(2.5, 1);
      return [90, 180, 270].map((row) => picture.polar.fade[row]);"""
    assert picture(modules, script) == [128, 255, 255]  # the half-life is one scan


def test_trails_survive_range_motion_and_length(modules: Page) -> None:
    """An echo 505 m east of own ship, which then sails 200 m east."""
    script = """hello(1000, 100); spoke(90, 1, 200, 50); spoke(0, 16, 0, 0, [200, 0]);
      const at = () => [trail(90, 305), trail(90, 505)].map((one) => one && Number(one.toFixed(2)));
      const all = [at()];
      for (const [range, bins] of [[500, 100], [2000, 100], [1000, 100]]) { hello(range, bins, 16); spoke(0, 16, 0, 0, [200, 0]);
        all.push(at()); }
      Object.assign(settings, {trailmotion: 'relative'}); picture.startTrails(true); all.push(at());
      Object.assign(settings, {trailmotion: 'true'}); picture.startTrails(true); all.push(at());
      Object.assign(settings, {trails: '30'}); picture.startTrails(true); all.push(at());
      picture.blank(); all.push(at());
      picture.startTrails(false); spoke(0, 16, 0, 0, [200, 0]); all.push(at());
      return all;"""
    is_true, gone = [0.75, 0], [0, 0]  # 15 s of 60
    assert picture(modules, script) == [
        is_true, is_true, is_true, is_true,  # 1000, 500, 2000 and 1000 m
        [0, 0.75], is_true, [0.5, 0], [None, None], gone,
    ]  # fmt: skip


def test_trails_beyond_a_shorter_range_return_with_the_longer_one(modules: Page) -> None:
    script = """hello(1000, 100, 1); spoke(90, 1, 200, 80); spoke(180, 1, 200, 30);
      hello(500, 100, 1); spoke(0, 10, 0, 0);
      hello(250, 100, 10); spoke(0, 13, 0, 0);
      hello(1000, 100, 13); spoke(0, 16, 0, 0);
      return [trail(90, 805), trail(180, 305)].map((one) => Number(one.toFixed(2)));"""
    assert picture(modules, script) == [0.75, 0.75]  # 15 s of 60


OTHERS = "import('./other_viewers.js').then(({{changesByOthers}}) => changesByOthers(...{}))"


@pytest.mark.parametrize(
    ("before", "after", "sent", "told"),
    [
        ({"gain": 45}, {"gain": 60}, {}, ["Gain set to 60 % by another viewer"]),
        ({"gain": 45}, {"gain": 60}, {"gain": 60}, []),
        ({"gain": 45}, {"gain": 45.00000001}, {}, []),
        ({"rpm": 24}, {"rpm": 48}, {}, ["Antenna set to 48 rev/min by another viewer"]),
        ({"pace": {"state": "run", "factor": 1}}, {"pace": {"state": "run", "factor": "max"}}, {},
         ["Speed set to as fast as possible by another viewer"]),
        ({"pace": {"state": "pause", "factor": 1}}, {"pace": {"state": "step", "factor": 1}}, {}, []),
        ({"pace": {"state": "pause", "factor": 1}}, {"pace": {"state": "pause", "factor": 2}}, {"pace": {"factor": 2}}, []),
    ],
)  # fmt: skip
def test_what_others_changed_is_told_in_words(
    modules: Page, before: dict[str, Any], after: dict[str, Any], sent: dict[str, Any], told: list[str]
) -> None:
    names = {"gain": ("number", "Gain", "%"), "rpm": ("number", "Antenna", "rev/min"), "pace": ("pace", "Pace", "")}
    definitions = [{"name": n, "kind": k, "label": label, "unit": unit} for n, (k, label, unit) in names.items()]
    assert modules.ask(OTHERS.format(json.dumps([definitions, before, after, sent, "nm"]))) == told


def test_the_default_scale_is_a_standard_one_with_at_most_six_rings(modules: Page) -> None:
    script = """import('./units.js').then(({scaleFor, ringStep}) => given.map((range) => {
        const scale = scaleFor(range, 'nm'); return [scale / 1852, Math.floor(scale / ringStep(scale, 'nm') + 1e-9)]; }))"""
    ranges = [5000, 12_000, 4000, 1000, 3000, 200_000, 10]  # of the shipped scenes, the README's, the longest and shortest
    got = modules.ask(f"(() => {{ const given = {ranges}; return {script}; }})()")
    assert [scale for scale, _ in got] == [3, 6, 3, 0.5, 1.5, 96, 0.125]
    assert all(2 <= rings <= 6 for _, rings in got)


def test_lag_is_measured_anew_after_a_change_of_pace(modules: Page) -> None:
    script = """import('./meter.js').then(({Meter}) => {
      const meter = new Meter();
      for (let k = 0; k < 100; k++) meter.spokes(1, 100 + k, 100 + k, 1);
      meter.spokes(1, 200, 200, 4);
      return meter.lag; })"""
    assert modules.ask(script) == 0


def test_lost_spokes_count_over_all_radars_of_the_page(modules: Page) -> None:
    script = """import('./sequence.js').then(({SequenceTracker}) => {
      const counts = new SequenceTracker();
      counts.hello('one', true); counts.spokes(500, 10); counts.spokes(515, 10); counts.gap(525, 7);
      counts.startFeed();
      const isNew = counts.hello('one', true); counts.spokes(9000, 10); counts.gap(9010, 1);
      return [isNew, counts.lost, counts.missing]; })"""
    assert modules.ask(script) == [True, 13, 5]
