"""SIGTERM and SIGINT end a command in order: a service also before its server runs, a bench with what it has started."""

import contextlib
import signal
from collections.abc import Iterator, Sequence

STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)
TERMINATED = 128 + signal.SIGTERM  # status of a program that ends in order by SIGTERM, as shells give it


@contextlib.contextmanager
def ended_by_signals(numbers: Sequence[signal.Signals] = STOP_SIGNALS, status: int = 0) -> Iterator[None]:
    """Raises SystemExit of that status in the block at the first of these signals; further ones are ignored. For the main
    thread."""

    def end(*_: object) -> None:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)
        raise SystemExit(status)

    before = {number: signal.signal(number, end) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
