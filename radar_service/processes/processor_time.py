"""How much processor time it may take to read what strangers send, and how long a busy machine may take to give it.

Processor time decides, so that an answer does not depend on what else the machine does. Wall-clock time is a backstop alone.
"""

import sys

MAX_PROCESSOR_TIME = 10.0  # s per file or body, from the beginning of its parsing
BACKSTOP = 120.0  # s of wall clock, with the start of the process that parses
BUSY = "the machine is busy: it gave too little processor time in {:g} s; try again later"

if sys.platform != "win32":  # Windows has no such limit; only the backstop applies
    import resource


class MachineBusyError(Exception):
    """The machine did not do something in time, though that needs little of its processor time. The text says what."""


def machine_busy(location: str, seconds: float) -> MachineBusyError:
    """Returns the error for what was not done in so many seconds. location: what waits, as a line of a refusal begins."""
    return MachineBusyError(f"{location}: {BUSY.format(seconds)}")


def used_processor_time() -> float:
    """Returns the processor time that this process has used [s]; 0 where the system does not tell."""
    if sys.platform == "win32":
        return 0.0
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def limit_processor_time(seconds: float) -> None:
    """Lets this process use so much more processor time [s], to the next whole second; then SIGXCPU ends it."""
    if sys.platform != "win32":
        hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
        resource.setrlimit(resource.RLIMIT_CPU, (int(used_processor_time() + seconds) + 1, hard))
