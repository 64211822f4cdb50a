"""Calls one function in a process of its own, with limits, and returns its result; and how one follows what takes long."""

import signal
import threading
from collections.abc import Callable
from typing import Any, NoReturn

from radar_service.processes.channel import Channel, portable
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import (
    BACKSTOP,
    MAX_PROCESSOR_TIME,
    MachineBusyError,
    limit_memory,
    limit_processor_time,
    lower_priority,
    machine_busy,
)

MEMORY = 2**30  # bytes above what an idle process has


class Progress:
    """The progress of a preparation, which can end it; from any thread.

    in_background: whether the feed of a radar comes first. doing: what is being done now.
    """

    in_background, doing = False, ""

    def __init__(self) -> None:
        self._closes: list[Callable[[], None]] = []
        self._closed, self._closing = False, threading.Lock()

    def stage(self, text: str) -> None:
        """Notes what is being done now."""
        self.doing = text

    def ends_with(self, close: Callable[[], None]) -> None:
        """Notes what to call where the preparation is to end early; calls it where it has been ended."""
        with self._closing:
            if not self._closed:
                return self._closes.append(close)
        close()

    def close(self) -> None:
        """Ends the preparation early, all that is still to come too."""
        with self._closing:
            self._closed = True
            closes, self._closes = self._closes, []
        for close in closes:
            close()

    def finish(self) -> None:
        """Forgets what would end it: what was prepared is the caller's."""
        with self._closing:
            self._closes.clear()


class ProcessFault(Exception):
    """The process did not return a result. The text says why."""


def call_in_process(server: ForkServer, progress: Progress, function: Callable[..., Any], *arguments: object) -> Any:
    """Returns function(*arguments), computed in a process within MEMORY and MAX_PROCESSOR_TIME.

    Raises what the function raises, ProcessFault where the process ends without a result, and MachineBusyError where it has none
    after BACKSTOP or cannot be started.
    """
    try:
        child = server.child(run_call, function, arguments, MEMORY, MAX_PROCESSOR_TIME)
    except OSError as error:
        raise MachineBusyError(f"request: no process could be started for it: {error}; try again later") from None
    progress.ends_with(child.close)
    try:
        succeeded, result = child.control.receive(BACKSTOP)
    except TimeoutError:
        raise machine_busy("request", BACKSTOP) from None
    except EOFError:
        raise ProcessFault(f"it took more than {MEMORY / 2**20:.0f} MiB, or crashed") from None
    finally:
        child.close()
    if not succeeded:
        raise result
    return result


def run_call(
    control: Channel, _: Channel, function: Callable[..., Any], arguments: tuple[Any, ...], memory: int, seconds: float
) -> None:
    """Runs the process, which sends whether the function succeeded, and its result or exception.

    memory: what it may use [bytes]; seconds: of processor time.
    """

    def refuse_more_time(*_: object) -> NoReturn:
        signal.signal(signal.SIGXCPU, signal.SIG_IGN)  # which the system repeats each second
        raise ProcessFault(f"it took more than {seconds:g} s of processor time")

    limit_memory(memory)
    lower_priority()
    signal.signal(signal.SIGXCPU, refuse_more_time)
    limit_processor_time(seconds)
    try:
        answer: tuple[bool, Any] = True, function(*arguments)
    except MemoryError:
        return  # which the service takes for the end that it is
    except Exception as error:
        answer = False, portable(error)
    control.send(answer)
