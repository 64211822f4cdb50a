"""Commands that wait for the transmitter, which makes them act from the first spoke that is not sent yet."""

import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from radar_service.scene.commands import Command

MAX_WAITING = 256  # commands; the transmitter takes all of them some 60 times a second
Values = Callable[[float], Mapping[str, Any]]  # of a command that acts at a time [s]


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
    """

    body: str | None
    values: Values
    supersedes: bool = False
    answers: list["Future[Command]"] = field(default_factory=list)

    def carry_out(self, time: float, command: Callable[[str | None, Mapping[str, Any]], Command]) -> bool:
        """Carries it out at `time` [s] and answers; returns whether it was accepted."""
        try:
            made = command(self.body, self.values(time))
        except Exception as error:  # of any kind: whoever waits must be told
            self.refuse(error)
            return False
        for answer in self.answers:
            if answer.set_running_or_notify_cancel():
                answer.set_result(made)
        return True

    def refuse(self, error: Exception) -> None:
        """Answers that it is not carried out."""
        for answer in self.answers:
            if answer.set_running_or_notify_cancel():
                answer.set_exception(error)


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
            command.refuse(NoRadarError(fault))

    def _superseded(self, body: str | None) -> list["Future[Command]"]:
        """Removes the command that is superseded by another one for a body; returns its answers."""
        for number, command in enumerate(self._waiting):
            if command.supersedes and command.body == body:
                del self._waiting[number]
                return command.answers
        return []
