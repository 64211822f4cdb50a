"""What a client receives from a scripted feed."""

import asyncio
from typing import Any

import pytest

from clients.ppi import FeedClient, FeedError, ScanCollector, spokes
from clients.ppi.terminal_ppi import TerminalPpi


def numbers(url: str, count: int, **options: Any) -> list[int]:
    """Numbers of the first `count` spokes of a feed."""
    received = []
    for spoke in spokes(url, timeout=10.0, **options):
        received.append(spoke.number)
        if len(received) == count:
            break
    return received


def final_error(url: str, **options: Any) -> FeedError:
    """The error with which a feed ends; fails after ten seconds if the client never gives up."""

    async def follow() -> None:
        async with FeedClient(url, timeout=10.0, **options) as client:
            async for _ in client.spokes():
                pass

    with pytest.raises(FeedError) as fault:
        asyncio.run(asyncio.wait_for(follow(), 10.0))
    return fault.value


def collected(messages: list[dict[str, Any]], keep: int | None = None) -> ScanCollector:
    """A collector that took these messages."""
    collector = ScanCollector(keep)
    for message in messages:
        collector.take(message)
    return collector


def ppi_of(*messages: dict[str, Any], **options: Any) -> TerminalPpi:
    """A PPI that took these messages."""
    made = TerminalPpi(**options)
    for message in messages:
        made.take(message)
    return made
