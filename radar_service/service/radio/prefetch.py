"""A spoke source that computes a bounded number of azimuths ahead, in its own thread."""

import math
import threading
from collections import deque
from collections.abc import Iterable
from time import monotonic

from radar_service.processes.limits import return_free_memory
from radar_service.records import SourceRequest, SpokeBlock
from radar_service.service.scene_request import SceneSpokeSource
from radar_service.spoke_source import Commanded, TellsSources
from radar_service.world import Command, CommandLog

AZIMUTHS_AHEAD = 128  # under half a second at 24 rpm and 720 azimuths: covers a slow block, and a new scene is not late
BYTES_AHEAD = 32 * 2**20  # of wide spokes
STEERED_AHEAD, STEERED_SECONDS = 32, 1.0  # azimuths, for so long after a command: the next one may drop them again
BYTES_BETWEEN = 256 * 2**20  # of spokes, then free memory is returned: the heap keeps holes as large as all that wait
BLOCK = 32  # spokes; a message holds no more
BYTES_PER_CELL = 12  # field and power
BLOCK_BYTES = 4 * 2**20  # of wide spokes: they cross from one process to the other before the first of them is sent
PREPARE_TIMEOUT = 120.0  # s that a spoke source may take to its first spokes


class SpokeSourceFault(Exception):
    """The spoke source failed. The text says why."""


class BusyFault(SpokeSourceFault):
    """The spoke source cannot do it now, but may do so soon: the machine is too busy, or its process is replaced."""


class SpokeWorker:
    """Runs one spoke source in a thread and queues its blocks, at most `azimuths` spokes or BYTES_AHEAD, and one block more.

    All methods may be called from any thread. `_changed` guards the queue, the fault and the request to stop.

    commands: to its world so far.
    first: number of the first spoke that is queued.
    """

    def __init__(
        self,
        spoke_source: SceneSpokeSource,
        azimuths: int = AZIMUTHS_AHEAD,
        first: int = 0,
        commands: Iterable[Command] = (),
    ) -> None:
        """commands: that the spoke source follows from its start."""
        self.spoke_source, self.first = spoke_source, first
        self.commands = CommandLog(spoke_source.info.scene.steerable, commands)
        self._told, self._telling = len(self.commands), threading.Lock()  # commands that the spoke source knows
        if self.commands and isinstance(spoke_source, Commanded):
            spoke_source.replay(self.commands)
        self._azimuths = azimuths
        self._blocks: deque[SpokeBlock] = deque()
        self._changed = threading.Condition()
        self._stopping = False
        self._steered = -math.inf  # when the last command came
        self._fault: str | None = None
        self.requested = SourceRequest()  # what the spokes are to tell of their sources
        self._passed = 0  # bytes of spokes since free memory was returned
        self._requests = self._needed = 0  # how many there were; the last one that a block must follow
        self._thread = threading.Thread(target=self._run, name="radar engine", daemon=True)

    @property
    def begins(self) -> float:
        """Time of its first spoke [s]."""
        return self.spoke_source.info.radar.time_of_spokes(float(self.first))

    @property
    def is_alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Starts to compute, unless it does so already."""
        if self._thread.ident is None:
            self._thread.start()

    def stop(self, timeout: float = 0.0) -> None:
        """Ends the spoke source and its thread, drops what was not taken, and waits for the thread at most `timeout` [s]."""
        with self._changed:
            self._stopping = True
            self._blocks.clear()
            self._changed.notify_all()
        self.spoke_source.close()
        if timeout and self._thread.is_alive():
            self._thread.join(timeout)

    def wait_until_ready(self, timeout: float | None = None) -> bool:
        """Waits for a block; returns False after `timeout` [s]. Raises SpokeSourceFault when none will come."""
        with self._changed:
            return self._has_block(timeout)

    def take(self, timeout: float) -> SpokeBlock | None:
        """Returns the next block, None after `timeout` [s]. Raises SpokeSourceFault after the last block of a failed spoke
        source."""
        with self._changed:  # held throughout: a command may drop the block that was waited for
            if not self._has_block(timeout):
                return None
            block = self._blocks.popleft()
            self._changed.notify_all()
        return block

    def _has_block(self, timeout: float | None) -> bool:
        """Waits as `wait_until_ready` does, while the lock is locked."""
        self._changed.wait_for(lambda: self._blocks or self._fault or self._stopping, timeout)
        if self._fault and not self._blocks:
            raise SpokeSourceFault(self._fault)
        return bool(self._blocks)

    def command(self, command: Command) -> None:
        """Notes a command that was made for its world, and drops the spokes that it changes; `tell` comes next."""
        with self._changed:
            self.commands.add(command)
            self._steered = monotonic()
            self._blocks = deque(part for block in self._blocks if (part := self.known_part(block)))
            self._changed.notify_all()

    def follow(self, commands: CommandLog) -> None:
        """Notes the commands to another spoke source of the same scene that this one has not been given."""
        for each in commands.since(len(self.commands)):
            self.command(self.spoke_source.info.scene.steerable.seen(each, each.body))

    def tell(self) -> None:
        """Tells the spoke source the commands that it does not know, which may take its time."""
        with self._telling:
            for command in self.commands.since(self._told):
                assert isinstance(self.spoke_source, Commanded)  # else no command was made
                self.spoke_source.take(command)
                self._told += 1

    def known_part(self, block: SpokeBlock) -> SpokeBlock | None:
        """Returns the spokes of a block before the first command that it does not know; None where there are none."""
        count = self.commands.first_unknown(block.commands) - block.first
        if count >= len(block):
            return block
        return block.part(0, int(count)) if count > 0 else None

    def request_sources(self, request: SourceRequest, spoke: int) -> bool:
        """Changes what the spokes tell of their sources; returns whether that is more than before.

        All from `spoke` on then come again.
        """
        with self._changed:
            is_more = request | self.requested != self.requested
            if isinstance(self.spoke_source, TellsSources):
                self.spoke_source.request_sources(request.labels, request.powers, spoke if is_more else None)
            self.requested, self._requests = request, self._requests + 1
            if is_more:
                self._needed = self._requests
                self._blocks.clear()
                self._changed.notify_all()
        return is_more

    def _run(self) -> None:
        try:
            size = block_spokes(self.spoke_source.info.range.size)
            for block in self.spoke_source.blocks(size=size):
                if not self._queue_block(block):
                    return
            self._fail("the engine ended its stream of spokes")
        except SpokeSourceFault as error:
            self._fail(str(error))
        except Exception as error:  # of any kind: the transmitter must be notified
            self._fail(f"{type(error).__name__}: {error}")

    def _queue_block(self, block: SpokeBlock) -> bool:
        """Queues a block and waits for room; returns whether to go on."""
        self._passed += block.nbytes
        if self._passed > BYTES_BETWEEN:
            self._passed = 0
            return_free_memory()
        if block.first < self.first:  # a command of the time before has taken the spoke source back
            block = block.part(min(self.first - block.first, len(block)), len(block))
        with self._changed:
            known = self.known_part(block) if len(block) and block.requests >= self._needed else None
            if known is None or self._stopping:
                return not self._stopping  # it comes again
            self._blocks.append(known)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._stopping or self._has_room)
            return not self._stopping

    @property
    def _has_room(self) -> bool:
        """Whether another block may wait; the lock is held."""
        is_steered = monotonic() - self._steered < STEERED_SECONDS
        azimuths = min(self._azimuths, STEERED_AHEAD) if is_steered else self._azimuths
        return sum(map(len, self._blocks)) < azimuths and sum(b.nbytes for b in self._blocks) < BYTES_AHEAD

    def _fail(self, reason: str) -> None:
        with self._changed:
            self._fault = reason
            self._changed.notify_all()


def block_spokes(cells: int) -> int:
    """Returns how many spokes of so many cells are computed and handed on together."""
    return min(BLOCK, max(1, BLOCK_BYTES // (BYTES_PER_CELL * cells)))


def prepared(
    spoke_source: SceneSpokeSource, scan: int = 0, timeout: float = PREPARE_TIMEOUT, commands: Iterable[Command] = ()
) -> SpokeWorker:
    """Returns a worker that has computed the first spokes of `scan`, as commanded. Raises SpokeSourceFault after `timeout`
    [s]."""
    spoke_source.skip_to(scan)
    worker = SpokeWorker(spoke_source, first=scan * spoke_source.info.radar.azimuths, commands=commands)
    worker.start()
    try:
        if worker.wait_until_ready(timeout):
            return worker
        raise SpokeSourceFault(f"no spokes after {timeout:g} s; the scene is too heavy for this machine")
    except SpokeSourceFault:
        worker.stop()
        raise
