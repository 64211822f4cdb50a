"""Measures the plan of a scene beside its first spokes, in a process that is forked from the scene's.

Counting echoes and timing tiles takes some 0.7 s, for which the first spoke does not wait. A process of its own has caches of its
own, so what it computes ahead disturbs no spoke, whatever is commanded meanwhile.
"""

import contextlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from radar_service.processes.channel import Channel, forked
from radar_service.processes.limits import set_up_niceness

Plan = Mapping[str, Any]


@dataclass(frozen=True)
class MeasuredPlan:
    """Says on the data channel what the plan is with its counts and costs."""

    plan: Plan


class PlanChild:
    """The process that measures. result: where its plan arrives."""

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
