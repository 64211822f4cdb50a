"""What a child process is given: its environment, its limits, and the priority and processors of its set-up.

Linux shares processors among threads by their niceness, or, where it groups them by session (autogroup in sched(7)), among
sessions by the niceness of each: that of threads then acts within their session only. So both are set.

A thread that wakes up may still wait for milliseconds until one of lower priority makes room. So set-up leaves a processor free.

What strangers send is read within a limit of processor time; wall-clock time is a backstop alone.
"""

import contextlib
import ctypes
import math
import os
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Result = TypeVar("Result")

SET_UP_NICENESS = 10  # a tenth of the processor time that the feed gets where both want it
LEVEL = 1.25  # ratio of the weights of two levels of niceness, of Linux (sched(7))
MIN_MEMORY = 2 * 2**30  # bytes
SESSION, STATISTICS = Path("/proc/self/autogroup"), Path("/proc/stat")
LOOKS, LOOK_PAUSE = 8, 0.01  # s
SMALLEST = 0.1  # threads per processor: the same as none
SESSION_TRIES, SESSION_PAUSE = (
    20,
    0.05,
)  # the kernel takes ten such requests a second from all unprivileged processes together

if sys.platform != "win32":  # Windows has no such limits; only the backstop applies
    import resource

MAX_PROCESSOR_TIME = 10.0  # s per file or body, from the beginning of its parsing
BACKSTOP = 120.0  # s of wall clock, with the start of the process that parses
BUSY = "the machine is busy: it gave too little processor time in {:g} s; try again later"


def child_environment() -> dict[str, str]:
    """Returns what a child process needs of the environment: it finds modules as this process does, and BLAS has one thread."""
    path = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)
    return {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def default_memory() -> int:
    """Returns the memory that the process of a scene may use [bytes]: half of the machine's, at least MIN_MEMORY."""
    try:
        machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError, AttributeError):
        return MIN_MEMORY
    return max(MIN_MEMORY, machine // 2)


def processor_time_of(process: int) -> float | None:
    """Returns the processor time that a process has used [s], with its children that have ended; None where nobody knows."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")  # utime, stime, cutime, cstime of proc(5)
    except (OSError, ValueError):
        return None


def return_free_memory() -> None:
    """Gives memory that was freed back to the system, where the C library can (glibc). It takes 2 to 13 ms."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim:
        trim(0)


def limit_memory(maximum: int) -> None:
    """Limits this process to `maximum` [bytes] more than now; an allocation beyond it raises MemoryError. No core dumps."""
    if sys.platform == "linux":  # other systems do not keep the limit, or have none
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + maximum, used + maximum))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def forbid_access() -> None:
    """Forbids this process new files, sockets and processes, and writing to files, where the system has such limits."""
    if sys.platform != "win32":
        for kind, maximum in ((resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_NPROC, 0), (resource.RLIMIT_NOFILE, 3)):
            resource.setrlimit(kind, (maximum, maximum))


def set_session_niceness(niceness: int) -> None:
    """Sets the niceness, 0 or more, of the session of this process, where the system has one."""
    for _ in range(SESSION_TRIES):
        with contextlib.suppress(BlockingIOError):
            with contextlib.suppress(FileNotFoundError, PermissionError):
                SESSION.write_text(str(niceness))
            return
        time.sleep(SESSION_PAUSE)


def leave_processor_free() -> None:
    """Keeps this thread, and those that it starts, off the first processor that it may use, where there are more."""
    if sys.platform == "linux":
        usable = os.sched_getaffinity(0)
        if len(usable) > 1:
            with contextlib.suppress(PermissionError):  # some containers forbid it
                os.sched_setaffinity(0, usable - {min(usable)})


def busy_threads() -> float:
    """Returns how many other threads want each processor all the time: not those of a feed, which waits in between."""
    running = []
    for _ in range(LOOKS):
        time.sleep(LOOK_PAUSE)
        with contextlib.suppress(OSError, IndexError):  # a system that does not tell
            running.append(int(STATISTICS.read_text().partition("procs_running ")[2].split()[0]))
    return (min(running, default=1) - 1) / (os.cpu_count() or 1)


def set_up_niceness() -> int:
    """Returns the niceness of set-up that begins now: SET_UP_NICENESS, or less where other programs would leave it less than a
    fifth of a processor; 0 at least."""
    fifth = math.log(4.0 / max(busy_threads(), SMALLEST)) / math.log(LEVEL)
    return int(min(max(fifth, 0.0), SET_UP_NICENESS))


def lower_priority() -> None:
    """Lowers the priority of this process for good, and keeps it off a processor."""
    leave_processor_free()
    niceness = set_up_niceness()
    if sys.platform != "win32":
        os.nice(niceness)
    set_session_niceness(niceness)


def at_low_priority(work: Callable[[], Result]) -> Result:
    """Returns work(), computed in a thread of low priority off a processor: a process may lower its priority but not raise it
    again.

    The session of this process has that priority meanwhile; it must be of this process alone.
    """
    results: list[Result] = []
    errors: list[BaseException] = []
    niceness = set_up_niceness()

    def run() -> None:
        try:
            if sys.platform == "linux":  # where a thread has a priority of its own
                own = os.getpriority(os.PRIO_PROCESS, 0)
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), max(own, niceness))
                leave_processor_free()
            results.append(work())
        except BaseException as error:
            errors.append(error)

    set_session_niceness(niceness)
    thread = threading.Thread(target=run, name="set-up", daemon=True)
    thread.start()
    thread.join()
    set_session_niceness(0)
    if errors:
        raise errors[0]
    return results[0]


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


def peak_memory() -> int:
    """Returns the most memory that this process has had at a time [bytes]; 0 where the system does not tell."""
    if sys.platform == "win32":
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def limit_processor_time(seconds: float) -> None:
    """Lets this process use so much more processor time [s], to the next whole second; then SIGXCPU ends it."""
    if sys.platform != "win32":
        hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
        resource.setrlimit(resource.RLIMIT_CPU, (int(used_processor_time() + seconds) + 1, hard))
