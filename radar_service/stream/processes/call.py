"""Calls one function in a process of its own, with limits, and returns its result."""

from collections.abc import Callable
from typing import Any

from radar_service.stream.processes.channel import Channel
from radar_service.stream.processes.fork_server import ForkServer
from radar_service.stream.processes.limits import limit_memory, lower_priority
from radar_service.stream.source import Progress

MEMORY = 2**30  # bytes above what an idle process has
TIMEOUT = 30.0  # s


class ProcessFault(Exception):
    """The process did not return a result. The text says why."""


def call_in_process(server: ForkServer, progress: Progress, function: Callable[..., Any], *arguments: object) -> Any:
    """Returns function(*arguments), computed in a process within MEMORY and TIMEOUT.

    Raises what the function raises, and ProcessFault where the process ends without a result.
    """
    child = server.child(run_call, function, arguments, MEMORY)
    progress.ends_with(child.close)
    try:
        succeeded, result = child.control.receive(TIMEOUT)
    except TimeoutError:
        raise ProcessFault(f"it took more than {TIMEOUT:g} s") from None
    except EOFError:
        raise ProcessFault(f"it took more than {MEMORY / 2**20:.0f} MiB, or crashed") from None
    finally:
        child.close()
    if not succeeded:
        raise result
    return result


def run_call(control: Channel, _: Channel, function: Callable[..., Any], arguments: tuple[Any, ...], memory: int) -> None:
    """Is the life of the process. It sends whether the function succeeded, and its result or exception."""
    limit_memory(memory)
    lower_priority()
    try:
        answer: tuple[bool, Any] = True, function(*arguments)
    except MemoryError:
        return  # which the service takes for the end that it is
    except Exception as error:
        answer = False, error
    control.send(answer)
