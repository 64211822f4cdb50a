"""The bridge from the transmitter's thread to the hub on the event loop."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from radar_service.stream.fanout.hub import EncodedBatch, Hub
from radar_service.stream.feed_request import Mode, View


class FeedOutput:
    """Hands encoded batches to a hub. Each method is called from another thread and returns when the hub has done it.

    `start` comes first and is called on the hub's event loop.
    """

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def views(self) -> tuple[View, ...]:
        """The views that clients have, and so what to encode."""
        return self._hub.views

    def start(self) -> None:
        """Remembers the running event loop."""
        self._loop = asyncio.get_running_loop()

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes], spoke_period: float) -> None:
        """Begins an epoch; see Hub.open_epoch."""
        self._call(lambda: self._hub.open_epoch(epoch, hello, spoke_period))

    def publish(self, batch: EncodedBatch) -> None:
        """Queues a batch for every client; returns when it is queued, for lossless clients too."""
        self._on_loop(self._hub.publish(batch))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Announces spokes that will never come."""
        self._call(lambda: self._hub.skip(epoch, first, count, reason))

    def close(self, reason: str) -> None:
        """Sends `bye` to every client; returns when they have left, or their time to read what waits is over."""
        self._on_loop(self._hub.finish(reason))

    def _call(self, function: Callable[[], None]) -> None:
        async def call() -> None:
            function()

        self._on_loop(call())

    def _on_loop(self, call: Coroutine[Any, Any, None]) -> None:
        assert self._loop is not None, "start() comes first"
        asyncio.run_coroutine_threadsafe(call, self._loop).result()
