"""Modules of the page for positions and times: view, framing, geographic positions, trails, playout."""

import json
from typing import Any

import numpy as np
import pytest

from radar_service.world.geo import geographic_from_map
from tests.clients.chromium import Page
from tests.clients.screen import BROWSER

pytestmark = BROWSER


def run(modules: Page, module: str, names: str, script: str, given: Any = None) -> Any:
    """Result of a function body that uses `names` of a module and `given`."""
    return modules.ask(f"import('./{module}.js').then(({{{names}}}) => {{ const given = {json.dumps(given)}; {script} }})")


@pytest.mark.parametrize("latitude_deg", [-71.0, 0.0, 50.3, 84.0])
def test_positions_equal_those_of_the_service(modules: Page, latitude_deg: float) -> None:
    rng = np.random.default_rng(7)
    points = rng.uniform(-200e3, 200e3, (40, 2))
    origin = (latitude_deg, 179.9)
    given = [points.tolist(), {"latitude_deg": origin[0], "longitude_deg": origin[1]}]
    result = run(modules, "geo", "geographic", "return given[0].map(([e, n]) => geographic(e, n, given[1]));", given)
    latitude, longitude = np.array(result).T
    expected = geographic_from_map(points, origin)
    across = np.cos(np.deg2rad(expected[:, 0]))
    millimetre = 1e-3 / 111e3  # degrees; Vincenty 1975 states 0.5 mm
    assert np.abs(latitude - expected[:, 0]).max() < millimetre
    assert (np.abs((longitude - expected[:, 1] + 180) % 360 - 180) * across).max() < millimetre


def test_position_text_is_as_on_a_chart(modules: Page) -> None:
    texts = run(
        modules, "geo", "positionText", "return given.map(positionText);", [[50.3, -1.4], [-0.99999999, 179.5], [0, 0]]
    )
    assert texts == ["50°18.000′ N\n001°24.000′ W", "01°00.000′ S\n179°30.000′ E", "00°00.000′ N\n000°00.000′ E"]


def test_slant_range_becomes_horizontal_range(modules: Page) -> None:
    script = """const origin = {latitude_deg: 0, longitude_deg: 0};
      return given.map((range) => geographicPosition({bearing: 0, range}, [0, 100], 30, origin)[0]);"""
    latitudes = run(modules, "geo", "geographicPosition", script, [50.0, 20.0])
    assert latitudes == pytest.approx(
        [float(geographic_from_map(np.array([0.0, y]), (0.0, 0.0))[0]) for y in (140.0, 100.0)]
    )


VIEW = (
    """const view = (zoom, centre) => new View({rim: {x: 300, y: 200, radius: 150}, range: 3000, up: 0.7, zoom, centre});"""
)


def test_bearings_leave_the_picture_at_its_rim_wherever_own_ship_is(modules: Page) -> None:
    script = f"""{VIEW} return [[1, {{x: 0, y: 0}}], [2, {{x: 900, y: -600}}], [8, {{x: 1500, y: 0}}]].map(([zoom, centre]) => {{
      const framed = view(zoom, centre), bearings = [...Array(90).keys()].map((k) => k * 4 * Math.PI / 180);
      return bearings.map((b) => [framed.toRim(b), ...framed.along(b, framed.toRim(b))]); }});"""
    centred, off, outside = (np.array(rays, dtype=float) for rays in run(modules, "view", "View", script))
    for rays in (centred, off, outside[~np.isnan(outside[:, 0])]):
        assert np.hypot(rays[:, 1] - 300, rays[:, 2] - 200) == pytest.approx(np.full(len(rays), 150), rel=1e-9)  # rounding
        assert np.all(rays[:, 0] > 0)
    ship = np.array([300 - 1500 * 8 * 0.05, 200])  # 0.05 pixels a metre at zoom 1; own ship is 600 pixels left of the middle
    assert np.count_nonzero(~np.isnan(outside[:, 0])) == pytest.approx(2 * np.rad2deg(np.arcsin(150 / 600)) / 4, abs=1)
    assert np.nanmin(outside[:, 0]) > 0 and ship[0] == -300


@pytest.mark.parametrize("point", [[300, 200], [330, 120], [210, 260]])
def test_zooming_keeps_the_position_at_the_pointer(modules: Page, point: list[float]) -> None:
    script = f"""{VIEW} return import('./framing.js').then(({{Framing}}) => {{
      const framing = new Framing(), now = () => view(framing.zoom, framing.centre);
      framing.dragBy(25, -40, now());
      const before = now().fromScreen(...given);
      framing.zoomBy(3, now(), given);
      return [before, now().fromScreen(...given), framing.zoom]; }});"""
    before, after, zoom = run(modules, "view", "View", script, point)
    assert zoom == 3
    assert after["range"] == pytest.approx(before["range"], rel=1e-9)  # rounding
    assert after["bearing"] == pytest.approx(before["bearing"], rel=1e-9)


def test_the_picture_stays_within_the_radar_s_range(modules: Page) -> None:
    script = f"""{VIEW} return import('./framing.js').then(({{Framing}}) => {{
      const framing = new Framing();
      framing.zoomBy(99, view(1, framing.centre));
      framing.dragBy(-9e4, 5e4, view(framing.zoom, framing.centre));
      return [framing.zoom, Math.hypot(framing.centre.x, framing.centre.y), framing.centre.x > 0, framing.centre.y > 0]; }});"""
    zoom, far, east, north = run(modules, "view", "View", script)
    assert (zoom, east, north) == (16, True, True)
    assert far == pytest.approx(3000, rel=1e-9)  # rounding


# A picture of 720 azimuths to 5120 m: cells of the grid are 10 m.
TRAIL = """const trails = new Trails(60, {}, 5120, 720);
  const grid = {{first: 10, step: 20}}, east = Math.PI / 2;
  const echo = (bearing, range, position, time) => {{
    const video = new Uint8Array(256);
    if (range !== null) video[Math.floor(range / 20)] = 200;
    trails.spoke(video, bearing, grid, position, time);
  }};"""


def trail(modules: Page, is_true: bool, script: str) -> Any:
    return run(modules, "trails", "Trails", TRAIL.format(str(is_true).lower()) + script)


@pytest.mark.parametrize("is_true", [False, True])
def test_trails_of_a_target_at_rest_while_own_ship_moves(modules: Page, is_true: bool) -> None:
    script = """for (let t = 0; t <= 20; t += 0.5) echo(east, 1010 - 20 * t, [20 * t, 0], t);
      return [610, 810, 1010, 1210].map((range) => trails.at(east, range));"""
    here, between, ahead, beyond = trail(modules, is_true, script)  # as seen from own ship's last position
    assert here == pytest.approx(1.0, abs=1 / 200)  # a stamp of 200; both motions show the target at its position
    assert (between > 0) == (ahead > 0) == (not is_true)  # relative motion draws the path relative to own ship
    assert beyond == 0


def test_trails_fade_and_end(modules: Page) -> None:
    script = """echo(east, 1010, [0, 0], 0);
      return [0, 15, 45, 59, 61, 300].map((t) => { for (let s = 0; s <= t; s += 0.25) trails.advance(Math.floor(s / 0.3));
        return trails.at(east, 1010); });"""
    script = script.replace("for (let s = 0;", "for (let s = trails.tick * 0.3;")
    assert trail(modules, False, script) == pytest.approx([1, 0.75, 0.25, 1 / 60, 0, 0], abs=1 / 100)  # two stamps of 200


def test_old_trails_do_not_return_when_stamps_repeat(modules: Page) -> None:
    script = """for (let t = 0; t < 20; t += 0.3) echo(t / 4, 1010, [0, 0], t);
      const left = [];
      for (let t = 20; t < 200; t += 0.3) {
        echo(0, null, [0, 0], t);
        if (t > 81) left.push([...Array(100).keys()].some((k) => trails.at(k / 20, 1010) > 0));
      }
      return left.some((one) => one);"""
    assert trail(modules, False, script) is False


def test_trails_behind_own_ship_do_not_appear_ahead(modules: Page) -> None:
    script = """for (let b = 0; b < 720; b++) echo(b * Math.PI / 360, 3010, [0, 0], 0);
      const before = trails.at(east, 3010);
      for (let x = 0; x <= 7000; x += 70) echo(0, null, [x, 0], 0.01);
      return [before, Math.max(...[...Array(1000).keys()].map((k) => trails.at(east, 5 * k)))];"""
    before, after = trail(modules, True, script)
    assert (before, after) == (1, 0)


def test_a_trail_is_as_wide_as_its_azimuth(modules: Page) -> None:
    script = """echo(east, 4810, [0, 0], 0);
      const width = Math.PI / 360;
      return [-0.7, -0.4, 0, 0.4, 0.7].map((k) => trails.at(east + k * width, 4810) > 0);"""
    assert trail(modules, False, script) == [False, True, True, True, False]


# Batches of 5 spokes at 288 a second, 17.4 ms apart, late by up to 15 ms; frames at 60 Hz.
PLAYOUT = """const shown = [], frames = [];
  let factor = 1;
  const playout = new Playout((message, from, to) => shown.push(...message.time.slice(from, to)), () => factor);
  const batch = (k) => ({time: [0, 1, 2, 3, 4].map((n) => (5 * k + n) / 288)});
  """


def test_spokes_in_bunches_are_shown_evenly(modules: Page) -> None:
    late = np.random.default_rng(3).uniform(0, 0.015, 400).tolist()
    script = f"""{PLAYOUT}
      const arriving = given.map((late, k) => [5 * k / 288 + late, batch(k)]);
      for (let at = 0; at < 6.9; at += 1 / 60) {{
        while (arriving.length && arriving[0][0] <= at) playout.push(...arriving.shift().reverse());
        const before = shown.length;
        playout.release(at);
        frames.push(shown.length);
      }}
      return [frames, shown];"""
    frames, shown = run(modules, "playout", "Playout", script, late)
    steps = np.diff(frames[30:])
    assert shown == sorted(set(shown))
    assert steps.min() >= 4 and steps.max() <= 5  # 4.8 spokes a frame; shown on arrival it would be 0, 5 or 10


def test_spokes_wait_no_longer_than_necessary(modules: Page) -> None:
    script = f"""{PLAYOUT}
      const counts = [];
      const after = (at) => {{ playout.release(at); counts.push(shown.length); }};
      for (let k = 0; k < 100; k++) playout.push(batch(k), 0.001 * k);  // the history, all at once
      after(0.16);
      for (let k = 100; k < 104; k++) playout.push(batch(k), 60 + 5 * k / 288);  // a minute later, after a pause
      after(60 + 515 / 288);  // evenly again: not all are due
      after(62);
      factor = null;  // as fast as possible
      playout.push(batch(120), 62);
      after(62);
      playout.push(batch(105), 63);
      playout.clear();
      return counts;"""
    assert run(modules, "playout", "Playout", script) == [500, 508, 520, 525]  # 519 are due after 40 ms, or 11.5 spokes


def test_spokes_that_cannot_be_shown_do_not_stop_later_ones(modules: Page) -> None:
    script = """const shown = [];
      const show = ({time}) => { if (time[0] === 1) throw new Error("broken"); shown.push(time[0]); };
      const playout = new Playout(show, () => null);
      try { playout.push({time: [1]}, 0); } catch (fault) { shown.push(fault.message); }
      playout.push({time: [2]}, 1);
      return shown;"""
    assert run(modules, "playout", "Playout", script) == ["broken", 2]


def test_vectors_of_the_truth_are_over_ground_or_through_the_water(modules: Page) -> None:
    """A buoy 1000 m north in a stream of 5 m/s to the east: through the water it goes west, by 300 m in a minute."""
    script = """const view = new View({rim: {x: 300, y: 200, radius: 150}, range: 3000, up: 0, zoom: 1, centre: {x: 0, y: 0}});
      const buoy = {name: 'b', visible: true, extent: 0, range: 1000, azimuth: 0, position: [0, 1000, 0], velocity: [0, 0, 0]};
      const truth = {own_ship: {position: [0, 0, 0]}, bodies: [buoy]}, context = {measureText: () => ({width: 9})};
      return import('./truth.js').then(({layTruth}) => [[0, 0], [5, 0]].map((drift) => {
        const {marks} = layTruth(context, view, truth, [], drift);
        return [marks[0].ahead, view.toScreen(Math.atan2(-300, 1000), Math.hypot(300, 1000))]; }));"""
    (rest, _), (ahead, expected) = run(modules, "view", "View", script)
    assert rest is None and ahead == pytest.approx(expected, abs=1e-9)  # rounding, pixels
