"""Progress of long commands: a bar on a terminal, and elsewhere a line now and then."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TextIO, TypeVar

from tqdm import tqdm

SECONDS = 5.0  # between lines: a log of an hour has some hundred

Item = TypeVar("Item")


def progress(
    items: Iterable[Item], count: int, unit: str, name: Callable[[Item], str], stream: TextIO | None = None,
    clock: Callable[[], float] = time.monotonic, remark: Callable[[], str] = str, within: bool = False,
) -> Iterator[Item]:  # fmt: skip
    """Yields items, and shows on a stream, by default standard error, how many of `count` are done, the rate and the time left.

    unit: of the items, in the plural. name: what is said of an item that is done. Without a terminal, a line is written for
    the first and the last item, and else at most each SECONDS. remark: what else is said, as of failures. within: whether the
    items are parts of one of many jobs: there is no bar, and a line after SECONDS at the earliest.
    """
    stream = stream or sys.stderr
    if stream.isatty() and not within:
        with tqdm(items, total=count, unit=unit, file=stream) as bar:
            for item in bar:
                yield item
                bar.set_postfix_str(remark())
        return
    began = written = clock()
    for done, item in enumerate(items, 1):
        yield item
        now = clock()
        if (done in (1, count) and not within) or now - written >= SECONDS:
            written = now
            print(
                f"{name(item)}: {done} of {count} {unit}{_rate(done, count, unit, now - began)}{_also(remark())}",
                file=stream,
                flush=True,
            )


def _rate(done: int, count: int, unit: str, elapsed: float) -> str:
    if elapsed <= 0.0:
        return ""
    return f", {done / elapsed:.2g} {unit} a second, {elapsed * (count - done) / done:.0f} s left"


def _also(text: str) -> str:
    return f", {text}" if text else ""
