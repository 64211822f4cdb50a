"""The radar live in a terminal: `python -m clients.ppi ws://127.0.0.1:8000 --live`. q, Ctrl-C or a signal ends it."""

import asyncio
import contextlib
import os
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator

from .client import FeedClient, FeedError
from .scope import Scope, half_blocks

if sys.platform != "win32":
    import termios
    import tty

INTERVAL = 0.1  # s between pictures
SHARE = 0.25  # of the time, at most, goes into drawing, so that the feed is read in time
BINS = 512  # per spoke: more than a terminal has pixels
LEAST = (24, 8)  # columns and lines of a terminal on which anything is seen
ENTER, LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[0m\x1b[?25h\x1b[?1049l"  # another screen, no cursor; back to what was there
CAPTIONS = 2  # lines


class Status:
    """The last word on the connection."""

    def __init__(self) -> None:
        self.text = "no break so far"

    def __call__(self, text: str) -> None:
        self.text = text


async def show(client: FeedClient, scope: Scope, status: Status) -> None:
    """Receive and draw until the user ends it. Raises FeedError where the feed is over, and OSError without a terminal."""
    if not sys.stdout.isatty():
        raise OSError("--live draws on a terminal, and the output is none; leave out the redirection, or use --out FILE")
    stop = asyncio.Event()
    with _screen(), _ended_by_user(stop.set):
        tasks = [asyncio.create_task(act) for act in (_receive(client, scope), _paint(client, scope, status), _wait(stop))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            ends = await asyncio.gather(*tasks, return_exceptions=True)
            await client.close()
    for end in ends:
        if isinstance(end, Exception):
            raise end


async def _wait(stop: asyncio.Event) -> None:
    await stop.wait()


async def _receive(client: FeedClient, scope: Scope) -> None:
    async for message in client.messages():
        try:
            scope.take(message)
        except (LookupError, TypeError, ValueError) as fault:
            raise FeedError(f"the radar sent a {message['type']} message that cannot be used: {fault!r}") from fault


async def _paint(client: FeedClient, scope: Scope, status: Status) -> None:
    size = (0, 0)
    while True:
        began = time.monotonic()
        now = shutil.get_terminal_size()
        clear = "" if (now.columns, now.lines) == size else "\x1b[2J"
        size = (now.columns, now.lines)
        sys.stdout.write(clear + screen(scope, account(client, status.text), *size))
        sys.stdout.flush()
        await asyncio.sleep(max(INTERVAL, (time.monotonic() - began) / SHARE))


def account(client: FeedClient, text: str) -> str:
    """What came, and how the connection is, in a line."""
    ledger = client.ledger
    return f"q ends; {ledger.received} spokes came, {ledger.lost} lost; {text}"


def screen(scope: Scope, below: str, columns: int, lines: int) -> str:
    """What to write to show a scope and a line below it on a terminal of that size."""
    if columns < LEAST[0] or lines < LEAST[1]:
        return f"\x1b[1;1H\x1b[0m{_plain(f'at least {LEAST[0]} x {LEAST[1]}', columns)}\x1b[J"
    size = min(columns, 2 * (lines - CAPTIONS))
    left = (columns - size) // 2 + 1
    rows = half_blocks(scope.image(size))
    picture = "".join(f"\x1b[{k};{left}H{row}" for k, row in enumerate(rows, CAPTIONS))
    return (
        f"\x1b[1;1H\x1b[0m{_plain(scope.caption, columns)}\x1b[K{picture}"
        f"\x1b[{CAPTIONS + len(rows)};1H{_plain(below, columns)}\x1b[K"
    )


def _plain(text: str, columns: int) -> str:
    """Text that fits, and that cannot command the terminal, whoever wrote it."""
    return "".join(c if c.isprintable() else "?" for c in text)[:columns]


@contextlib.contextmanager
def _screen() -> Iterator[None]:
    """The terminal's other screen; afterwards what was there before."""
    sys.stdout.write(ENTER)
    try:
        yield
    finally:
        sys.stdout.write(LEAVE)
        sys.stdout.flush()


@contextlib.contextmanager
def _ended_by_user(stop: Callable[[], None]) -> Iterator[None]:
    """Calls `stop` at q or Q, and at the signals that end programs, while keys are neither echoed nor held until a return."""
    if sys.platform == "win32":
        yield
        return
    loop, keys = asyncio.get_running_loop(), sys.stdin.fileno() if sys.stdin.isatty() else None
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    for number in signals:
        loop.add_signal_handler(number, stop)
    before = termios.tcgetattr(keys) if keys is not None else None
    try:
        if keys is not None:
            tty.setcbreak(keys, termios.TCSANOW)  # keys pressed already count
            loop.add_reader(keys, _key, keys, stop)
        yield
    finally:
        for number in signals:
            loop.remove_signal_handler(number)
        if keys is not None and before is not None:
            loop.remove_reader(keys)
            with contextlib.suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(keys, termios.TCSANOW, before)


def _key(keys: int, stop: Callable[[], None]) -> None:
    try:
        pressed = os.read(keys, 64)
    except OSError:  # the terminal is gone
        pressed = b""
    if not pressed or b"q" in pressed.lower():
        stop()
