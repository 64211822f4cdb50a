"""How a process hands its tiles on: in a thread of its own, so that it computes on while nobody reads.

A radar takes spokes at the pace of its rotation, first all tiles of one process, then those of the next. Without this each
process would wait while those of the others are sent.
"""

import contextlib
import os
import select
import threading
from collections import deque
from time import monotonic
from typing import NamedTuple

from radar_service.processes.channel import Channel
from radar_service.simulation.engine_set_up import SourceTile

BYTES_AHEAD = 32 * 2**20  # of field and power in tiles that wait
STEERED_AHEAD, STEERED_SECONDS = 2, 1.0  # tiles that wait for so long after an order: the next command may drop them again


class Computed(NamedTuple):
    """A tile, and the processor time that it took [s]."""

    tile: SourceTile
    seconds: float


class TileSender:
    """Sends tiles, and the answer after them, in order. It is called from one thread."""

    def __init__(self, channel: Channel) -> None:
        self._channel, self._room, self._either = channel, os.eventfd(0), select.poll()
        for descriptor in (channel.fileno(), self._room):
            self._either.register(descriptor, select.POLLIN)
        self._waiting: deque[Computed | Exception | str] = deque()
        self._changed = threading.Condition()
        self._freely = 0.0  # when more than STEERED_AHEAD may wait [s]
        threading.Thread(target=self._run, name="tiles", daemon=True).start()

    def put(self, message: Computed | Exception | str) -> None:
        """Queues a message."""
        with self._changed:
            self._waiting.append(message)
            self._changed.notify()

    def begin(self) -> None:
        """Begins an order: for STEERED_SECONDS no more than STEERED_AHEAD tiles wait."""
        self._freely = monotonic() + STEERED_SECONDS

    def drop(self) -> None:
        """Forgets what has not been sent."""
        with self._changed:
            self._waiting.clear()

    def has_order(self, most: int) -> bool:
        """Returns whether the other end has sent an order; waits for one, or until fewer than `most` messages and BYTES_AHEAD are
        left."""
        while not (ordered := self._channel.wait(0.0)):
            soon = self._freely - monotonic()
            if self._has_room(min(most, STEERED_AHEAD) if soon > 0.0 else most):
                break
            events = self._either.poll(1000.0 * soon if soon > 0.0 else None)
            if any(descriptor == self._room for descriptor, _ in events):
                os.eventfd_read(self._room)
        return ordered

    def _has_room(self, most: int) -> bool:
        with self._changed:
            return len(self._waiting) < most and sum(map(_size, self._waiting)) < BYTES_AHEAD

    def _run(self) -> None:
        with contextlib.suppress(Exception):  # of any kind, such as that the other end is gone
            while True:
                with self._changed:
                    self._changed.wait_for(lambda: self._waiting)
                    message = self._waiting.popleft()
                os.eventfd_write(self._room, 1)
                self._channel.send(message)
        self._channel.close()  # so that whoever computes, and the other end, find out


def _size(message: Computed | Exception | str) -> int:
    """The size of the field and the power in a message [bytes]."""
    return message.tile.field.nbytes + message.tile.power.nbytes if isinstance(message, Computed) else 0
