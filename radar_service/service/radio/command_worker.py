"""Commands that wait, and the thread that carries them out: one time for all radars, also while a radar waits for a client.

A command acts at the time of the first spoke of any radar that is not sent and comes after all spokes that were sent. Each radar
shows it from its first spoke not before that time. Each costs a block that is computed anew: so commands wait while a radar
that is late sends the first spokes after the commands before, and many commands do not stop a feed.
"""

import asyncio
import itertools
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple, Protocol

from radar_service.service.radio.pacer import GroupClock
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.spoke_source import Commanded
from radar_service.world import Command, CommandError

MAX_WAITING = 256  # commands; the command worker takes all of them some 60 times a second
COMMAND_TIMEOUT = 10.0  # s until a command is given up; it takes the time of a batch of spokes
LOOK = 0.05  # s between two looks at whether radars take the commands that wait
_NUMBERS = itertools.count()
Values = Callable[[float], Mapping[str, Any]]  # of a command that acts at a time [s]
Outcome = Command | Exception  # of a command that waited: itself, or why it is refused


class TooManyCommandsError(Exception):
    """More commands come than the radar carries out."""


class NoRadarError(Exception):
    """The radar carries out no commands. The text says why."""


@dataclass(frozen=True)
class WaitingCommand:
    """A command that waits.

    body: its name; None for own ship.
    values: of the command, once it is known when it acts.
    supersedes: whether it stands for all that the body is ordered: an earlier one of the same kind is not carried out.
    answers: receive the command, or the reason why it is refused.
    by: what sent it, as in `Command`.
    number: rises from command to command, whatever the radar.
    """

    body: str | None
    values: Values
    supersedes: bool = False
    answers: list["Future[Command]"] = field(default_factory=list)
    by: str | None = None
    number: int = field(default_factory=lambda: next(_NUMBERS))

    def begin(self) -> bool:
        """Returns whether anybody still waits for an answer; otherwise it is not carried out. From now on none can leave."""
        self.answers[:] = [answer for answer in self.answers if answer.set_running_or_notify_cancel()]
        return bool(self.answers)

    def carry_out(self, time: float, command: Callable[[str | None, Mapping[str, Any]], Command]) -> Outcome:
        """Carries it out at `time` [s]; returns what `answer` is to say. Comes after `begin`."""
        try:
            return command(self.body, self.values(time))
        except Exception as error:  # of any kind: who waits must be told
            return error

    def answer(self, outcome: Outcome) -> None:
        """Answers with the command, or with the reason why there is none. Comes after `begin`."""
        for answer in self.answers:
            if isinstance(outcome, Exception):
                answer.set_exception(outcome)
            else:
                answer.set_result(outcome)


class CommandQueue:
    """The commands to a radar that wait. May be used from any thread.

    notify: is called when there is one more. fault: why none is taken, None while they are.
    """

    def __init__(self, notify: Callable[[], None]) -> None:
        self.fault: str | None = None
        self._notify = notify
        self._waiting: list[WaitingCommand] = []
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._waiting)

    async def command(self, body: str | None, values: Values, supersedes: bool = False, by: str | None = None) -> Command:
        """Commands own ship (None) or a body, on all radars of the group, from the first spoke that is not sent yet; returns the
        command as this radar has it. For an event loop.

        values, supersedes, by: as in `WaitingCommand`. Raises CommandError, NoRadarError and TooManyCommandsError.
        """
        waiting = self.put(body, values, supersedes, by)
        try:
            async with asyncio.timeout(COMMAND_TIMEOUT):
                return await asyncio.wrap_future(waiting)
        except TimeoutError:
            raise TooManyCommandsError(
                f"the radar has sent no spoke for {COMMAND_TIMEOUT:g} s, and takes no command meanwhile"
            ) from None

    def put(self, body: str | None, values: Values, supersedes: bool = False, by: str | None = None) -> "Future[Command]":
        """Adds a command; arguments as in `WaitingCommand`. Raises TooManyCommandsError and NoRadarError."""
        answer: Future[Command] = Future()
        with self._lock:
            if self.fault is not None:
                raise NoRadarError(self.fault)
            answers = self._superseded(body) if supersedes else []
            if len(self._waiting) >= MAX_WAITING:
                raise TooManyCommandsError(f"{MAX_WAITING} commands wait already; send fewer a second")
            self._waiting.append(WaitingCommand(body, values, supersedes, [*answers, answer], by))
        self._notify()
        return answer

    def take(self) -> list[WaitingCommand]:
        """Returns all commands that wait, in the order of their arrival; they wait no longer."""
        with self._lock:
            taken, self._waiting = self._waiting, []
        return taken

    def close(self, fault: str | None) -> None:
        """Refuses all commands with this reason, now and later; None opens the queue again."""
        with self._lock:
            self.fault = fault
        for command in self.take() if fault is not None else ():
            if command.begin():
                command.answer(NoRadarError(fault))

    def _superseded(self, body: str | None) -> list["Future[Command]"]:
        """Removes the command that is superseded by another one for a body; returns its answers."""
        for number, command in enumerate(self._waiting):
            if command.supersedes and command.body == body:
                del self._waiting[number]
                return command.answers
        return []


class Steered(NamedTuple):
    """What commands to a radar act on.

    worker: of its spoke source; next_spoke: number of the first one that is not sent; newest: time of the last one sent [s], -inf
    before the first one.
    """

    worker: SpokeWorker
    next_spoke: int
    newest: float

    def time_after(self, time: float) -> float:
        """Returns the time [s] of the first spoke that is not sent and comes after another time [s]."""
        radar = self.worker.spoke_source.info.radar
        spoke = self.next_spoke
        if math.isfinite(time):
            spoke = max(spoke, radar.first_spoke(math.nextafter(time, math.inf)))
        return radar.time_of_spokes(float(spoke))


class CommandedRadar(Protocol):
    """A radar as the command worker has it: a `Transmitter`. All but `commands` is read with the clock's lock held."""

    @property
    def commands(self) -> CommandQueue:
        """The commands that wait."""

    @property
    def is_commanded(self) -> bool:
        """Whether it runs; one that has failed or stopped is left out."""

    @property
    def takes_commands(self) -> bool:
        """Whether commands would not stop its feed now."""

    @property
    def steered(self) -> Steered | None:
        """What commands act on; None while another scene is about to begin."""

    def commanded(self) -> None:
        """Counts the commands that came, and lets the radar go on."""


class CommandWorker:
    """Carries out the commands to all radars of a group, in the order of their arrival.

    clock: of the group. Its lock guards the radars.
    """

    def __init__(self, clock: GroupClock) -> None:
        self.clock = clock
        self._radars: list[CommandedRadar] = []
        self._running = 0  # radars that were started and not stopped
        self._thread: threading.Thread | None = None

    def join(self, radar: CommandedRadar) -> None:
        """Adds a radar."""
        with self.clock.changed:
            self._radars.append(radar)

    def leave(self, radar: CommandedRadar) -> None:
        """Removes a radar: commands to it are not carried out any more."""
        with self.clock.changed:
            self._radars.remove(radar)

    def start(self) -> None:
        """Starts the thread with the first radar."""
        with self.clock.changed:
            self._running += 1
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="radar commands", daemon=True)
                self._thread.start()

    def stop(self, timeout: float) -> None:
        """Ends the thread with the last radar, and waits for it at most `timeout` [s]."""
        with self.clock.changed:
            self._running -= 1
            self.clock.let_command()
        if self._thread is not None and self._running <= 0:
            self._thread.join(timeout)

    def _run(self) -> None:
        while self._carry_out():
            continue

    def _carry_out(self) -> bool:
        """Waits for commands and carries them out; returns False at the end."""
        with self.clock.changed:
            while self._running > 0 and not self._is_ready():
                self.clock.may_command.wait(LOOK if self._has_commands else None)
            if self._running <= 0:
                return False
            radars = [radar for radar in self._radars if radar.is_commanded]
            steered = {radar: commanded for radar in radars if (commanded := radar.steered)}
            outcomes = self._outcomes(steered) if steered else []  # none where all have failed since
            if any(isinstance(outcome, Command) for _, outcome in outcomes):
                for radar in radars:
                    radar.commanded()
                self.clock.notify()
        for commanded in steered.values():
            commanded.worker.tell()  # without the lock: a process may be slow to read
        for waiting, outcome in outcomes:
            waiting.answer(outcome)
        return True

    @property
    def _has_commands(self) -> bool:
        return any(len(radar.commands) for radar in self._radars if radar.is_commanded)

    def _is_ready(self) -> bool:
        radars = [radar for radar in self._radars if radar.is_commanded]
        return self._has_commands and all(radar.takes_commands and radar.steered is not None for radar in radars)

    def _outcomes(self, steered: Mapping[CommandedRadar, Steered]) -> list[tuple[WaitingCommand, Outcome]]:
        """Carries out all commands that wait; returns what has become of each."""
        time = time_of_commands(list(steered.values()))
        waiting = [(each.number, each, radar) for radar in steered for each in radar.commands.take()]
        return [
            (each, each.carry_out(time, partial(command_all, steered, radar, time, each.by)))
            for _, each, radar in sorted(waiting, key=lambda item: item[0])
            if each.begin()
        ]


def time_of_commands(radars: Sequence[Steered]) -> float:
    """Returns the time [s] of the first spoke of any radar that is not sent, after all that were sent."""
    newest = max(radar.newest for radar in radars)
    return min(radar.time_after(newest) for radar in radars)


def command_all(
    radars: Mapping[CommandedRadar, Steered],
    addressed: CommandedRadar,
    time: float,
    by: str | None,
    body: str | None,
    values: Mapping[str, Any],
) -> Command:
    """Commands all radars that have the body, at a time [s]; returns the command of the one that was addressed.

    by: as in `Command`; body: as that radar names it. Raises CommandError, and then nothing changes.
    """
    if not isinstance(radars[addressed].worker.spoke_source, Commanded):
        raise CommandError("this radar replays a recording; nothing is steered")
    steerable = radars[addressed].worker.spoke_source.info.scene.steerable
    names = {addressed: body}
    for radar in radars:
        limits = radars[radar].worker.spoke_source.info.scene.steerable.limits
        name = steerable.name_of(body)
        if radar is not addressed and (name in limits or body is not None):
            names[radar] = name
    command = replace(radars[addressed].worker.commands.command(None, body, values, time), by=by)
    for radar, name in names.items():
        worker = radars[radar].worker
        worker.command(command if radar is addressed else worker.spoke_source.info.scene.steerable.seen(command, name))
    return command
