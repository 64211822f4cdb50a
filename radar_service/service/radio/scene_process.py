"""The serving process's side of a scene process: the spokes of a scene that another process computes."""

import contextlib
import threading
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from time import monotonic
from typing import Any

from typing_extensions import override

from radar_service.processes.call import Progress
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import Child, ForkServer
from radar_service.processes.limits import MachineBusyError, default_memory, machine_busy, processor_time_of
from radar_service.records import PowersOf, ShipStates, SourceRequest, SpokeBlock, Truth
from radar_service.service.radio.plan_child import MeasuredPlan
from radar_service.service.radio.prefetch import PREPARE_TIMEOUT, BusyFault, SpokeSourceFault
from radar_service.service.radio.spare import RUN, NewSpare
from radar_service.service.scene_request import MakeSimulator, SceneRequest
from radar_service.spoke_source import Commanded, SpokeSourceInfo, TellsShips, TellsSources, TruthLine
from radar_service.world import Command

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
        self._waiting: list[Command | tuple[SourceRequest, int | None]] = []  # for the start
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
        self._tell(command)

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Sends the process a request, as TellsSources.request_sources."""
        self._tell((SourceRequest(labels, powers), spoke))

    @override
    def replay(self, commands: Iterable[Command]) -> None:
        """Notes the commands; the process gets them with its start."""
        self._commands = tuple(commands)

    def _tell(self, message: Command | tuple[SourceRequest, int | None]) -> None:
        with self._telling:
            if not self._started:
                self._waiting.append(message)
                return
            with contextlib.suppress(OSError):  # the process has ended: the next one is told all
                self._child.data.send(message)

    def truth(self, t: float) -> Truth:
        """Returns the state of everything at time t [s]. Raises SpokeSourceFault where the process fails."""
        answer: Truth = self._answer("truth", t)
        return answer

    @override
    def ship_states(self, times: Sequence[float], names: Sequence[str | None]) -> list[ShipStates]:
        """Raises SpokeSourceFault where the process fails."""
        answer: list[ShipStates] = self._answer("ship_states", (list(times), list(names)))
        return answer

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        """Returns the truth of a scan, as SpokeSource.truth_lines. Raises SpokeSourceFault where the process fails."""
        answer: list[TruthLine] = self._answer("radiometric_lines" if radiometric else "truth_lines", scan)
        return answer

    def _answer(self, question: str, argument: object) -> Any:
        """Returns what the process answers (scene_process_main.ANSWERS). One question at a time: a late answer comes first."""
        deadline, control = monotonic() + TRUTH_TIMEOUT, self._child.control
        try:
            with self._asking:
                if self._is_answer_due:
                    control.receive(TRUTH_TIMEOUT)
                control.send((question, argument))
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
