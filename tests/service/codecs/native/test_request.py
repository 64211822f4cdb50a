"""The query string of the native feed."""

import pytest

from radar_service.service.codecs.native.views import request_from_query
from radar_service.service.feed_request import FeedRequest, View


@pytest.mark.parametrize(
    ("query", "is_near", "view"),
    [
        ({"sector": "350,10", "spokes": "4", "compress": "zstd"}, True, View("u8", None, (350, 10), 4, "zstd")),
        ({"compress": "auto"}, True, View("u8")), ({"compress": "auto"}, False, View("u8", compression="zstd")),
        ({"compress": "none"}, False, View("u8")), ({}, False, View("u8")),
    ],
)  # fmt: skip
def test_compression_is_off_on_this_machine_unless_requested(query: dict[str, str], is_near: bool, view: View) -> None:
    assert request_from_query(query, is_near).view == view


@pytest.mark.parametrize(
    "query", [{"sector": "1"}, {"sector": "1,361"}, {"sector": "-1,5"}, {"sector": "a,b"}, {"spokes": "0"}, {"spokes": "33"},
              {"compress": "lz4"}, {"spokes": "1e1"}, {"labels": "yes"}, {"labels": ""}, {"powers": "0,"}, {"powers": "ship"}]
)  # fmt: skip
def test_an_invalid_parameter_is_refused_with_its_name(query: dict[str, str]) -> None:
    with pytest.raises(ValueError, match=f"^{next(iter(query))}: "):
        request_from_query(query)


def test_a_query_is_read_as_it_is_written() -> None:
    query = {"encoding": "c64", "bins": "512", "truth": "1", "mode": "lossless", "since": "ab12:99"}
    assert request_from_query(query) == FeedRequest(View("c64", 512), "lossless", True, ("ab12", 99))
    told = request_from_query({"labels": "1", "powers": "257,1"}).view
    assert told == View("u8", labels=True, powers=(1, 257)) and request_from_query({"powers": "all"}).view.powers == "all"
    assert request_from_query({}) == FeedRequest(View("u8", None), "live", False, None)
