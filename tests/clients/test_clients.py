"""The short modules of clients, each under its name."""

import math
import socket
from pathlib import Path

import numpy as np
import pytest

from clients.ppi import FeedClient, FeedError, SequenceTracker, feed_url, spokes
from clients.ppi.__main__ import main
from clients.ppi.spoke import label_names, spokes_of
from clients.ppi.terminal_ppi import TerminalPpi, half_blocks
from radar_service.display.palettes import colour_map
from radar_service.display.picture import UNSEEN
from tests.clients import fake_feed
from tests.clients.fake_feed import DATA, GREETING, TARGETS, Script, batch, final_error, hello, numbers, ppi_of, running


# address: short addresses mean the feed of radar 0.
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
def test_text_that_is_no_address_is_refused(bad: str) -> None:
    with pytest.raises(FeedError, match="ws://HOST:PORT"):
        feed_url(bad)


# sequence: sequence numbers: announced losses, unannounced losses and repeats are counted apart.
def test_announced_and_unannounced_losses_are_counted_apart() -> None:
    sequence = SequenceTracker()
    sequence.hello("a", None)
    assert sequence.spokes(100, 10) == 0  # came in the middle: nothing is lost
    sequence.gap(110, 5)
    assert sequence.spokes(115, 5) == 0
    assert sequence.spokes(123, 7) == 0  # 120 to 122 never came
    assert sequence.spokes(128, 4) == 2  # 128 and 129 again
    assert (sequence.received, sequence.announced, sequence.missing, sequence.repeated) == (24, 5, 3, 2)
    assert (sequence.next, sequence.lost) == (132, 8)
    assert sequence.spokes(0, 3) == 3 and sequence.next == 132  # late comers


def test_gap_may_overlap_received_spokes_or_follow_missing_ones() -> None:
    sequence = SequenceTracker()
    sequence.hello("a", 0)
    sequence.spokes(0, 10)
    sequence.gap(8, 4)
    sequence.gap(20, 1)
    assert (sequence.announced, sequence.missing, sequence.next) == (3, 8, 21)


def test_new_epoch_begins_at_its_number() -> None:
    sequence = SequenceTracker()
    sequence.hello("a", None)
    sequence.spokes(50, 1)
    sequence.hello("a", 0)  # the same epoch again changes nothing
    assert sequence.next == 51
    sequence.hello("b", 0)
    sequence.spokes(2, 1)
    assert (sequence.missing, sequence.epochs, sequence.received) == (2, 2, 2)


# options: the command line refuses wrong usage before it connects.


@pytest.mark.parametrize(
    "wrong",
    [["--scans", "0"], ["--size", "20"], ["--encoding", "u9"], ["--range", "-1"], ["--range", "nan"], ["--range", "inf"],
     ["--bins", "x"],
     ["--out", "/dev/null/a.png"], ["--npz", "/"], ["--out", "a.jpg"], ["--fps", "26"], ["--live", "--out", "a.png"],
     ["--live", "--scans", "2"], ["--npz", "a.txt"]],
)  # fmt: skip
def test_command_refuses_wrong_usage_before_it_connects(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["ws://127.0.0.1:1", *wrong])
    assert ended.value.code == 2
    assert wrong[0] in capsys.readouterr().err


@pytest.mark.parametrize(("option", "name"), [("--out", "a.png"), ("--npz", "a.npz")])
def test_command_writes_over_no_file_unasked(
    option: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (path := tmp_path / name).write_text("mine")
    with pytest.raises(SystemExit) as ended:
        main(["ws://127.0.0.1:1", option, str(path)])
    assert (
        ended.value.code == 2 and f"{path}: it exists already; give --overwrite, or another name" in capsys.readouterr().err
    )
    assert main(["ws://127.0.0.1:1", option, str(path), "--overwrite", "--no-reconnect"]) == 1  # there is no such feed
    assert path.read_text() == "mine"


# errors: errors of a feed say why it ended and whether another attempt may succeed.
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


def test_errors_distinguish_no_service_from_no_such_radar() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound and not listening: refuses
        fault = final_error(f"ws://127.0.0.1:{taken.getsockname()[1]}", reconnect=True, backoff=(0.0,))
    assert (
        "is the service running" in str(fault) and fault.retry
    )  # the client did not retry by itself: it never was connected
    with running() as feed:
        fault = final_error(f"{feed.url}/api/radars/9/feed")
        assert "no such radar" in str(fault) and feed.url.replace("ws", "http") + "/api/radars lists" in str(fault)
        assert not fault.retry
        fault = final_error(f"{feed.url}/api/radars/5/feed")
        assert "HTTP 500: the engine died" in str(fault) and fault.retry
    with pytest.raises(ValueError, match='"u9" is not one of u8'):
        FeedClient("ws://h", encoding="u9")


# spoke: spokes carry the values of their message in SI units.
def test_spokes_carry_the_values_of_their_message() -> None:
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


def test_spokes_have_their_labels_and_powers() -> None:
    plain = batch(0, 2)
    labels = np.arange(2 * plain["bins"], dtype="<u4").reshape(2, -1)
    power = np.arange(4 * plain["bins"], dtype="<f4").reshape(2, 2, -1)
    told = plain | {"labels": labels.tobytes(), "power_sources": [1, 257], "powers": power.tobytes()}
    for k, spoke in enumerate(spokes_of(told)):
        assert spoke.labels is not None and spoke.powers is not None and list(spoke.powers) == [1, 257]
        np.testing.assert_array_equal(spoke.labels, labels[k])
        np.testing.assert_array_equal(spoke.powers[257], power[k, 1])
    assert spokes_of(plain)[0].labels is None and spokes_of(plain)[0].powers is None
    with pytest.raises(ValueError, match="labels: 4 bytes are not 2 rows of 400 bytes"):
        spokes_of(plain | {"labels": b"1234"})
    assert label_names({"sources": [{"number": 1, "name": "sea"}]}) == {1: "sea"} and label_names(GREETING) == {}


def test_a_lost_heading_is_nan() -> None:
    first, second = spokes_of(batch(0, 2, heading_deg=math.nan) | {"heading": [None, 16384]})
    assert math.isnan(first.heading) and second.heading == pytest.approx(math.pi / 2)


# terminal_ppi: the PPI draws targets at their positions, marks missing azimuths, and becomes text for a terminal.
@pytest.mark.parametrize("head_up", [False, True])
def test_targets_are_at_their_bearings_and_ranges(head_up: bool) -> None:
    size, image = 80, ppi_of(GREETING, batch(0, 72, heading_deg=70.0), head_up=head_up).image(80)
    lit = image.astype(int).sum(axis=2) > 300
    for bearing_deg, distance in TARGETS:
        angle, far = math.radians(bearing_deg - 70.0 * head_up), distance / 2000.0 * size / 2
        y, x = size / 2 - far * math.cos(angle), size / 2 + far * math.sin(angle)
        i0, j0 = max(0, int(y) - 3), int(x) - 3
        assert lit[i0 : i0 + 7, j0 : j0 + 7].any()
        lit[i0 : i0 + 7, j0 : j0 + 7] = False
    assert not lit.any()  # rings and heading line are darker


@pytest.mark.parametrize(("bearing_deg", "level"), [(30, 200 * (1 - 0.4 * 65 / 72)), (180, 200 * (1 - 0.4 * 35 / 72))])
def test_echoes_fade_by_four_tenths_until_the_beam_returns(bearing_deg: float, level: float) -> None:
    image = ppi_of(GREETING, fake_feed.spokes(GREETING, np.full_like(DATA, 200), 0, 72)).image(80)
    angle, far = math.radians(bearing_deg), 23.5  # pixels, between two rings
    pixel = image[int(40 - far * math.cos(angle)), int(40 + far * math.sin(angle))]
    allowed = colour_map()[round(level) - 2 : round(level) + 3]  # a pixel is off by a third of an azimuth, of 1.1 levels
    assert (allowed == pixel).all(axis=1).any()


def test_azimuths_without_a_spoke_are_grey_and_a_new_epoch_begins_empty() -> None:
    half = ppi_of(GREETING, batch(0, 36))
    image = half.image(60)
    assert image[30, 10].tolist() == list(UNSEEN) and image[30, 50].tolist() != list(UNSEEN)
    half.take(hello("b", bins=50))
    assert (half.image(60)[25:35, 46] == UNSEEN).all()
    assert not TerminalPpi().image(10).any() and TerminalPpi().caption == "no radar yet"


def test_half_blocks_show_two_pixels_each() -> None:
    image = np.arange(5 * 3 * 3, dtype=np.uint8).reshape(5, 3, 3)
    lines = half_blocks(image)
    assert len(lines) == 3 and lines[0].startswith("\x1b[38;2;0;1;2;48;2;9;10;11m\u2580\x1b[38;2;3;4;5;")
    assert lines[2].endswith("\x1b[38;2;42;43;44;48;2;0;0;0m\u2580\x1b[0m")
    assert half_blocks(np.zeros((2, 9, 3), np.uint8)) == ["\x1b[38;2;0;0;0;48;2;0;0;0m" + "\u2580" * 9 + "\x1b[0m"]


def test_a_lost_heading_stays_as_it_was_last_reported() -> None:
    ppi = ppi_of(GREETING, batch(0, 36, heading_deg=70.0), batch(36, 36, heading_deg=math.nan), head_up=True)
    assert "heading 070.0" in ppi.caption and ppi.image(40).any()
