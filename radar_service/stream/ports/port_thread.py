"""The thread of a port, with the queue before it: what is too much is dropped and counted, what fails is caught and counted."""

import logging
import threading
from collections import deque
from collections.abc import Callable, Hashable
from functools import partial
from typing import NamedTuple

from radar_service.stream.logs import log_event
from radar_service.stream.spokes import RadarInfo, SpokeBatch, SpokeSink

MAX_BYTES = 16 * 2**20  # of spokes that wait: three seconds of a radar of 4096 cells
MAX_CALLS = 4096  # that wait
BEHIND = "the port has fallen behind"


class _Call(NamedTuple):
    """What waits to be done. spokes, size: how many it holds, and their bytes; key: of what waits once at most."""

    do: Callable[[], None]
    spokes: int = 0
    size: int = 0
    key: Hashable = None


class PortThread:
    """Calls what a port has, in its own thread, one after the other. `put` never waits, and may be called from any thread.

    faults: calls that have raised; dropped: calls that were given up, of spokes as many as these.
    """

    def __init__(self, name: str) -> None:
        self.name, self.faults, self.dropped = name, 0, 0
        self._calls: deque[_Call] = deque()
        self._bytes = 0  # of spokes that wait
        self._changed, self._closing = threading.Condition(), False
        self._thread = threading.Thread(target=self._run, name=f"port {name}", daemon=True)

    def start(self) -> None:
        """Begins to call."""
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """Ends when all was done that waits, or leaves the thread behind after `timeout` [s]."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread.ident is not None:
            self._thread.join(timeout)

    def put(self, do: Callable[[], None], *, spokes: int = 0, size: int = 0, key: Hashable = None) -> None:
        """Has something done, or drops it where too much waits, or something of the same key does.

        spokes, size: how many it holds, and their bytes; where these are too many, those that wait are all dropped.
        """
        with self._changed:
            if key is not None and any(call.key == key for call in self._calls):
                return
            if self._bytes + size > MAX_BYTES:
                self._drop_spokes()
            if len(self._calls) >= MAX_CALLS:
                self.dropped += spokes or 1
                return
            self._calls.append(_Call(do, spokes, size, key))
            self._bytes += size
            self._changed.notify_all()

    def _drop_spokes(self) -> None:
        self.dropped += sum(call.spokes for call in self._calls)
        self._calls = deque(call for call in self._calls if not call.spokes)
        self._bytes = 0

    def _run(self) -> None:
        while call := self._next():
            try:
                call.do()
            except BaseException as error:  # of any kind, SystemExit too: the port goes on, and so do all others
                self.faults += 1
                log_event("port failed", logging.ERROR, port=self.name, reason=f"{type(error).__name__}: {error}")

    def _next(self) -> _Call | None:
        with self._changed:
            self._changed.wait_for(lambda: self._calls or self._closing)
            if not self._calls:
                return None
            call = self._calls.popleft()
            self._bytes -= call.size
            return call


class QueuedSink:
    """A sink before one of a port, which is called by the thread of the port.

    The port's sink is told of all numbers that it does not get, and of the epoch first, also where a notice was dropped.
    """

    def __init__(self, sink: SpokeSink, thread: PortThread) -> None:
        self._sink, self._thread = sink, thread
        self._radar: RadarInfo | None = None  # as the last epoch was opened
        self._opened, self._next = (
            "",
            0,
        )  # epoch of the port's sink, and the number that it expects; the port's thread has both

    def open_epoch(self, radar: RadarInfo) -> None:
        """As SpokeSink.open_epoch."""
        self._radar = radar
        self._thread.put(partial(self._open, radar))

    def send(self, batch: SpokeBatch) -> None:
        """As SpokeSink.send."""
        self._thread.put(partial(self._send, self._radar, batch), spokes=len(batch), size=batch.block.nbytes)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """As SpokeSink.skip."""
        self._thread.put(partial(self._skip, self._radar, first, count, reason))

    def close(self, reason: str) -> None:
        """As SpokeSink.close."""
        self._thread.put(partial(self._sink.close, reason))

    def _open(self, radar: RadarInfo | None) -> None:
        if radar is not None and radar.epoch.name != self._opened:
            self._opened, self._next = radar.epoch.name, 0
            self._sink.open_epoch(radar)

    def _send(self, radar: RadarInfo | None, batch: SpokeBatch) -> None:
        self._open(radar)
        self._announce(batch.first)
        self._next = batch.first + len(batch)
        self._sink.send(batch)

    def _skip(self, radar: RadarInfo | None, first: int, count: int, reason: str) -> None:
        self._open(radar)
        self._announce(first)
        self._next = first + count
        self._sink.skip(self._opened, first, count, reason)

    def _announce(self, first: int) -> None:
        """Tells the sink of what was dropped before a number."""
        missing, begin = first - self._next, self._next
        self._next = max(first, self._next)
        if missing > 0:
            self._sink.skip(self._opened, begin, missing, BEHIND)
