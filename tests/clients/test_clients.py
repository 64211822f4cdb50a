"""The short modules of clients, each under its name."""

from pathlib import Path

import pytest

from clients.ppi import FeedError, SequenceTracker, feed_url
from clients.ppi.__main__ import main


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
