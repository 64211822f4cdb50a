"""Errors on purpose of a client's connection: it carries few bytes per second, or is cut."""

import asyncio
import time
from collections.abc import Awaitable, Callable

from radar_service.scene.error_settings import ErrorSettings, FeedErrors

SLICE = 0.25  # s after which the errors are read again
NONE = FeedErrors(0.0, 0.0, 1, 0.0, 0.0, 0.0, 0.0, None, (), None, None)


class ConnectionErrors:
    """Slows or cuts one connection, which begins now. errors: returns those in force, which may change."""

    def __init__(
        self, errors: Callable[[], ErrorSettings | None], clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:  # fmt: skip
        self._errors, self._clock, self._sleep = errors, clock, sleep
        self._since = clock()

    @property
    def is_cut(self) -> bool:
        """Whether the connection has reached the age at which it is cut."""
        cut_after = self._feed.cut_after
        return cut_after is not None and self._clock() - self._since >= cut_after

    async def carry(self, size: int) -> None:
        """Waits as long as a message of `size` bytes takes, or until the connection is cut or not slow any more."""
        left = float(size)
        while left > 0.0 and (rate := self._feed.bytes) is not None and not self.is_cut:
            seconds = min(left / rate, SLICE)
            await self._sleep(seconds)
            left -= seconds * rate

    def is_faulty(self) -> bool:
        """Whether the connection is slow or to be cut, so that `carry` comes before each message."""
        errors = self._errors()  # read for each message of each client
        return errors is not None and errors.feed is not None and (self._feed.bytes, self._feed.cut_after) != (None, None)

    @property
    def _feed(self) -> FeedErrors:
        errors = self._errors()
        return errors.feed if errors and errors.feed else NONE
