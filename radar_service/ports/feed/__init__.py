"""The native feed: spokes by websocket."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radar_service.ports.port import Port

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds nothing: what a client gets is in its request."""


def opened(options: argparse.Namespace) -> "Port":
    """Returns the port of the feed."""
    from radar_service.ports.feed.feed_socket import FeedPort

    return FeedPort()
