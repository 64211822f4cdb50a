"""Shows the radar live in a terminal: `radar-ppi ws://127.0.0.1:8000 --live`. The key q, Ctrl-C or a signal ends it."""

import asyncio
import contextlib
import os
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence

from .client import FeedClient
from .errors import FeedError
from .terminal_ppi import TerminalPpi, half_blocks

if sys.platform != "win32":
    import termios
    import tty

INTERVAL = 0.1  # s between pictures
MAX_DRAWING_SHARE = 0.25  # of the time, so that the feed is read in time
BINS = 512  # per spoke: more than a terminal has pixels
MIN_TERMINAL = (24, 8)  # columns and lines; a smaller terminal shows no picture
ENTER, LEAVE = (
    "\x1b[?1049h\x1b[?25l",
    "\x1b[0m\x1b[?25h\x1b[?1049l",
)  # alternate screen without cursor; back to the normal screen
CAPTIONS = 2  # lines


async def show(client: FeedClient, ppi: TerminalPpi, notices: Sequence[str]) -> None:
    """Receives and draws until the user ends it. notices: about the connection, the newest last.

    Raises FeedError when the feed ends, and OSError without a terminal.
    """
    if not sys.stdout.isatty():
        raise OSError("--live needs a terminal, but the output is not one; remove the redirection, or use --out FILE")
    stop = asyncio.Event()
    with _alternate_screen(), _stop_keys(stop.set):
        tasks = [asyncio.create_task(work) for work in (_receive(client, ppi), _paint(client, ppi, notices), stop.wait())]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            results = await asyncio.gather(*tasks, return_exceptions=True)
            await client.close()
    for result in results:
        if isinstance(result, Exception):
            raise result


async def _receive(client: FeedClient, ppi: TerminalPpi) -> None:
    async for message in client.messages():
        try:
            ppi.take(message)
        except (LookupError, TypeError, ValueError) as fault:
            raise FeedError(f"the radar sent a {message['type']} message that cannot be used: {fault!r}") from fault


async def _paint(client: FeedClient, ppi: TerminalPpi, notices: Sequence[str]) -> None:
    size = (0, 0)
    while True:
        began = time.monotonic()
        terminal = shutil.get_terminal_size()
        clear = "" if (terminal.columns, terminal.lines) == size else "\x1b[2J"
        size = (terminal.columns, terminal.lines)
        sys.stdout.write(clear + screen(ppi, status_line(client, notices[-1]), *size))
        sys.stdout.flush()
        await asyncio.sleep(max(INTERVAL, (time.monotonic() - began) / MAX_DRAWING_SHARE))


def status_line(client: FeedClient, notice: str) -> str:
    """One line: how to leave, the counts of spokes, and the newest notice about the connection."""
    sequence = client.sequence
    return f"q ends; {sequence.received} spokes received, {sequence.lost} lost; {notice}"


def screen(ppi: TerminalPpi, below: str, columns: int, lines: int) -> str:
    """Returns the text that shows a PPI and one line below it on a terminal of this size."""
    if columns < MIN_TERMINAL[0] or lines < MIN_TERMINAL[1]:
        return f"\x1b[1;1H\x1b[0m{_plain(f'at least {MIN_TERMINAL[0]} x {MIN_TERMINAL[1]}', columns)}\x1b[J"
    size = min(columns, 2 * (lines - CAPTIONS))
    left = (columns - size) // 2 + 1
    rows = half_blocks(ppi.image(size))
    picture = "".join(f"\x1b[{k};{left}H{row}" for k, row in enumerate(rows, CAPTIONS))
    return (
        f"\x1b[1;1H\x1b[0m{_plain(ppi.caption, columns)}\x1b[K{picture}"
        f"\x1b[{CAPTIONS + len(rows)};1H{_plain(below, columns)}\x1b[K"
    )


def _plain(text: str, columns: int) -> str:
    """Text cut to the width; control characters, which could command the terminal, become question marks."""
    return "".join(c if c.isprintable() else "?" for c in text)[:columns]


@contextlib.contextmanager
def _alternate_screen() -> Iterator[None]:
    """Switches the terminal to its alternate screen, and back afterwards."""
    sys.stdout.write(ENTER)
    try:
        yield
    finally:
        sys.stdout.write(LEAVE)
        sys.stdout.flush()


@contextlib.contextmanager
def _stop_keys(stop: Callable[[], None]) -> Iterator[None]:
    """Calls `stop` at the keys q and Q and at signals that end programs. Keys are not echoed and act without Return."""
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
            tty.setcbreak(keys, termios.TCSANOW)  # keys that were pressed before count too
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
