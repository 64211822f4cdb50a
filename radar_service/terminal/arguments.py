"""Values of the command line: numbers within limits, paces, files to write."""

import argparse
import contextlib
import difflib
import math
import os
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from radar_service.records import PowersOf

MAX_THREADS = 64  # one tile each: a scan has few more


class UsageError(Exception):
    """A command line that cannot run. Its text names the remedy."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Returns the end of a sentence with the nearest of known names; "" where none is near."""
    nearest = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean {nearest[0]}?" if nearest else ""


def pace(text: str) -> float:
    """Returns simulated seconds per second from the command line; max is inf. Raises ArgumentTypeError."""
    with contextlib.suppress(ValueError):
        factor = math.inf if text == "max" else float(text)
        if factor > 0 and (text == "max" or math.isfinite(factor)):
            return factor
    raise argparse.ArgumentTypeError(f'"{text}" is not a pace; give a number above 0 (1 is real time) or max')


def utc(text: str) -> datetime:
    """Returns a time of the command line, UTC where it names no zone. Raises ArgumentTypeError.

    NMEA has years of two digits, so those from 1980 to 2079 are allowed.
    """
    with contextlib.suppress(ValueError, OverflowError):
        time = datetime.fromisoformat(text)
        time = time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
        if not time.microsecond and 1980 <= time.year < 2080:
            return time
    raise argparse.ArgumentTypeError(
        f'"{text}" is not a time in whole seconds from 1980 to 2079; give one as 2026-12-31T23:59:00, which is UTC'
    )


def number_between(text: str, lower: float, upper: float, allowed: str) -> float:
    """Returns a number above `lower` and below `upper`. allowed: says which. Raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = lower
    if not lower < value < upper:
        raise argparse.ArgumentTypeError(f"{text:.40} is not allowed; {allowed}")
    return value


def whole_number(text: str, minimum: int, maximum: int) -> int:
    """Returns a whole number from the command line. Raises ArgumentTypeError outside the limits."""
    with contextlib.suppress(ValueError):
        if minimum <= int(text) <= maximum:
            return int(text)
    raise argparse.ArgumentTypeError(f'"{text}" is not a whole number from {minimum} to {maximum}')


def add_whole_number(
    to: "argparse._ActionsContainer", name: str, default: int | None, minimum: int, maximum: int, **more: Any
) -> None:
    """Adds an option that takes a whole number within limits. more: keywords of `add_argument`."""
    to.add_argument(name, default=default, type=partial(whole_number, minimum=minimum, maximum=maximum), **more)


def thread_count(text: str) -> int:
    """Returns a number of processes that compute; auto: all cores but one. Raises ArgumentTypeError."""
    return max(1, (os.cpu_count() or 1) - 1) if text == "auto" else whole_number(text, 1, MAX_THREADS)


def file_ending(text: str, suffix: str | tuple[str, ...]) -> Path:
    """Returns the path of a file to write, which must end in `suffix`, or one of these. Raises ArgumentTypeError."""
    suffixes = (suffix,) if isinstance(suffix, str) else suffix
    if Path(text).suffix.lower() not in suffixes:
        raise argparse.ArgumentTypeError(
            f'"{text}" does not end in {" or ".join(suffixes)}, the format that is written; give it that ending'
        )
    return Path(text)


def add_sources(command: "argparse._ActionsContainer", verb: str, remark: str) -> None:
    """Adds the options for labels and powers of sources. verb: what is done with them; remark: follows the help."""
    command.add_argument(
        "--labels", action="store_true", help=f"{verb} the number of the strongest source of each cell{remark}"
    )
    command.add_argument(
        "--powers", type=_power_numbers, default=(), metavar="NUMBERS",
        help=f"{verb} the power of these sources in each cell{remark}: all, or numbers of labels, as 1,257",
    )  # fmt: skip


def check_sources(options: argparse.Namespace, *names: str) -> None:
    """Raises UsageError for an option about sources that the fidelity has nothing for."""
    for name in names:
        if getattr(options, name) and options.fidelity == "documented":
            raise UsageError(f"--{name}: the fidelity documented has none; choose another fidelity, or leave --{name} out")


def _power_numbers(text: str) -> "PowersOf":
    """Raises argparse.ArgumentTypeError."""
    from radar_service.records import powers_from_text  # here: numpy would double the time of --help

    try:
        return powers_from_text(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
