"""The Python client of a radar's feed: receive spokes, collect scans, draw the PPI (`python -m clients.ppi`)."""

from .client import FeedClient, FeedError, ReceivedSpoke, feed_url, spokes
from .ledger import Ledger
from .scans import ReceivedScan, ScanCollector, brightness, collect_scans, power_from_samples

__all__ = [
    "FeedClient", "FeedError", "Ledger", "ReceivedScan", "ReceivedSpoke", "ScanCollector", "brightness", "collect_scans",
    "feed_url", "power_from_samples", "spokes",
]  # fmt: skip
