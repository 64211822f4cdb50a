"""A terminal for a program under test: a pseudo-terminal, and what would be on its screen."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

PATIENCE = 60.0  # s, for what should take about one
TOKEN = re.compile(r"\x1b\[([?0-9;]*)([A-Za-z])|([^\x1b])", re.S)
HOME = b"\x1b[1;1H"  # where every picture of the live view begins
ON_TERMINAL = """
import fcntl, runpy, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)  # so that Ctrl-C is a signal
sys.argv.pop(0)
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""
ON_ANOTHER = ON_TERMINAL.replace("fcntl.ioctl", "# fcntl.ioctl")
Cell = tuple[str, tuple[int, ...], tuple[int, ...]]  # character, its colour, that behind it


class Terminal:
    """Runs a Python module on a terminal of so many columns and lines, which sends it signals if it is the controlling one.

    written: all bytes that it wrote.
    """

    def __init__(self, module: str, *arguments: str, columns: int = 60, lines: int = 20, controlling: bool = True) -> None:
        self._controller_end, self._program_end = pty.openpty()
        self.resize(columns, lines)
        self.before = termios.tcgetattr(self._program_end)
        self.written = b""
        start = ON_TERMINAL if controlling else ON_ANOTHER
        self.process = subprocess.Popen(
            [sys.executable, "-c", start, module, *arguments], stdin=self._program_end,
            stdout=self._program_end, stderr=self._program_end,
            cwd=Path(__file__).parents[2], start_new_session=True,
            env={key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES")},
        )  # fmt: skip

    def resize(self, columns: int, lines: int) -> None:
        """Make the window another size."""
        self.size = (columns, lines)
        fcntl.ioctl(self._program_end, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))

    def type(self, keys: bytes) -> None:
        """Press keys."""
        os.write(self._controller_end, keys)

    def until(self, seen: Callable[[], bool]) -> None:
        """Let the program write until something is seen."""
        end = time.monotonic() + PATIENCE
        while not seen():
            assert time.monotonic() < end, (self.written[-500:], self.process.poll())
            if select.select([self._controller_end], [], [], 0.05)[0]:
                self.written += os.read(self._controller_end, 65536)

    def ended(self) -> int:
        """Let the program end; its exit status."""
        self.until(lambda: self.process.poll() is not None)
        while select.select([self._controller_end], [], [], 0)[0]:
            self.written += os.read(self._controller_end, 65536)
        return self.process.returncode

    def is_as_before(self) -> bool:
        """Whether the terminal echoes and waits for returns as it did at first."""
        return termios.tcgetattr(self._program_end) == self.before

    def vanish(self) -> None:
        """Close the window under the program."""
        if self._controller_end >= 0:
            os.close(self._controller_end)
            os.close(self._program_end)
        self._controller_end = self._program_end = -1

    def close(self) -> None:
        """End what still runs."""
        self.process.kill()
        self.process.wait()
        self.vanish()

    def screen(self) -> "Screen":
        """The last whole picture on the screen."""
        screen = Screen(*self.size)
        end = self.written.rfind(HOME)  # all before is whole
        screen.write(self.written[self.written.rfind(HOME, 0, max(0, end)) : end])
        return screen


class Screen:
    """Enough of a terminal to read it: cursor addresses, 24-bit colours, erasing to the end of a line."""

    def __init__(self, columns: int, lines: int) -> None:
        self.cells: list[list[Cell]] = [[(" ", (), ())] * columns for _ in range(lines)]
        self._at, self._front, self._back = (0, 0), tuple[int, ...](), tuple[int, ...]()

    def write(self, data: bytes) -> None:
        """Take what a program writes; what lies beyond an edge is lost, as while the program has not heard of a new size."""
        for match in TOKEN.finditer(data.decode("utf-8", "ignore")):
            if match[3] is None:
                self._command(match[2], match[1])
            elif match[3].isprintable():
                line, column = self._at
                if line < len(self.cells) and column < len(self.cells[line]):
                    self.cells[line][column] = (match[3], self._front, self._back)
                self._at = (line, column + 1)

    def _command(self, letter: str, arguments: str) -> None:
        if letter == "H":
            line, column = (int(number) for number in arguments.split(";"))
            self._at = (line - 1, column - 1)
        elif letter == "K" and self._at[0] < len(self.cells):
            row = self.cells[self._at[0]]
            row[self._at[1] :] = [(" ", (), ())] * (len(row) - self._at[1])
        elif letter == "m" and arguments == "0":
            self._front = self._back = ()
        elif letter == "m":
            numbers = [int(number) for number in arguments.split(";")]
            self._front, self._back = tuple(numbers[2:5]), tuple(numbers[7:10])

    def text(self, line: int) -> str:
        """The characters of a line."""
        return "".join(cell[0] for cell in self.cells[line]).rstrip()

    def pixels(self) -> NDArray[np.uint8]:
        """The picture (2 lines, columns, 3) of half blocks, black where there are none."""
        image = np.zeros((2 * len(self.cells), len(self.cells[0]), 3), dtype=np.uint8)
        for k, row in enumerate(self.cells):
            for n, (character, front, back) in enumerate(row):
                if character == "\u2580":
                    image[2 * k, n], image[2 * k + 1, n] = front, back
        return image
