"""Processes forked from that of a prepared scene, which share its memory: its spare waits, and runs when that one has died;
another one measures its plan.

Forking takes milliseconds where preparing takes seconds. A process with threads may fork only while those hold no lock; here
they sleep. A spare that does not deliver all the same is replaced by a world that is prepared anew.
"""

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from radar_service.processes.channel import Channel, forked
from radar_service.processes.limits import set_up_niceness

RUN = "run"  # the order to a spare
Announce = Callable[[int | None], Channel]  # sends the number of a spare; returns the channel that its ends follow on
Plan = Mapping[str, Any]


@dataclass(frozen=True)
class NewSpare:
    """Says on the data channel that a spare has replaced one that has died; its ends follow."""

    process: int


class SpareTakesOver(Exception):
    """Raised in a spare that runs from now on, by `Spares.renew`."""


class Spares:
    """The spare of this process. ends: channels of this process; is_spare: whether it was a spare itself."""

    def __init__(self, control: Channel, data: Channel) -> None:
        self.ends, self.is_spare = (control, data), False
        self._process = -1

    def first(self) -> None:
        """Forks the first spare and tells it on the control channel: its number, None where none can be made, and its ends.

        Returns in the spare, too, when the service orders it to run; that has a spare of its own then. Raises EOFError in a
        spare that is not needed.
        """
        while self._forked(self._told_first):
            continue

    def renew(self, answering: threading.Lock) -> None:
        """Forks another spare where the one that was made has died, and tells it on the data channel by a NewSpare.

        answering: while a thread holds it there is no fork, as nobody would release it in the spare; nothing waits for it.
        Raises in the spare: TakeOver when it is to run, after which it calls `first`, and EOFError when it is not needed.
        """
        if self._process <= 0 or _exists(self._process) or not answering.acquire(blocking=False):
            return
        try:
            takes_over = self._forked(self._told_later)
        finally:
            answering.release()
        if takes_over:
            raise SpareTakesOver

    def _told_first(self, process: int | None) -> Channel:
        self.ends[0].send(process)
        return self.ends[0]

    def _told_later(self, process: int | None) -> Channel:
        if process:
            self.ends[1].send(NewSpare(process))
        return self.ends[1]

    def _forked(self, tell: Announce) -> bool:
        """Forks a spare. Returns False in this process; True in the spare, with its own ends, when it is to run."""
        try:
            self._process, ends = forked(2)
        except OSError:
            self._process, ends = -1, []
        if not self._process:
            return self._told_to_run(*ends)
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # a spare that has ended leaves no zombie
        channel = tell(self._process if self._process > 0 else None)
        if ends:
            channel.send_ends(ends)
        for end in ends:
            end.forget()
        return False

    def _told_to_run(self, control: Channel, data: Channel) -> bool:
        """Runs a spare while it waits."""
        for end in self.ends:
            end.forget()
        self.ends, self.is_spare = (control, data), True
        if control.receive() != RUN:
            raise EOFError
        return True


def _exists(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@dataclass(frozen=True)
class MeasuredPlan:
    """Says on the data channel what the plan is with its counts and costs."""

    plan: Plan


class PlanChild:
    """The process that measures the plan of a scene beside its first spokes. result: where its plan arrives.

    It takes some 0.7 s, for which the first spoke does not wait, and with caches of its own disturbs no spoke.
    """

    def __init__(self, result: Channel) -> None:
        self._result: Channel | None = result

    @classmethod
    def forked(cls, measure: Callable[[], Plan], ends: tuple[Channel, Channel]) -> Self | None:
        """Returns the process that calls `measure`; None where none can be forked.

        ends: the channels of this process, which the child gives up at once: they close when this process ends.
        """
        try:
            process, (channel,) = forked(1)
        except OSError:
            return None
        if not process:
            try:
                for end in ends:
                    end.forget()
                os.nice(set_up_niceness())
                channel.send(measure())
            finally:
                os._exit(0)
        return cls(channel)

    def measured(self) -> Plan | None:
        """Returns the plan once, when it has come; None before and after that, and where the child has died."""
        if self._result is None or not self._result.wait(0.0):
            return None
        plan: Plan | None = None
        with contextlib.suppress(EOFError):
            plan = self._result.receive()
        self._result.close()
        self._result = None
        return plan
