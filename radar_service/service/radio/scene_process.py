"""The spokes of a scene as the serving process has them: another process computes them, and some are read ahead."""

import contextlib
import math
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from time import monotonic
from typing import Any

from typing_extensions import override

from radar_service.processes.call import Progress
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import Child, ForkServer
from radar_service.processes.limits import (
    MachineBusyError,
    default_memory,
    machine_busy,
    processor_time_of,
    return_free_memory,
)
from radar_service.records import PowersOf, ShipStates, SourceRequest, SpokeBlock, Truth
from radar_service.service.radio.forks import RUN, MeasuredPlan, NewSpare
from radar_service.service.scene_request import MakeSimulator, SceneRequest, SceneSpokeSource
from radar_service.spoke_source import (
    BusyFault,
    Commanded,
    SpokeSourceFault,
    SpokeSourceInfo,
    TellsShips,
    TellsSources,
    TruthLine,
)
from radar_service.world import Command, CommandLog

AZIMUTHS_AHEAD = 128  # under half a second at 24 rpm and 720 azimuths: covers a slow block, and a new scene is not late
BYTES_AHEAD = 32 * 2**20  # of wide spokes
STEERED_AHEAD, STEERED_SECONDS = 32, 1.0  # azimuths, for so long after a command: the next one may drop them again
BYTES_BETWEEN = 256 * 2**20  # of spokes, then free memory is returned: the heap keeps holes as large as all that wait
BLOCK = 32  # spokes; a message holds no more
BYTES_PER_CELL = 12  # field and power
BLOCK_BYTES = 4 * 2**20  # of wide spokes: they cross from one process to the other before the first of them is sent
PREPARE_TIMEOUT = 120.0  # s that a spoke source may take to its first spokes
TRUTH_TIMEOUT = 10.0  # s
SPARE_TIMEOUT = 5.0  # s that a process may take to make its spare; it takes milliseconds
NO_PROCESS = "scene: no process could be started for it"
ENDED = "its process has ended: it crashed, was killed or ran out of memory"


class SceneProcess(Commanded, TellsSources, TellsShips):
    """A source of spokes: a scene in a process of its own, which `close` ends."""

    def __init__(self, child: Child, scene_request: SceneRequest, info: SpokeSourceInfo) -> None:
        """child: has sent its description, and tells its spare next. Raises EOFError and TimeoutError."""
        self._child, self.scene_request, self.info, self.trees = child, replace(scene_request, plan=None), info, 0
        assert isinstance(info.plan, dict)  # all who hold this description share it
        self._plan = info.plan
        self._spare, self._scan = _spare(child), 0
        self._commands: tuple[Command, ...] = ()  # before the start
        self._waiting: list[tuple[str, tuple[object, ...]]] = []  # for the start
        self._asking, self._changing, self._telling = threading.Lock(), threading.Lock(), threading.Lock()
        self._closed = self._is_answer_due = self._started = False

    @property
    def process(self) -> int:
        """Number of its process."""
        return self._child.process

    @property
    def spare_process(self) -> int | None:
        """Number of its spare's process, None where there is none."""
        return self._spare.process if self._spare else None

    def spare(self) -> "SceneProcess | None":
        """Returns the spare, ready to run in place of this process; None where there is none, or it was taken before."""
        with self._changing:
            spare, self._spare = self._spare, None
        if spare is None:
            return None
        try:
            spare.control.send(RUN)
            return SceneProcess(spare, self.scene_request, self.info)
        except (OSError, EOFError):  # TimeoutError is an OSError
            spare.close()
            return None

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the first one. Comes before `blocks`."""
        self._scan = scan

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields blocks, as SpokeSource.blocks, without end; once. Raises SpokeSourceFault where the process fails."""
        try:
            with self._telling:
                self._child.data.send((self._scan, size, self._commands))
                self._started = True
                for message in self._waiting:
                    self._child.data.send(message)
            while not isinstance(received := self._child.data.receive(), str):
                if isinstance(received, NewSpare):
                    self._take_spare(received)
                    continue
                if isinstance(received, MeasuredPlan):
                    self._plan.update(received.plan)
                    continue
                fields, self.trees = received
                yield SpokeBlock(**fields | {"range": self.info.range})
        except (OSError, EOFError):
            raise SpokeSourceFault(ENDED) from None
        raise SpokeSourceFault(received)

    def _take_spare(self, new: NewSpare) -> None:
        """Takes another spare. Without descriptors for it, it ends, and the process tells of one more. Raises EOFError."""
        with contextlib.suppress(OSError):
            self.replace_spare(Child(new.process, *self._child.data.receive_ends(2)))

    def take(self, command: Command) -> None:
        """Sends the process a command, as Commanded.take."""
        self._tell("take", command)

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Sends the process a request, as TellsSources.request_sources."""
        self._tell("request_sources", labels, powers, spoke)

    @override
    def replay(self, commands: Iterable[Command]) -> None:
        """Notes the commands; the process gets them with its start."""
        self._commands = tuple(commands)

    def _tell(self, method: str, *arguments: object) -> None:
        """Calls a method of the simulator."""
        with self._telling:
            if not self._started:
                self._waiting.append((method, arguments))
                return
            with contextlib.suppress(OSError):  # the process has ended: the next one is told all
                self._child.data.send((method, arguments))

    def truth(self, t: float) -> Truth:
        """Returns the state of everything at time t [s]. Raises SpokeSourceFault where the process fails."""
        answer: Truth = self._answer("truth", t)
        return answer

    @override
    def ship_states(self, times: Sequence[float], names: Sequence[str | None]) -> list[ShipStates]:
        """Raises SpokeSourceFault where the process fails."""
        answer: list[ShipStates] = self._answer("ship_states", list(times), list(names))
        return answer

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """Returns the truth of a scan, as SpokeSource.truth_lines. Raises SpokeSourceFault where the process fails."""
        answer: list[TruthLine] = self._answer("truth_lines", scan, radiometric)
        return answer

    def _answer(self, method: str, *arguments: object) -> Any:
        """Returns what the simulator answers. One question at a time: a late answer comes first."""
        deadline, control = monotonic() + TRUTH_TIMEOUT, self._child.control
        try:
            with self._asking:
                if self._is_answer_due:
                    control.receive(TRUTH_TIMEOUT)
                control.send((method, arguments))
                self._is_answer_due = True
                succeeded, answer = control.receive(max(0.0, deadline - monotonic()))
                self._is_answer_due = False
        except TimeoutError:
            raise BusyFault(f"truth: none after {TRUTH_TIMEOUT:g} s; try again later") from None
        except (OSError, EOFError):
            raise BusyFault(f"truth: {ENDED}; try again when another one runs") from None
        if not succeeded:
            raise SpokeSourceFault(answer)
        return answer

    def close(self) -> None:
        """Ends the process and its spare at once."""
        self._child.close()
        with self._changing:
            self._closed = True
            if self._spare:
                self._spare.close()

    def replace_spare(self, other: Child) -> None:
        """Takes another spare in place of one that has died."""
        with self._changing:
            unused, self._spare = (other, self._spare) if self._closed else (self._spare, other)
        if unused:
            unused.close()


class SceneProcessMaker:
    """Starts scene processes: a scene_request.MakeSpokeSource.

    make_simulator: makes the simulator in the process; it must be picklable. memory: that each process may use [bytes].
    """

    def __init__(self, server: ForkServer, make_simulator: MakeSimulator, memory: int | None = None) -> None:
        self._server, self._make_simulator = server, make_simulator
        self._memory = memory or default_memory()

    def __call__(self, scene_request: SceneRequest, progress: Progress) -> SceneProcess:
        """Returns the prepared scene of a scene request; waits for it.

        Raises SceneError where the scene is refused, SpokeSourceFault where the process fails or takes PREPARE_TIMEOUT, and
        BusyFault where it got less than half of that time from a processor, or cannot be started.
        """
        try:
            child = self._server.child(_run, scene_request, self._make_simulator, self._memory, progress.in_background)
        except OSError as error:
            raise BusyFault(f"{NO_PROCESS}: {error}; try again later") from None
        progress.ends_with(child.close)
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(child.close)
            spoke_source = _started(child, scene_request, progress)
            on_failure.pop_all()
        return spoke_source


def _run(control: Channel, data: Channel, *arguments: object) -> None:
    """Runs in the new process."""
    from radar_service.service.radio.scene_process_main import run_scene  # here: the serving process loads no scenes

    run_scene(control, data, *arguments)  # type: ignore[arg-type]  # as SceneProcessMaker gives them


def _spare(child: Child) -> Child | None:
    """Returns the spare of a process, which the process tells next. Raises EOFError and TimeoutError."""
    process = child.control.receive(SPARE_TIMEOUT)
    return None if process is None else Child(process, *child.control.receive_ends(2))


def _started(child: Child, scene_request: SceneRequest, progress: Progress) -> SceneProcess:
    deadline = monotonic() + PREPARE_TIMEOUT
    try:
        while True:
            kind, content = child.control.receive(max(0.0, deadline - monotonic()))
            if kind == "ready":
                return SceneProcess(child, scene_request, content)
            if kind == "refused":
                raise content
            progress.stage(content)
    except TimeoutError:
        raise _late(child.process) from None
    except OSError as error:  # TimeoutError is one, too
        raise BusyFault(f"{NO_PROCESS}: {error}; try again later") from None
    except MachineBusyError as error:
        raise BusyFault(str(error)) from None
    except EOFError:
        raise SpokeSourceFault(ENDED) from None
    except RuntimeError as error:
        raise SpokeSourceFault(str(error)) from None


def _late(process: int) -> SpokeSourceFault:
    """Returns why a process did not prepare its scene in time: the scene is heavy where it computed half of that time or more."""
    used = processor_time_of(process)
    if used is not None and used < 0.5 * PREPARE_TIMEOUT:
        return BusyFault(str(machine_busy("scene", PREPARE_TIMEOUT)))
    return SpokeSourceFault(f"not prepared after {PREPARE_TIMEOUT:g} s; the scene is too heavy for this machine")


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


def end(workers: Mapping[str, SpokeWorker]) -> None:
    """Ends prepared spoke sources that nobody needs."""
    for worker in workers.values():
        worker.stop()
