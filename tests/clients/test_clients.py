"""The short modules of clients, each under its name."""

import pytest

from clients.ppi import FeedError, SequenceTracker, feed_url


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
