"""The plugin for pytest: the fixture `radar_feed`.

Nothing heavy is imported until a test uses it: other runs of pytest are not slower.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from radar_service.radar_feed import RadarFeeds


@pytest.fixture
def radar_feed() -> Iterator["RadarFeeds"]:
    """Makes radars: `radar_feed(scene, seed=0, over="process")`, see radar_feed.RadarFeeds. They end with the test."""
    from radar_service.radar_feed import RadarFeeds

    with RadarFeeds() as feeds:
        yield feeds
