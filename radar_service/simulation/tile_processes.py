"""Tiles of a scan that several processes compute side by side, in order and with the bytes of one.

Threads win little here: the engine makes thousands of small calls, and only one thread at a time runs Python. So the process
that has prepared the scene forks others, which share its memory (docs/decisions/0024-tile-processes.md has the figures).
"""

import contextlib
import gc
import os
import select
import signal
import threading
import weakref
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import count
from time import monotonic, thread_time
from typing import Any, NamedTuple, NoReturn

import numpy as np

from radar_service.numerics import BLAS_LIMIT, Flags, Floats, Indices
from radar_service.processes.channel import CAN_FORK, Channel, first_ready, forked, portable
from radar_service.records import SourceRequest
from radar_service.simulation.engine_set_up import SourceTile, SourceTiles
from radar_service.trace import TREES
from radar_service.world import Command, Steering, same_at_first

NOBODY = -1  # owns a tile that nobody computes
LATEST = 0.25  # weight of what a tile took last: a busy machine takes twice as long at times
UNEVEN = 1.25  # times that new shares take, from which shares are made anew: what was computed ahead is lost then
BYTES_AHEAD = 32 * 2**20  # of field and power in tiles that wait
STEERED_AHEAD, STEERED_SECONDS = 2, 1.0  # tiles that wait for so long after an order: the next command may drop them again
STANDARD_STREAMS = 3  # descriptors that a child keeps

_FORKING: "weakref.WeakSet[TileProcesses]" = weakref.WeakSet()  # those whose children another fork must not hold on to


class TileShares:
    """The shares of the tiles (T,) of a scan, by what the tiles took before. owners: the number of the process of each tile."""

    def __init__(self, tiles: int) -> None:
        self.owners: Indices = np.full(tiles, NOBODY)
        self._seconds: Floats = np.full(tiles, np.nan)  # that each takes, where that is known

    def share_out(self, tiles: Indices, count: int) -> None:
        """Shares some tiles (M,), rising, out to at most `count` processes."""
        self.owners[:] = NOBODY
        self.owners[tiles] = shares(self._costs(tiles), count)

    def note(self, tile: int, seconds: float) -> None:
        """Notes what a tile took in its process [s]."""
        known = float(self._seconds[tile])
        self._seconds[tile] = seconds if np.isnan(known) else known + LATEST * (seconds - known)

    def are_uneven(self, count: int, times: float) -> bool:
        """Whether the last process takes more than so many times what it takes in new shares, as far as is known."""
        tiles = np.flatnonzero(self.owners != NOBODY)
        seconds = self._costs(tiles)
        now, new = (np.bincount(owners, seconds).max() for owners in (self.owners[tiles], shares(seconds, count)))
        return bool(now > times * new)

    def _costs(self, tiles: Indices) -> Floats:
        """What these tiles (M,) take [s]; those that are not known, the mean of the others."""
        seconds = self._seconds[tiles]
        known = seconds[~np.isnan(seconds)]
        return np.where(np.isnan(seconds), known.mean() if len(known) else 1.0, seconds)


def shares(seconds: Floats, count: int) -> Indices:
    """The number (T,) of the process, of `count`, that computes each tile: it has the middle of the tile's time [s] in its equal
    share of all time."""
    middle = np.cumsum(seconds) - 0.5 * seconds
    return np.asarray(np.minimum(count * middle / seconds.sum(), count - 1), dtype=np.int64)


class TileRequest(NamedTuple):
    """What a process is to compute: tiles of a scan that hold requested azimuths (A,), under commands.

    goes_on: whether those of the scans after it follow, until the order is given up.
    kept, commands: how many of the commands of the last order hold still, and those that follow them.
    """

    scan: int
    requested: Flags
    goes_on: bool
    sources: SourceRequest
    kept: int
    commands: Sequence[Command]


class Round(NamedTuple):
    """Orders to all processes for one scan: what they have in common; the next scan may have the same ones."""

    scan: int
    starts: Sequence[int]
    sources: SourceRequest
    commands: Sequence[Command]


class Computed(NamedTuple):
    """A tile, and the processor time that it took [s]."""

    tile: SourceTile
    seconds: float


STOP = "stop"  # gives up an order
DONE = "done"  # answers each order, after its tiles


class TileProcesses:
    """The tiles of SourceTiles, computed in several processes. They are forked with the first scan and end with this object.

    A process computes about the same azimuths in each scan, since it keeps what it knows of ships there. While another thread
    uses the engine nothing is forked, and a scan is computed in this process; so is the rest of one where a process has died.
    """

    def __init__(self, tiles: SourceTiles, steering: Steering, count: int) -> None:
        """tiles: whose scene `steering` commands; count: of processes, at least 2."""
        self.request = tiles.request
        self._tiles, self._steering, self._length = tiles, steering, tiles.length
        self._count = count
        self._children: list[_Child] = []
        self._shares = TileShares(-(-steering.scene.radar.azimuths // self._length))
        self._requested: Flags | None = None
        self._now: Round | None = None  # whose tiles they compute: those of the scan that was begun last
        self._ahead: Round | None = None  # what they compute where nobody has asked yet
        _FORKING.add(self)

    @property
    def numbers(self) -> list[int]:
        """The numbers of the processes that there are now."""
        return [child.process for child in self._children]

    def scan(self, scan: int, requested: Flags | None) -> Iterator[tuple[Any, ...]]:
        """Yields the tiles of a scan, as `SourceTiles.scan`."""
        self._tiles.request = request = self.request
        azimuths, goes_on = self._steering.scene.radar.azimuths, requested is None or requested is self._requested
        self._requested = requested
        flags = np.ones(azimuths, dtype=np.bool_) if requested is None else requested
        starts = [n for n in range(0, azimuths, self._length) if flags[n : n + self._length].any()]
        done = 0
        if len(starts) > 1 and (self._children or self._forked()):
            try:
                for tile in self._together(scan, flags, starts, goes_on):
                    yield tile
                    done += 1
            except GeneratorExit:
                raise
            except BaseException as error:
                self.close()  # a message may have been cut off within
                if isinstance(error, TimeoutError) or not isinstance(error, EOFError | OSError):  # a handler of a signal
                    raise
        if done < len(starts):
            self._tiles.request = request
            yield from self._tiles.scan(scan, flags & (np.arange(azimuths) >= starts[done]))

    def close(self) -> None:
        """Ends the processes. Another scan forks others."""
        for child in self._children:
            child.end()
        self._children, self._now, self._ahead = [], None, None

    def forget(self) -> None:
        """Gives up the processes without ending them, in a process that was forked from theirs."""
        for child in self._children:
            child.forget()
        self._children, self._now, self._ahead = [], None, None

    def _forked(self) -> bool:
        """Forks the processes. Returns False where that is not possible now."""
        own_end: Channel | None = None
        with BLAS_LIMIT.alone() as is_alone, self._steering.unchanged(), TREES.unchanged(), _signals_waiting():
            while is_alone and len(self._children) < self._count and own_end is None:
                try:
                    new = _fork()
                except OSError:  # no memory, or too many processes
                    break
                if isinstance(new, Channel):
                    own_end = new
                else:
                    self._children.append(new)
        if own_end:
            _live(own_end, self._tiles, self._steering)
        return bool(self._children)

    def _together(self, scan: int, requested: Flags, starts: Sequence[int], goes_on: bool) -> Iterator[SourceTile]:
        """Yields the tiles that begin at `starts`, until another scan is begun or the processes are ended meanwhile.

        Raises EOFError and OSError where a process has died, and what one raises in place of a tile.
        goes_on: whether the same azimuths of the next scan are likely to be asked for.
        """
        due = Round(scan, starts, self.request, self._steering.followed)
        if self._ahead != due or self._shares.are_uneven(len(self._children), UNEVEN):
            self._order(due, requested, goes_on)
        self._now, self._ahead = due, None
        for start in starts:
            yield self._received(start // self._length)
            if self._now is not due:
                return
        self._ahead = due._replace(scan=scan + 1) if goes_on else None

    def _order(self, due: Round, requested: Flags, goes_on: bool) -> None:
        """Shares a scan out to the processes, and those after it where it goes on. Raises EOFError and OSError."""
        self._shares.share_out(np.asarray(due.starts) // self._length, len(self._children))
        for child in self._children:
            child.give_up()
        for number, child in enumerate(self._children):
            child.wait()
            share = requested & np.repeat(self._shares.owners == number, self._length)[: len(requested)]
            if share.any():
                child.order(TileRequest(due.scan, share, goes_on, due.sources, 0, due.commands))

    def _received(self, number: int) -> SourceTile:
        """The next tile from its process, while tiles that come from others wait."""
        owner = self._children[int(self._shares.owners[number])]
        while not owner.tiles:
            if not owner.is_busy:
                raise EOFError(f"a process has not computed tile {number}")
            busy = [child for child in self._children if child.is_busy and len(child.tiles) < len(self._shares.owners)]
            for ready in first_ready([child.channel for child in busy]):
                busy[ready].receive()
        computed = owner.tiles.popleft()
        if isinstance(computed, Exception):
            raise computed
        tile, seconds = computed
        self._shares.note(number, seconds)
        return tile


def shared_out(tiles: SourceTiles, steering: Steering, count: int) -> SourceTiles | TileProcesses:
    """Returns what computes tiles in so many processes: the tiles themselves in one, or where no other can be forked."""
    return TileProcesses(tiles, steering, count) if count > 1 and CAN_FORK and tiles.length else tiles


class _Child:
    """One of the processes, as its parent has it. process: its number; tiles: that were received and not
    yet asked for, or at last what it raised in place of one; is_busy: has an order."""

    def __init__(self, channel: Channel, process: int) -> None:
        self.tiles: deque[Computed | Exception] = deque()
        self.is_busy = False
        self.channel = channel
        self.process, self._handle = process, os.pidfd_open(process)  # a number may be another process's one day
        self._commands: Sequence[Command] = ()
        self._ending = weakref.finalize(self, _end, channel, process, self._handle)

    def order(self, order: TileRequest) -> None:
        """Gives an order, with all its commands, to a process that has none. Raises OSError where it has died."""
        known, self._commands = self._commands, order.commands
        kept = same_at_first(self._commands, known)
        self.channel.send(order._replace(kept=kept, commands=self._commands[kept:]))
        self.is_busy = True

    def receive(self) -> None:
        """Takes the next message. Raises EOFError where the process has died."""
        message = self.channel.receive()
        self.is_busy = isinstance(message, Computed)
        if message != DONE:
            self.tiles.append(message)

    def give_up(self) -> None:
        """Lets the process give up its order."""
        self.tiles.clear()
        if self.is_busy:
            with contextlib.suppress(ConnectionError):  # it has died: the next order finds out
                self.channel.send(STOP)

    def wait(self) -> None:
        """Waits until the process has given up its order. Raises EOFError where it has died."""
        while self.is_busy:
            self.is_busy = isinstance(self.channel.receive(), Computed)

    def end(self) -> None:
        """Ends the process."""
        self._ending()

    def forget(self) -> None:
        """Gives up what belongs to another process's child."""
        self._ending.detach()
        self.channel.forget()
        os.close(self._handle)


def _fork() -> "_Child | Channel":
    """Forks a process. Returns it; in the process itself, the end of its channel instead. Raises OSError."""
    process, (channel,) = forked(1)
    if not process:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its children
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        return channel
    try:
        return _Child(channel, process)
    except OSError:  # no descriptor is left for it
        channel.close()
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        raise


@contextlib.contextmanager
def _signals_waiting() -> Iterator[None]:
    """Keeps signals that end a program waiting during a `with` block: no child runs a handler of its parent."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end(channel: Channel, process: int, handle: int) -> None:
    """Ends a process and leaves no zombie."""
    channel.close()
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(handle, signal.SIGKILL)
    with contextlib.suppress(ChildProcessError):
        os.waitpid(process, 0)
    os.close(handle)


class TileSender:
    """Sends tiles, and the answer after them, in a thread of its own: while those of another process are read, this one computes
    on. It is called from one thread."""

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


def _live(channel: Channel, tiles: SourceTiles, steering: Steering) -> NoReturn:
    """Runs a process: it obeys orders until its parent is gone."""
    try:
        gc.freeze()  # nothing of the parent is tidied up here
        highest = max(int(descriptor) for descriptor in os.listdir("/proc/self/fd"))
        os.closerange(STANDARD_STREAMS, channel.fileno())
        os.closerange(channel.fileno() + 1, highest + 1)
        sender = TileSender(channel)
        commands: tuple[Command, ...] = ()
        while True:
            order = channel.receive()
            if order != STOP:
                commands = (*commands[: order.kept], *order.commands)
                _obey(sender, tiles, steering, order, commands)
    finally:
        os._exit(0)


def _obey(
    sender: TileSender, tiles: SourceTiles, steering: Steering, order: TileRequest, commands: Sequence[Command]
) -> None:
    """Sends the tiles of an order until it is given up, then DONE or an error."""
    answer: str | Exception = DONE
    sender.begin()
    try:
        steering.follow(commands)
        tiles.request = order.sources
        for scan in count(order.scan) if order.goes_on else (order.scan,):
            if not _sent(sender, tiles.scan(scan, order.requested), 1 + int(order.requested.sum()) // tiles.length):
                sender.drop()
                break
    except Exception as error:
        answer = portable(error)
    sender.put(answer)


def _sent(sender: TileSender, tiles: Iterator[tuple[Any, ...]], most: int) -> bool:
    """Sends tiles, of which at most so many wait; returns False where the order was given up meanwhile."""
    begin = thread_time()
    for tile in tiles:
        sender.put(Computed(SourceTile(*tile), thread_time() - begin))
        if sender.has_order(most):
            return False
        begin = thread_time()
    return True


def _forget_all() -> None:
    for processes in list(_FORKING):
        processes.forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_all)
