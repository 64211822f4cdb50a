"""File descriptors of this process: how many are open, and a limit for a while."""

import contextlib
import os
import resource
from collections.abc import Iterator


def open_descriptors() -> set[int]:
    return {int(name) for name in os.listdir("/proc/self/fd") if os.path.exists(f"/proc/self/fd/{name}")}


@contextlib.contextmanager
def descriptors_left(count: int) -> Iterator[None]:
    """Lets this process open so many more, and no others."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    taken = open_descriptors()
    free = (number for number in range(soft) if number not in taken)
    top = max(next(free) for _ in range(count + 1))
    resource.setrlimit(resource.RLIMIT_NOFILE, (top, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@contextlib.contextmanager
def descriptors_taken(count: int) -> Iterator[None]:
    """Lets this process open none below that number for a while."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 2 * count), hard))
    with contextlib.ExitStack() as at_end:
        at_end.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        while (taken := os.dup(0)) < count:
            at_end.callback(os.close, taken)
        at_end.callback(os.close, taken)
        yield
