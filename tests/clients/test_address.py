"""Short addresses mean the feed of radar 0."""

import pytest

from clients.ppi import FeedError, feed_url


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
