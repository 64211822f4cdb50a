"""The thread of a port, with the queue before it: what is too much is dropped and counted, what fails is caught and counted."""

import logging
import threading
from collections import deque
from collections.abc import Callable, Hashable
from functools import partial
from typing import NamedTuple

from typing_extensions import override

from radar_service.service.logs import log_event
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink

MAX_BYTES = 16 * 2**20  # of spokes that wait: three seconds of a radar of 4096 cells
MAX_CALLS = 4096  # that wait
KEPT_ENDS = 64  # epochs whose last number is known, while a port is so far behind
BEHIND = "the port has fallen behind"

Do = Callable[[], None]


class _Call(NamedTuple):
    """What waits to be done.

    spokes, size: how many it holds, and their bytes; instead: what is done where they are dropped, once for each `key` of theirs.
    key: of calls without spokes, of which the last one alone is done.
    """

    do: Do
    spokes: int = 0
    size: int = 0
    key: Hashable = None
    instead: Do | None = None


class PortThread:
    """Calls what a port has, in its own thread, one after the other. `put` never waits, and may be called from any thread.

    faults: calls that have raised; dropped: spokes and other calls that were given up.
    """

    def __init__(self, name: str) -> None:
        self.name, self.faults, self.dropped = name, 0, 0
        self._calls: deque[_Call] = deque()
        self._bytes = 0  # of spokes that wait
        self._changed, self._may_run, self._closing = threading.Condition(), False, False
        self._thread = threading.Thread(target=self._run, name=f"port {name}", daemon=True)

    def start(self) -> None:
        """Begins to call, once there is something to do."""
        with self._changed:
            self._may_run = True
            if self._calls:
                self._thread.start()

    def stop(self, timeout: float) -> None:
        """Ends when all was done that waits; after `timeout` [s] it is given up, and a call that goes on is left behind."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread.ident is not None:
            self._thread.join(timeout)
        with self._changed:
            self.dropped += sum(call.spokes or 1 for call in self._calls)
            self._calls.clear()

    def note_fault(self, reason: str) -> None:
        """Counts and logs a call that has failed."""
        with self._changed:
            self.faults += 1
        log_event("port failed", logging.ERROR, port=self.name, reason=reason)

    def note_dropped(self, count: int) -> None:
        """Counts what a call of the port could not pass on."""
        with self._changed:
            self.dropped += count

    def put(self, do: Do, key: Hashable = None) -> None:
        """Queues a call, in place of one that waits with the same key."""
        with self._changed:
            if key is not None:
                self._calls = deque(call for call in self._calls if call.key != key or call.instead)
            self._add(_Call(do, key=key))

    def put_spokes(self, do: Do, spokes: int, size: int, owner: Hashable, instead: Do) -> None:
        """Queues spokes. Where too many wait these are all dropped, and `instead` is done for the last ones of each owner.

        size: of the spokes [bytes].
        """
        with self._changed:
            if self._bytes + size > MAX_BYTES or len(self._calls) >= MAX_CALLS:
                self._drop_spokes()
            if self._add(_Call(do, spokes, size, owner, instead)):
                self._bytes += size

    def _add(self, call: _Call) -> bool:
        if self._closing or len(self._calls) >= MAX_CALLS:
            self.dropped += call.spokes or 1
            return False
        self._calls.append(call)
        self._changed.notify_all()
        if self._may_run and self._thread.ident is None:
            self._thread.start()
        return True

    def _drop_spokes(self) -> None:
        """Leaves one notice for each owner of spokes; it stands for earlier ones, too."""
        kept: list[_Call] = []
        owners: set[Hashable] = set()
        for call in reversed(self._calls):
            self.dropped += call.spokes
            if not call.instead:
                kept.append(call)
            elif call.key not in owners:
                owners.add(call.key)
                kept.append(_Call(call.instead, key=call.key, instead=call.instead))
        self._calls, self._bytes = deque(reversed(kept)), 0

    def _run(self) -> None:
        while call := self._next():
            try:
                call.do()
            except BaseException as error:  # of any kind, SystemExit too: the port goes on, and so do all others
                self.note_fault(described(error))

    def _next(self) -> _Call | None:
        with self._changed:
            self._changed.wait_for(lambda: self._calls or self._closing)
            if not self._calls:
                return None
            call = self._calls.popleft()
            self._bytes -= call.size
            return call


def described(error: BaseException) -> str:
    """Returns what an exception says, also where that fails."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:  # of the text itself
        return type(error).__name__


class QueuedSink(SpokeSink):
    """A sink before one of a port, which is called by the thread of the port.

    The port's sink is told of each epoch before its spokes, and of all numbers of an epoch that it does not get.
    """

    def __init__(self, sink: SpokeSink, thread: PortThread) -> None:
        self._sink, self._thread = sink, thread
        self._radar: RadarInfo | None = None  # as the last epoch was opened
        self._ends: dict[str, int] = {}  # the number after the last one of each epoch so far
        self._opened = ""  # epoch of the port's sink; the port's thread alone uses it, and
        self._next = 0  # the number that the sink expects

    @property
    def epoch(self) -> str:
        """The epoch that was opened last."""
        return "" if self._radar is None else self._radar.epoch.name

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        self._ends[radar.epoch.name] = 0
        while len(self._ends) > KEPT_ENDS:
            del self._ends[next(iter(self._ends))]
        self._thread.put(partial(self._open, radar), key=(self, radar.epoch.name))
        self._radar = radar

    @override
    def send(self, batch: SpokeBatch) -> None:
        size = batch.block.nbytes + (0 if batch.earlier is None else batch.earlier.nbytes)
        self._put(partial(self._send, self._radar, batch), batch.first + len(batch), len(batch), size)

    @override
    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self._put(partial(self._skip, self._radar, first, count, reason), first + count, count, 0)

    @override
    def close(self, reason: str) -> None:
        self._thread.put(partial(self._close, self._radar, reason))

    def _put(self, do: Do, end: int, spokes: int, size: int) -> None:
        assert self._radar is not None, "open_epoch comes first"
        self._ends[self._radar.epoch.name] = end
        self._thread.put_spokes(do, spokes, size, self, partial(self._miss, self._radar, end))

    def _open(self, radar: RadarInfo | None) -> None:
        if radar is not None and radar.epoch.name != self._opened:
            self._announce(self._ends.get(self._opened, self._next))
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

    def _miss(self, radar: RadarInfo | None, end: int) -> None:
        self._open(radar)
        self._announce(end)

    def _close(self, radar: RadarInfo | None, reason: str) -> None:
        self._open(radar)
        self._announce(self._ends.get(self._opened, self._next))
        self._sink.close(reason)

    def _announce(self, end: int) -> None:
        """Tells the sink of what it did not get before a number of its epoch."""
        begin, self._next = self._next, max(end, self._next)
        if self._opened and end > begin:
            self._sink.skip(self._opened, begin, end - begin, BEHIND)
