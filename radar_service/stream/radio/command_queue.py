"""Commands to one radar that wait for the command worker, which carries them out for all radars of the world."""

import itertools
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from radar_service.scene.commands import Command

MAX_WAITING = 256  # commands; the command worker takes all of them some 60 times a second
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
    number: rises from command to command, whatever the radar.
    """

    body: str | None
    values: Values
    supersedes: bool = False
    answers: list["Future[Command]"] = field(default_factory=list)
    number: int = field(default_factory=lambda: next(_NUMBERS))

    def begin(self) -> bool:
        """Returns whether anybody still waits for an answer; otherwise it is not carried out. From now on none can leave."""
        self.answers[:] = [answer for answer in self.answers if answer.set_running_or_notify_cancel()]
        return bool(self.answers)

    def carry_out(self, time: float, command: Callable[[str | None, Mapping[str, Any]], Command]) -> Outcome:
        """Carries it out at `time` [s]; returns what `answer` is to say. Comes after `begin`."""
        try:
            return command(self.body, self.values(time))
        except Exception as error:  # of any kind: whoever waits must be told
            return error

    def answer(self, outcome: Outcome) -> None:
        """Answers with the command, or with the reason why there is none. Comes after `begin`."""
        for answer in self.answers:
            if isinstance(outcome, Exception):
                answer.set_exception(outcome)
            else:
                answer.set_result(outcome)


class CommandQueue:
    """The commands that wait. May be used from any thread.

    notify: is called when there is one more. fault: why none is taken, None while they are.
    """

    def __init__(self, notify: Callable[[], None]) -> None:
        self.fault: str | None = None
        self._notify = notify
        self._waiting: list[WaitingCommand] = []
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, body: str | None, values: Values, supersedes: bool = False) -> "Future[Command]":
        """Adds a command; arguments as in `WaitingCommand`. Raises TooManyCommandsError and NoRadarError."""
        answer: Future[Command] = Future()
        with self._lock:
            if self.fault is not None:
                raise NoRadarError(self.fault)
            answers = self._superseded(body) if supersedes else []
            if len(self._waiting) >= MAX_WAITING:
                raise TooManyCommandsError(f"{MAX_WAITING} commands wait already; send fewer a second")
            self._waiting.append(WaitingCommand(body, values, supersedes, [*answers, answer]))
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
