"""What test processes do. Children import it by name."""

import os
import signal
import threading
from typing import Any

import numpy as np

from radar_service.processes import limits
from radar_service.processes.channel import Channel
from radar_service.processes.limits import machine_busy


def echo(control: Channel, data: Channel, *arguments: Any) -> None:
    """Sends its arguments back, then each message on the other channel."""
    control.send((os.getpid(), arguments))
    while True:
        control.send(data.receive())


def crash(*_: Any) -> None:
    """Dies as a bug in a library dies."""
    os.kill(os.getpid(), signal.SIGSEGV)


def twice(number: int) -> int:
    return 2 * number


def refuse(text: str) -> None:
    raise ValueError(text)


def fill(size: int) -> int:
    """Needs so many bytes."""
    return int(np.ones(size, dtype=np.uint8)[-1])


def wait(*_: Any) -> None:
    """Never returns."""
    threading.Event().wait()


def compute_for_ever() -> None:
    """Uses processor time."""
    while True:
        pass


def find_machine_busy(_: object) -> None:
    raise machine_busy("here", 1.0)


def niceness() -> tuple[int, int]:
    """Of this process and of its session."""
    return os.getpriority(os.PRIO_PROCESS, 0), session_niceness()


def session_niceness() -> int:
    return int(limits.SESSION.read_text().split()[-1])


def set_up_session_niceness() -> list[int]:
    """While a world is set up, and afterwards."""
    limits.busy_threads = lambda: 0.0
    return [limits.at_low_priority(session_niceness), session_niceness()]
