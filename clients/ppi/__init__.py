"""The Python client of a radar's feed: receives spokes, collects scans, draws the PPI. `radar-ppi` is its command."""

from .address import feed_url
from .client import FeedClient, spokes
from .errors import FeedError
from .scans import ReceivedScan, ScanCollector, brightness, collect_scans, power_from_samples
from .sequence import SequenceTracker
from .spoke import ReceivedSpoke

__all__ = [
    "FeedClient", "FeedError", "ReceivedScan", "ReceivedSpoke", "ScanCollector", "SequenceTracker", "brightness",
    "collect_scans", "feed_url", "power_from_samples", "spokes",
]  # fmt: skip
