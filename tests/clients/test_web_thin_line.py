"""The page on a line that carries less than the feed: what it asks for, how it goes on with that, and what it says."""

import json
import zlib
from typing import Any

import msgpack
import numpy as np
import pytest

from radar_service import wire
from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar
from tests.clients.screen import BARE, BROWSER, DRAWN

pytestmark = BROWSER

# A line carries `rate(now)` kB/s of a feed of 77 kB/s, as of 2502 bins a spoke. A new connection shares it for 2 s with what
# waits in the one before. Returns lags second by second, levels, and the times of changes.
LINE = """import('./thinning.js').then(({Thinning, VIEWS}) => {
  const FULL = 77, STEP = 0.02, thinning = new Thinning(), lags = [], levels = [], changes = [];
  let queue = [], waits = 0, old = 0, shared = 0, last = 0;
  const rate = (now) => RATE;
  for (let n = 1, next = 1; n * STEP < SECONDS; n++) {
    const now = n * STEP, bytes = FULL * thinning.view.share * STEP;
    queue.push([now, bytes]);
    waits += bytes;
    if (now > shared) old = 0;
    let room = rate(now) * STEP;
    const lost = Math.min(old, room / 2);
    old -= lost;
    room -= lost;
    while (queue.length && room > 0) {
      const taken = Math.min(queue[0][1], room);
      queue[0][1] -= taken;
      room -= taken;
      waits -= taken;
      if (queue[0][1] < 1e-9) [last] = queue.shift();
    }
    if (now < next) continue;
    next += 1;
    if (thinning.takes(now - last, now)) {
      [old, shared, queue, waits] = [Math.min(waits, 256), now + 2, [], 0];
      changes.push(next - 1);
    }
    lags.push(now - last);
    levels.push(thinning.level);
  }
  return {lags, levels, changes, last: VIEWS.length - 1};
})"""


def on_line(modules: Page, rate: str, seconds: int) -> dict[str, Any]:
    """How the page fares on a line; rate: in kB/s, an expression of `now`."""
    answer: dict[str, Any] = modules.ask(LINE.replace("RATE", rate).replace("SECONDS", str(seconds)))
    return answer


def test_a_line_that_carries_all_is_left_alone(modules: Page) -> None:
    assert on_line(modules, "100", 60)["changes"] == []


@pytest.mark.parametrize("rate", [60, 50, 40, 30, 27])
def test_the_feed_is_thinned_to_what_arrives(modules: Page, rate: int) -> None:
    """Never two seconds late, also where a finer view is tried in between."""
    fares = on_line(modules, str(rate), 120)
    assert max(fares["lags"]) < 2.0 and np.mean(fares["lags"]) < 0.7
    assert len(fares["changes"]) <= 10


@pytest.mark.parametrize("rate", [20, 10])
def test_on_a_line_that_carries_no_view_the_picture_stays_within_seconds(modules: Page, rate: int) -> None:
    fares = on_line(modules, str(rate), 120)
    assert fares["levels"][-1] == fares["last"] and max(fares["lags"]) < 12.0
    assert np.diff(fares["changes"]).min() >= 4  # a connection has time to begin


def test_all_returns_where_the_line_is_better_again(modules: Page) -> None:
    fares = on_line(modules, "now < 30 ? 30 : 200", 200)
    assert max(fares["levels"][:30]) >= 4 and fares["levels"][-1] == 0


def test_a_finer_view_that_is_too_much_is_tried_ever_more_seldom(modules: Page) -> None:
    waits = np.diff(on_line(modules, "40", 1200)["changes"])
    assert len(waits[waits > 15]) >= 3 and np.all(np.diff(waits[waits > 15]) > -15) and waits.max() > 150


def test_an_unknown_lag_changes_nothing(modules: Page) -> None:
    script = """import('./thinning.js').then(({Thinning}) => {
      const thinning = new Thinning();
      return [0.1, 5, null, 9, null, 20].map((lag, now) => thinning.takes(lag, now)).concat(thinning.level);
    })"""
    assert modules.ask(script) == [False, True, False, False, False, False, 5]


def test_merged_spokes_fill_the_rows_of_all_of_them(modules: Page) -> None:
    """As views say it: row k stands for `row_count` spokes from `row_first` on; the trail of each is at its own bearing."""
    script = """Promise.all([import('./polar.js'), import('./picture.js')]).then(([{Polar}, {Picture}]) => {
      const message = {bins: 2, data: new Uint8Array([1, 2, 3, 4]), index: 4, scan: 0, time: [0.5, 1.5], row_first: [0, 2],
                       row_count: [2, 1], azimuth: [36864, 49152], position: [[0, 0], [0, 0]]};
      const polar = new Polar(8, 2), bearings = [];
      polar.write(message);
      const picture = new Picture({trails: '0'});
      picture.layer.polar = polar;
      picture.isBlank = false;
      picture.layer.trails = {spoke: (video, bearing) => bearings.push(bearing / 2 / Math.PI * 8)};
      picture.trail(message, 0, 2);
      return [[...polar.video], [...polar.writtenAt].map((time) => time || 0), bearings];
    })"""
    video, times, bearings = modules.ask(script)
    assert video == [0] * 8 + [1, 2, 1, 2, 3, 4, 0, 0] and times == [0, 0, 0, 0, 0.5, 0.5, 1.5, 0]
    assert bearings == pytest.approx([4, 5, 6])


def test_compressed_messages_are_taken_in_their_order(modules: Page) -> None:
    """What follows them, and the end of the connection, waits until they are decompressed."""
    plain = {"type": "spokes", "epoch": "one", "count": 1, "time": [0.0], "bins": 2000}
    messages = [
        {"type": "hello", "protocol": 1, "epoch": "one"},
        *({**plain, "first": k, "data": zlib.compress(bytes([k]) * 2000), "compression": "deflate"} for k in range(3)),
        {**plain, "first": 3, "data": bytes([3]) * 2000},
        {"type": "gap", "epoch": "one", "first": 4, "count": 5},
    ]
    script = """import('./feed.js').then(({Feed}) => new Promise((done) => {
      const seen = [];
      const feed = new Feed(() => '', {
        hello: () => seen.push('hello'), spokes: ({data}) => seen.push([data.length, data[0]]), gap: () => seen.push('gap'),
        state: (name) => name === 'waiting' && done(seen),
      });
      feed.socket = {close: () => {}};
      feed.joining = true;
      for (const bytes of DATA) feed.receive(new Uint8Array(bytes).buffer);
      feed.inTurn(null, () => { feed.closed(1006, ''); feed.end(); });
    }))"""
    data = json.dumps([list(msgpack.packb(message)) for message in messages])
    assert modules.ask(script.replace("DATA", data)) == ["hello", *([2000, k] for k in range(4)), "gap"]


def test_spokes_that_the_page_did_not_wait_for_count_as_lost_and_announced(modules: Page) -> None:
    script = """import('./sequence.js').then(({SequenceTracker}) => {
      const counts = new SequenceTracker();
      counts.hello('one', true);
      counts.spokes(0, 10);
      counts.skips = true;
      counts.hello('one', true);
      counts.spokes(110, 10);
      counts.spokes(120, 10);
      return [counts.announced, counts.missing, counts.next, counts.skips];
    })"""
    assert modules.ask(script) == [100, 0, 130, False]


def late(radar: FakeRadar, seconds: float) -> dict[str, Any]:
    """Spokes that come later by so many seconds than those before."""
    first = radar.picture.azimuths
    message = radar.spokes(first, 60)
    shift = message["time"][-1] - radar.spokes(first - 60, 60)["time"][-1] + seconds
    return message | {"time": [time - shift for time in message["time"]]}


# After 5 s a page asks for the service's time: `ahead` [ms] brings its clock there. `ticks` counts its seconds.
CLOCK = """window.ticks = window.ahead = 0;
  const clock = performance.now.bind(performance), soon = requestAnimationFrame, every = setInterval;
  performance.now = () => clock() + ahead;
  window.requestAnimationFrame = (draw) => soon((time) => draw(time + ahead));
  window.setInterval = (call, ms) => every(() => { call(); ticks += 1; }, ms);"""
ASKED = """performance.getEntriesByType('resource').filter(
    ({name, responseEnd}) => name.endsWith('/api/health') && responseEnd > 0).length"""


LAG = "Number(document.getElementById('lag-text').textContent.split(' ')[0])"  # ms


def decided(page: Page) -> None:
    """Returns once the page has decided twice more."""
    page.wait(f"ticks > {page.ask('ticks') + 1}")


def ask_time(page: Page) -> None:
    """Returns once the page, which has the controls, has asked for the service's time, and decided."""
    page.wait("/[0-9a]/.test(document.getElementById('gain-value').value)")  # a figure, or "auto"
    before = page.ask(f"ahead += 5000, {ASKED}")
    page.wait(f"{ASKED} > {before}")
    decided(page)


def test_the_page_says_how_far_it_is_behind_and_asks_for_less(radar: FakeRadar, opened: Opened) -> None:
    """By the service's time: where that is not known, spokes that come at once before those that are in time are no lag."""
    page = opened(f"{BARE}&bins=512", first=CLOCK)
    ask_time(page)
    radar.send(late(radar, 3.2))
    page.wait(f"{LAG} > 3000")
    decided(page)
    assert page.ask("document.getElementById('banner').hidden") and len(radar.joined) == 1
    radar.health |= {"epoch": radar.epoch, "simulated_s": radar.spokes(radar.picture.azimuths - 60, 60)["time"][-1]}
    ask_time(page)
    radar.send(late(radar, 0.0))
    page.wait(f"{LAG} < 1000")
    decided(page)
    assert radar.joined[0] | {"bins": "512", "spokes": "1", "compress": "deflate"} == radar.joined[0]
    assert page.ask("document.getElementById('thinned-text').hidden")
    radar.send(late(radar, 3.2))
    page.wait("/^Behind by [3-9] s: the line/.test(document.getElementById('banner').textContent)")
    assert page.ask("document.getElementById('warning').classList.contains('mild')")
    page.wait("!document.getElementById('thinned-text').hidden")
    thinned = radar.joined[-1]
    assert int(thinned["bins"]) < 512 and "since" not in thinned and thinned["compress"] == "deflate"
    assert page.text("#thinned-text").startswith("Thinned: 512 bins")  # as the feed of this test sends them


def test_echoes_survive_a_thinner_feed(radar: FakeRadar, opened: Opened) -> None:
    """It goes on in the same epoch with other bins; what is on the screen stays."""
    page = opened(BARE)
    before = page.look()
    radar.picture.bins, radar.picture.step = 256, 2 * radar.picture.step
    radar.picture.video = radar.picture.video.reshape(radar.picture.azimuths, 256, 2).max(axis=-1)
    radar.next = radar.picture.azimuths  # one more scan
    radar.drop()
    page.wait(DRAWN.format("one:1440"))
    echoes = np.abs(page.look() - before).max(axis=-1) > 100
    assert echoes.mean() < 0.01


def test_lag_is_that_of_the_service_s_own_time(modules: Page) -> None:
    """A delay of the service itself is none of the line's, and one that lasts from the first spoke on is seen."""
    script = """import('./meter.js').then(({Meter}) => {
      const meter = new Meter(), lags = [];
      meter.spokes(6, 0, 7, 1);
      lags.push(meter.lag);
      meter.synchronise(5, 7);  // the service is at 5 s, and the newest spoke of 0 s
      meter.spokes(6, 1, 8, 1);
      lags.push(meter.lag);
      meter.synchronise(6, 13);  // it was late, by 5 s
      meter.spokes(6, 6, 13, 1);
      lags.push(meter.lag, meter.certainLag);
      meter.restart();
      meter.spokes(6, 7, 14, 1);
      return [...lags, meter.lag, meter.certainLag];
    })"""
    assert modules.ask(script) == [0, 5, 0, 0, 0, None]


def test_wire_and_page_name_the_same_compression(modules: Page) -> None:
    assert modules.ask("import('./feed.js').then(({COMPRESSION}) => COMPRESSION)") in wire.COMPRESSIONS
