"""Messages become whole scans; samples become power and brightness."""

import asyncio
import math

import numpy as np
import pytest

from clients.ppi import FeedClient, FeedError, ScanCollector, brightness, collect_scans, power_from_samples
from tests.clients import fake_feed
from tests.clients.fake_feed import DATA, GREETING, Script, batch, collected, gap, hello, picture, running


def test_a_scan_begins_anywhere_and_wraps() -> None:
    turning = [batch(50, 22, heading_deg=10.0), batch(72, 40, heading_deg=20.0), batch(112, 20, heading_deg=30.0)]
    collector = collected([GREETING, *turning])
    (scan,) = collector.scans
    assert (scan.first, scan.missing, collector.done) == (50, 0, 1)
    np.testing.assert_array_equal(scan.ppi.polar, DATA)
    assert scan.time[49] == 121 / 30.0 and scan.time[50] == 50 / 30.0
    assert scan.position[3].tolist() == [75.0, -5.0]
    assert math.degrees(scan.newest_heading) == pytest.approx(30.0, abs=0.003)  # half of 1/65536 turn
    assert math.degrees(scan.heading[60]) == pytest.approx(10.0, abs=0.003)
    assert collector.current is not None and collector.current.first == 122  # the next one has begun in the last batch
    assert collector.spokes == 72 + 10


def test_a_radar_may_lose_its_heading() -> None:
    (scan,) = collected([GREETING, batch(0, 36, heading_deg=20.0), batch(36, 36, heading_deg=math.nan)]).scans
    assert np.isnan(scan.heading).nonzero()[0].tolist() == list(range(36, 72))
    assert math.degrees(scan.newest_heading) == pytest.approx(20.0, abs=0.003)  # half of 1/65536 turn
    (scan,) = collected([GREETING, batch(0, 72, heading_deg=math.nan)]).scans
    assert math.isnan(scan.newest_heading)


def test_a_scan_with_losses_is_whole_and_counts_missing_azimuths() -> None:
    announced = collected([GREETING, batch(0, 30), gap(GREETING, 30, 20), batch(50, 22)])
    silent = collected([GREETING, batch(0, 30), batch(50, 22)])
    at_the_end = collected([GREETING, batch(0, 30), batch(30, 22), gap(GREETING, 52, 20)])
    for collector, rows in ((announced, slice(30, 50)), (silent, slice(30, 50)), (at_the_end, slice(52, 72))):
        (scan,) = collector.scans
        assert scan.missing == 20 and not scan.ppi.filled[rows].any()
        assert np.isnan(scan.time[rows]).all() and np.isnan(scan.time).sum() == 20


def test_scans_follow_each_other_and_a_long_loss_makes_no_empty_scans() -> None:
    messages = [GREETING, *(batch(first, 36) for first in range(0, 216, 36))]
    assert [scan.first for scan in collected(messages).scans] == [0, 72, 144]
    assert [scan.first for scan in collected(messages, keep=1).scans] == [144]
    long = collected([GREETING, batch(0, 30), gap(GREETING, 30, 400), batch(430, 2), batch(432, 70)])
    assert [(scan.first, scan.missing) for scan in long.scans] == [(0, 42), (430, 0)]
    silent = collected([GREETING, batch(0, 30), batch(430, 2), batch(432, 70)])
    assert [(scan.first, scan.missing) for scan in silent.scans] == [(0, 42), (430, 0)]


def test_repeated_and_late_spokes_change_no_scan() -> None:
    wrong = batch(10, 5) | {"data": bytes(5 * 100)}
    messages = [GREETING, batch(0, 20), batch(10, 20), wrong, batch(30, 42), batch(0, 20), batch(72, 1)]
    assert collected(messages[:4]).spokes == 30
    collector = collected(messages)
    np.testing.assert_array_equal(collector.scans[0].time, np.arange(72) / 30.0)
    np.testing.assert_array_equal(collector.scans[0].ppi.polar, DATA)
    assert collector.done == 1 and collector.current is not None and collector.current.first == 72


def test_a_spoke_from_before_the_scan_does_not_fill_its_gaps() -> None:
    collector = collected([GREETING, batch(50, 12), batch(40, 5), batch(62, 10), batch(72, 40), gap(GREETING, 112, 10)])
    assert np.flatnonzero(~collector.scans[0].ppi.filled).tolist() == list(range(40, 50))


def test_the_same_hello_again_changes_nothing() -> None:
    assert collected([GREETING, batch(0, 40), GREETING, batch(40, 32)]).done == 1


def test_a_new_epoch_starts_over() -> None:
    other = hello("b", azimuths=36, bins=100)
    data = picture(36)
    half = [fake_feed.spokes(other, data, 0, 18), fake_feed.spokes(other, data, 18, 18)]
    collector = collected([GREETING, batch(0, 72), batch(72, 10), GREETING, other, *half])
    assert [(scan.azimuths, scan.first) for scan in collector.scans] == [(36, 0)]
    assert (collector.restarts, collector.done) == (1, 1)


def test_a_radar_too_large_to_hold_is_refused_before_memory_is_taken() -> None:
    vast = hello(azimuths=10**9, bins=10**6)
    with pytest.raises(FeedError, match="1000000000 azimuths"):
        collected([vast, batch(0, 2)])


def test_collecting_reports_progress_and_refuses_rows_beyond_the_scan() -> None:
    reports: list[tuple[int, int]] = []

    async def collect(url: str) -> ScanCollector:
        async with FeedClient(url, timeout=10.0) as client:
            return await collect_scans(client, 1, progress=lambda done, total: reports.append((done, total)))

    with running(Script([GREETING, batch(60, 12), gap(GREETING, 72, 30), batch(102, 40)], wait=True)) as feed:
        collector = asyncio.run(collect(feed.url))
    assert reports == [(0, 72), (12, 72), (42, 72), (82, 72)] and collector.scans[0].missing == 30
    with running(Script([GREETING, batch(0, 2) | {"index": 71}])) as feed, pytest.raises(FeedError, match="rows 0 to 71"):
        asyncio.run(collect(feed.url))


@pytest.mark.parametrize("encoding", ["u8-log", "f16", "f32", "c64"])
def test_every_untouched_encoding_gives_the_same_watts(encoding: str) -> None:
    power = np.array([[1e-9, 3.2e-13, 0.0], [5e-11, 1e-15, 2e-9]])
    with np.errstate(divide="ignore"):
        level_db = 10 * np.log10(power)
    sent = {
        "u8-log": np.where(power > 0, np.rint((level_db + 180.0) / 0.75), 0).astype(np.uint8),
        "f16": level_db.astype(np.float16),
        "f32": power.astype(np.float32),
        "c64": (np.sqrt(power) * np.exp(1j)).astype(np.complex64),
    }[encoding]
    watts = power_from_samples(sent, hello(encoding=encoding)["encoding"])
    # half a step of 0.75 dB, 9 %; float16 near -150 has steps of 0.125 dB, half of one is 1.5 %; float32 rounding
    rtol = {"u8-log": 0.0902, "f16": 0.0145, "f32": 1e-7, "c64": 1e-6}[encoding]
    np.testing.assert_allclose(watts, power, rtol=rtol, atol=0)


def test_video_is_shown_unchanged_and_power_in_decibels_with_empty_rows_dark() -> None:
    with pytest.raises(ValueError, match="u8 is brightness"):
        power_from_samples(DATA, GREETING["encoding"])
    np.testing.assert_array_equal(brightness(collected([GREETING, batch(0, 72)]).scans[0]), DATA)
    greeting = hello(encoding="f16", bins=2)
    level_db = np.tile(np.array([-90.0, -120.0], dtype=np.float16), (72, 1))
    message = fake_feed.spokes(greeting, level_db, 0, 40)
    scan = collected([greeting, message, gap(greeting, 40, 32)]).scans[0]
    bright = brightness(scan, 60.0)
    assert bright[:40, 0].tolist() == [255] * 40 and set(bright[:40, 1].tolist()) <= {127, 128}
    assert not bright[40:].any()
