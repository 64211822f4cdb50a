"""The Python client against a scripted feed on loopback: what comes, what is lost, coming back, the command."""

import asyncio
import json
import math
import os
import signal
import socket
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import radar_service as rs
from clients.ppi import (
    FeedClient,
    FeedError,
    Ledger,
    ScanCollector,
    brightness,
    collect_scans,
    feed_url,
    power_from_samples,
    spokes,
)
from clients.ppi.__main__ import main
from radar_service.display.picture import UNSEEN, colour_map
from radar_service.stream import wire
from tests.clients import fake_feed
from tests.clients.fake_feed import TARGETS, Script, gap, hello, picture, running

DATA = picture()
GREETING = hello()


def batch(first: int, count: int, greeting: dict[str, Any] = GREETING, **options: Any) -> dict[str, Any]:
    return fake_feed.spokes(greeting, DATA, first, count, **options)


def numbers(url: str, count: int, **options: Any) -> list[int]:
    """Numbers of the first `count` spokes of a feed."""
    found = []
    for spoke in spokes(url, timeout=10.0, **options):
        found.append(spoke.number)
        if len(found) == count:
            break
    return found


def ending(url: str, **options: Any) -> FeedError:
    """How a feed ends that is followed to its end; a client that never gives up fails after ten seconds."""

    async def follow() -> None:
        async with FeedClient(url, timeout=10.0, **options) as client:
            async for _ in client.spokes():
                pass

    with pytest.raises(FeedError) as fault:
        asyncio.run(asyncio.wait_for(follow(), 10.0))
    return fault.value


# Addresses


@pytest.mark.parametrize(
    ("short", "whole"),
    [
        ("ws://h:1", "ws://h:1/api/radars/0/feed?bins=9"),
        ("h:1", "ws://h:1/api/radars/0/feed?bins=9"),
        ("http://h:1/", "ws://h:1/api/radars/0/feed?bins=9"),
        ("https://h", "wss://h/api/radars/0/feed?bins=9"),
        ("ws://h:1/api/radars/3", "ws://h:1/api/radars/3/feed?bins=9"),
        ("ws://h:1/api/radars/3/feed?bins=4&truth=1", "ws://h:1/api/radars/3/feed?bins=9&truth=1"),
        ("ws://h:1/behind/a/proxy", "ws://h:1/behind/a/proxy?bins=9"),
    ],
)
def test_short_addresses_mean_the_feed_of_radar_0(short: str, whole: str) -> None:
    assert feed_url(short, bins="9") == whole


@pytest.mark.parametrize("bad", ["ftp://h/x", "ws://", ""])
def test_what_is_no_address_is_refused(bad: str) -> None:
    with pytest.raises(FeedError, match="ws://HOST:PORT"):
        feed_url(bad)


# The ledger


def test_ledger_counts_announced_and_unannounced_losses_apart() -> None:
    ledger = Ledger()
    ledger.hello("a", None)
    assert ledger.spokes(100, 10) == 0  # came in the middle: nothing is lost
    ledger.gap(110, 5)
    assert ledger.spokes(115, 5) == 0
    assert ledger.spokes(123, 7) == 0  # 120 to 122 never came
    assert ledger.spokes(128, 4) == 2  # 128 and 129 again
    assert (ledger.received, ledger.announced, ledger.holes, ledger.repeats) == (24, 5, 3, 2)
    assert (ledger.next, ledger.lost) == (132, 8)
    assert ledger.spokes(0, 3) == 3 and ledger.next == 132  # late comers


def test_ledger_knows_a_gap_that_overlaps_what_came_and_one_after_a_hole() -> None:
    ledger = Ledger()
    ledger.hello("a", 0)
    ledger.spokes(0, 10)
    ledger.gap(8, 4)
    ledger.gap(20, 1)
    assert (ledger.announced, ledger.holes, ledger.next) == (3, 8, 21)


def test_ledger_begins_a_new_epoch_where_it_must_begin() -> None:
    ledger = Ledger()
    ledger.hello("a", None)
    ledger.spokes(50, 1)
    ledger.hello("a", 0)  # the same epoch again changes nothing
    assert ledger.next == 51
    ledger.hello("b", 0)
    ledger.spokes(2, 1)
    assert (ledger.holes, ledger.epochs, ledger.received) == (2, 2, 2)


# The feed


def test_spokes_carry_what_was_sent() -> None:
    with running(Script([GREETING, batch(70, 2, heading_deg=40.0)])) as feed:
        received = []
        with pytest.raises(FeedError, match="ended the feed"):
            for spoke in spokes(feed.url, timeout=10.0):
                received.append(spoke)
    assert [s.number for s in received] == [70, 71]
    last = received[1]
    assert (last.epoch, last.scan, last.index, last.time, last.speed) == ("a", 0, 71, 71 / 30.0, 3.5)
    assert last.position == (71.0, -5.0) and not last.blind
    # the wire has whole 1/65536 turns: half of one is 4.8e-5 rad
    assert last.azimuth == pytest.approx(2 * math.pi * 71 / 72, abs=4.8e-5)
    assert last.heading == pytest.approx(math.radians(40.0), abs=4.8e-5)
    assert last.course == pytest.approx(0.5, abs=4.8e-5)
    np.testing.assert_array_equal(last.samples, DATA[71])
    np.testing.assert_allclose(last.range, (np.arange(100) + 0.5) * 20.0, rtol=1e-15)


def test_what_is_asked_for_reaches_the_radar() -> None:
    with running(Script([GREETING, batch(5, 1)])) as feed:
        assert numbers(feed.url, 1, encoding="f32", bins=50, truth=True, mode="lossless", since=("a", 5)) == [5]
    assert feed.queries == [{"encoding": "f32", "bins": "50", "truth": "1", "mode": "lossless", "since": "a:5"}]


def test_repeated_spokes_come_out_once() -> None:
    with running(Script([GREETING, batch(0, 4), batch(2, 4), batch(1, 3), batch(6, 1)])) as feed:
        assert numbers(feed.url, 7) == [0, 1, 2, 3, 4, 5, 6]


def test_reconnecting_goes_on_where_it_broke_off() -> None:
    other = hello("b")
    scripts = (
        Script([GREETING, batch(10, 4)], code=1011),
        Script([GREETING, batch(14, 2)]),
        Script([other, gap(other, 0, 3), batch(3, 2, other)]),
    )
    client_of: dict[str, FeedClient] = {}

    async def follow(url: str) -> list[tuple[str, int]]:
        client = client_of["it"] = FeedClient(url, reconnect=True, timeout=10.0, backoff=(0.0,))
        found: list[tuple[str, int]] = []
        async with client:
            async for spoke in client.spokes():
                found.append((spoke.epoch, spoke.number))
                if len(found) == 8:
                    break
        return found

    with running(*scripts) as feed:
        found = asyncio.run(follow(feed.url))
    assert found == [("a", n) for n in range(10, 16)] + [("b", 3), ("b", 4)]
    assert [query.get("since") for query in feed.queries] == [None, "a:14", "a:16"]
    ledger = client_of["it"].ledger
    assert (ledger.announced, ledger.holes, ledger.received, client_of["it"].reconnections) == (3, 0, 8, 2)


def test_a_missing_beginning_of_a_watched_epoch_is_a_hole() -> None:
    other = hello("b")

    async def follow(url: str) -> Ledger:
        client = FeedClient(url, timeout=10.0)
        with pytest.raises(FeedError):
            async for _ in client.spokes():
                pass
        return client.ledger

    with running(Script([GREETING, batch(10, 4), other, batch(2, 2, other)])) as feed:
        ledger = asyncio.run(follow(feed.url))
    assert (ledger.holes, ledger.received, ledger.epochs) == (2, 6, 2)


def test_a_missing_beginning_is_a_hole_for_a_client_that_comes_back_too() -> None:
    async def follow(url: str, since: tuple[str, int] | None) -> Ledger:
        async with FeedClient(url, timeout=10.0, since=since) as client:
            await anext(client.spokes())
            return client.ledger

    for since, holes in ((("z", 9), 3), (None, 0)):
        with running(Script([GREETING, batch(3, 1)])) as feed:
            assert asyncio.run(follow(feed.url, since)).holes == holes


@pytest.mark.parametrize(
    ("script", "text", "retry"),
    [
        (Script([GREETING, {"type": "bye", "epoch": "a", "reason": "the service stops"}]), "the service stops", True),
        (Script([{"type": "bye", "epoch": "", "reason": "no such bins"}], code=4400), "refused: no such bins", False),
        (Script([GREETING], code=1011), "1011", True),
        (Script([GREETING | {"protocol": 99}]), "protocol 99", False),
        (Script([b"rubbish"]), "not a message", False),
        (Script(["text"]), "not a message", False),
        (Script([GREETING, {"type": "spokes", "epoch": "a"}]), "'count'", False),
        (Script([GREETING, batch(0, 2) | {"count": 3}]), "3 spokes with 2 azimuths", False),
        (Script([GREETING, batch(0, 2) | {"data": b"short"}]), "5 bytes", False),
        (Script([batch(0, 2)]), "without its hello", False),
        (Script([GREETING, batch(0, 2, hello("z"))]), "without its hello", False),
    ],
)
def test_a_feed_that_ends_says_why(script: Script, text: str, retry: bool) -> None:
    with running(script) as feed, pytest.raises(FeedError, match=text) as fault:
        numbers(feed.url, 10)
    assert fault.value.retry is retry and feed.url in str(fault.value)


def test_silence_ends_a_feed() -> None:
    with running(Script([GREETING], wait=True)) as feed, pytest.raises(FeedError, match="nothing came for 0.05 s") as fault:
        list(spokes(feed.url, timeout=0.05))
    assert fault.value.retry


def test_a_refusal_is_not_asked_again() -> None:
    scripts = (Script([GREETING, batch(0, 1)]), Script([{"type": "bye", "epoch": "", "reason": "full"}], code=4403))
    with running(*scripts) as feed:
        assert "refused: full" in str(ending(feed.url, reconnect=True, backoff=(0.0,)))
    assert len(feed.queries) == 2


def test_no_service_and_no_such_radar_are_told_apart() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound and not listening: refuses
        fault = ending(f"ws://127.0.0.1:{taken.getsockname()[1]}", reconnect=True, backoff=(0.0,))
    assert "is the service running" in str(fault) and fault.retry  # but not by itself: it never was there
    with running() as feed:
        fault = ending(f"{feed.url}/api/radars/9/feed")
        assert "no such radar" in str(fault) and feed.url.replace("ws", "http") + "/api/radars lists" in str(fault)
        assert not fault.retry
        fault = ending(f"{feed.url}/api/radars/5/feed")
        assert "HTTP 500: the engine died" in str(fault) and fault.retry
    with pytest.raises(ValueError, match='"u9" is not one of u8'):
        FeedClient("ws://h", encoding="u9")


def test_leaving_the_loop_leaves_the_radar() -> None:
    with running(Script([GREETING, batch(0, 5)], wait=True)) as feed:
        assert numbers(feed.url, 2) == [0, 1]
        assert feed.left.wait(10)


# Scans


def collected(messages: list[dict[str, Any]], keep: int | None = None) -> ScanCollector:
    collector = ScanCollector(keep)
    for message in messages:
        collector.take(message)
    return collector


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


def test_a_scan_with_losses_is_whole_and_says_what_is_missing() -> None:
    announced = collected([GREETING, batch(0, 30), gap(GREETING, 30, 20), batch(50, 22)])
    silent = collected([GREETING, batch(0, 30), batch(50, 22)])
    at_the_end = collected([GREETING, batch(0, 30), batch(30, 22), gap(GREETING, 52, 20)])
    for collector, rows in ((announced, slice(30, 50)), (silent, slice(30, 50)), (at_the_end, slice(52, 72))):
        (scan,) = collector.scans
        assert scan.missing == 20 and not scan.ppi.filled[rows].any()
        assert np.isnan(scan.time[rows]).all() and np.isnan(scan.time).sum() == 20


def test_scans_follow_each_other_and_a_long_loss_makes_no_empty_ones() -> None:
    messages = [GREETING, *(batch(first, 36) for first in range(0, 216, 36))]
    assert [scan.first for scan in collected(messages).scans] == [0, 72, 144]
    assert [scan.first for scan in collected(messages, keep=1).scans] == [144]
    long = collected([GREETING, batch(0, 30), gap(GREETING, 30, 400), batch(430, 2), batch(432, 70)])
    assert [(scan.first, scan.missing) for scan in long.scans] == [(0, 42), (430, 0)]
    silent = collected([GREETING, batch(0, 30), batch(430, 2), batch(432, 70)])
    assert [(scan.first, scan.missing) for scan in silent.scans] == [(0, 42), (430, 0)]


def test_repeats_and_late_comers_harm_no_scan() -> None:
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


def test_collecting_tells_its_progress_and_refuses_what_does_not_fit() -> None:
    told: list[tuple[int, int]] = []

    async def collect(url: str) -> ScanCollector:
        async with FeedClient(url, timeout=10.0) as client:
            return await collect_scans(client, 1, progress=lambda done, total: told.append((done, total)))

    with running(Script([GREETING, batch(60, 12), gap(GREETING, 72, 30), batch(102, 40)], wait=True)) as feed:
        collector = asyncio.run(collect(feed.url))
    assert told == [(0, 72), (12, 72), (42, 72), (82, 72)] and collector.scans[0].missing == 30
    with running(Script([GREETING, batch(0, 2) | {"index": 71}])) as feed, pytest.raises(FeedError, match="rows 0 to 71"):
        asyncio.run(collect(feed.url))


# Brightness


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
    found = power_from_samples(sent, hello(encoding=encoding)["encoding"])
    # half a step of 0.75 dB, 9 %; float16 near -150 has steps of 0.125 dB, half of one is 1.5 %; float32 rounding
    rtol = {"u8-log": 0.0902, "f16": 0.0145, "f32": 1e-7, "c64": 1e-6}[encoding]
    np.testing.assert_allclose(found, power, rtol=rtol, atol=0)


def test_video_is_shown_as_it_is_and_power_in_decibels_with_empty_rows_dark() -> None:
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


# The command


def targets_in(png: bytes, up_deg: float, range_max: float = 2000.0) -> None:
    """Each target where theory puts it in a picture of the command, and nothing else as bright."""
    image = np.asarray(Image.open(BytesIO(png))).astype(int)
    size = image.shape[0]
    radius = (size - 2 * round(0.052 * size)) / 2
    lit: NDArray[np.bool_] = np.abs(image - colour_map()[255]).sum(axis=2) < 60
    for bearing_deg, there in TARGETS:
        if there > range_max:
            continue
        angle, far = math.radians(bearing_deg - up_deg), there / range_max * radius
        y, x = size / 2 - 0.5 - far * math.cos(angle), size / 2 - 0.5 + far * math.sin(angle)
        i0, j0 = round(y) - 24, round(x) - 24
        found = np.argwhere(lit[i0 : i0 + 49, j0 : j0 + 49]) + (i0, j0)
        # a range bin is 20 m and the target's middle is known to half of one; a pixel of rounding
        assert np.abs(found.mean(axis=0) - (y, x)).max() <= 10.0 / range_max * radius + 1.0
        lit[i0 : i0 + 49, j0 : j0 + 49] = False
    assert not lit.any()


@pytest.mark.parametrize("heading_deg", [0.0, 70.0])
@pytest.mark.parametrize("head_up", [False, True])
def test_command_draws_targets_where_they_belong(tmp_path: Path, heading_deg: float, head_up: bool) -> None:
    out = tmp_path / "ppi.png"
    messages = [GREETING, batch(40, 32, heading_deg=heading_deg), batch(72, 40, heading_deg=heading_deg)]
    with running(Script(messages, wait=True)) as feed:
        status = main([feed.url, "--out", str(out), "--size", "600", *(["--head-up"] if head_up else [])])
    assert status == 0
    targets_in(out.read_bytes(), heading_deg if head_up else 0.0)


def test_command_draws_a_shorter_range_and_comes_back_after_a_break(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "ppi.png"
    with running(Script([GREETING, batch(0, 30)], code=1011), Script([GREETING, batch(30, 42)], wait=True)) as feed:
        assert main([feed.url, "--out", str(out), "--range", "1500"]) == 0
    targets_in(out.read_bytes(), 0.0, 1500.0)
    said = capsys.readouterr()
    assert "close code 1011); trying again in 0.25 s" in said.err and "back after 0." in said.err
    assert "tried to come back 1 time(s)" in said.out


def test_coming_back_is_given_up_after_a_silence() -> None:
    told: list[str] = []
    with running(Script([GREETING, batch(0, 30)])) as feed:  # the second connection finds no script
        fault = ending(feed.url, reconnect=True, patience=0.4, backoff=(0.25,), notice=told.append)
    assert "ended the feed" in str(fault) and len(feed.queries) == 2
    assert told == ["the radar ended the feed: without a word (close code 1001); trying again in 0.25 s"]


def test_command_saves_all_scans_as_arrays_and_tells_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, npz = tmp_path / "a.png", tmp_path / "a.npz"
    greeting = hello(encoding="u8-log")
    messages = [greeting, batch(0, 50, greeting), gap(greeting, 50, 10), batch(60, 12, greeting)]
    # the second scan begins with the first spoke after a hole, at 75
    messages += [batch(75, 69, greeting), batch(144, 3, greeting)]
    with running(Script(messages, wait=True)) as feed:
        asked = [feed.url, "--scans", "2", "--encoding", "u8-log", "--out", str(out), "--npz", str(npz), "--bins", "100"]
        asked += ["--mode", "lossless"]
        assert main(asked) == 0
    assert feed.queries == [{"encoding": "u8-log", "bins": "100", "mode": "lossless"}]
    with np.load(npz) as saved:
        assert saved["samples"].shape == (2, 72, 100) and saved["samples"].dtype == np.uint8
        assert (saved["spoke"][0] < 0).sum() == 10 and (saved["spoke"][1] >= 0).all()
        assert saved["number"].tolist() == [0, 1]
        np.testing.assert_array_equal(saved["samples"][1], DATA)
        assert saved["time"][1, 0] == 144 / 30.0
        assert np.isnan(saved["heading"][0, 50:60]).all()
        np.testing.assert_allclose(saved["range"], (np.arange(100) + 0.5) * 20.0)
        np.testing.assert_allclose(saved["azimuth"], np.arange(72) * 2 * np.pi / 72)
        assert json.loads(str(saved["hello"]))["epoch"] == "a"
    said = capsys.readouterr()
    assert "2 scan(s) of 72 azimuths" in said.out and "10 announced as lost, 3 lost without a word" in said.out
    assert said.err == ""  # no progress bar where there is no terminal


def test_a_reader_that_has_gone_ends_the_command_without_a_word(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    out = tmp_path / "a.png"
    with running(Script([GREETING, batch(0, 72)], wait=True)) as feed, os.fdopen(writer, "wb") as pipe:
        command = [sys.executable, "-m", "clients.ppi", feed.url, "--out", str(out)]
        ended = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, cwd=Path(__file__).parents[2])
    assert (ended.returncode, ended.stderr) == (141, b"") and out.is_file()


def test_command_writes_only_what_it_is_told_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with running(Script([GREETING, batch(0, 72)], wait=True)) as feed:
        assert main([feed.url]) == 0
    assert "wrote nothing: --out FILE" in capsys.readouterr().out and not list(tmp_path.iterdir())


@pytest.mark.parametrize("encoding", ["u8", "f32", "c64"])
def test_saved_scans_are_loaded_as_those_of_the_simulator(tmp_path: Path, encoding: str) -> None:
    npz, greeting = tmp_path / "a.npz", hello(encoding=encoding)
    came = fake_feed.spokes(greeting, DATA.astype(wire.DTYPES[encoding]), 72, 60)
    with running(Script([greeting, gap(greeting, 70, 2), came, gap(greeting, 132, 12)], wait=True)) as feed:
        assert main([feed.url, "--encoding", encoding, "--npz", str(npz)]) == 0
    if encoding == "u8":
        with pytest.raises(ValueError, match="holds no power"):
            rs.load_scan(npz)
        return
    scan = rs.load_scan(npz)
    assert scan.number == 1 and np.isnan(scan.time[60:]).all() and np.isnan(scan.power[60:]).all()
    np.testing.assert_array_equal(scan.power[:60] > 0, DATA[:60] > 0)
    assert np.isnan(scan.field[:60]).all() == (encoding == "f32")
    if encoding == "c64":
        np.testing.assert_array_equal(scan.power[:60], scan.field[:60].real ** 2 + scan.field[:60].imag ** 2)
    assert scan._repr_png_() and "72 azimuths" in repr(scan)


def test_command_paints_missing_azimuths_grey(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.png"
    with running(Script([GREETING, batch(0, 14), gap(GREETING, 14, 8), batch(22, 50)], wait=True)) as feed:
        assert main([feed.url, "--out", str(out), "--size", "300"]) == 0
    image = np.asarray(Image.open(out))
    assert image[150 - 4, 150 + 90].tolist() == list(UNSEEN)  # 14 to 21 of 72 are 070 to 105 degrees
    assert "64 azimuths came, 8 missing" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("script", "text"),
    [
        (Script([GREETING, batch(0, 5), {"type": "bye", "epoch": "a", "reason": "the service stops"}]), "the service stops"),
        (Script([b"rubbish"]), "not a message"),
    ],
)
def test_command_fails_with_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], script: Script, text: str
) -> None:
    with running(script) as feed:
        assert main([feed.url, "--out", str(tmp_path / "a.png"), "--no-reconnect"]) == 1
    said = capsys.readouterr().err
    assert text in said and "Traceback" not in said
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    "wrong",
    [["--scans", "0"], ["--size", "20"], ["--encoding", "u9"], ["--range", "-1"], ["--range", "nan"], ["--range", "inf"],
     ["--bins", "x"],
     ["--out", "/nowhere/at/all.png"], ["--npz", "/"], ["--out", "a.jpg"], ["--fps", "26"], ["--live", "--out", "a.png"],
     ["--live", "--scans", "2"], ["--npz", "a.txt"]],
)  # fmt: skip
def test_command_refuses_wrong_usage_before_it_connects(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["ws://127.0.0.1:1", *wrong])
    assert ended.value.code == 2
    assert wrong[0] in capsys.readouterr().err


def test_interrupting_the_command_is_clean(tmp_path: Path) -> None:
    with running(Script([GREETING, batch(0, 5)], wait=True)) as feed:
        command = [sys.executable, "-m", "clients.ppi", feed.url, "--out", str(tmp_path / "a.png")]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2])
        assert feed.greeted.wait(20)
        os.kill(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "interrupted" in err and "Traceback" not in err
    assert not (tmp_path / "a.png").exists()
