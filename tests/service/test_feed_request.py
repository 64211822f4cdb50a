"""Views: equal ones share their bytes."""

from radar_service.service.feed_request import FeedRequest, View


def test_views_are_equal_by_all_that_changes_their_bytes() -> None:
    views = [View("u8"), View("f32"), View("u8", 5), View("u8", sector=(0, 9)), View("u8", spokes=2),
             View("u8", compression="zstd"), View("u8", codec="other")]  # fmt: skip
    assert len(set(views)) == len(views) and View("u8") in set(views)


def test_plain_data_holds_what_a_view_filters() -> None:
    assert View("u8", 5, (350, 10), 4, "zstd").as_dict() == {"sector_deg": [350, 10], "spokes": 4, "compression": "zstd"}
    assert FeedRequest().view.as_dict() == {"sector_deg": None, "spokes": 1, "compression": ""}


def test_a_view_is_whole_where_each_spoke_is_a_row() -> None:
    assert View("u8").is_whole and View("f32", 5, compression="zstd", labels=True, powers="all").is_whole
    assert not View("u8", sector=(0, 360)).is_whole and not View("u8", spokes=2).is_whole
