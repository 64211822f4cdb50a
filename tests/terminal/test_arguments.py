"""Values of the command line are read, or refused with what is allowed."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from radar_service.terminal.arguments import (
    MAX_THREADS,
    UsageError,
    check_sources,
    file_ending,
    pace,
    thread_count,
    utc,
    whole_number,
)


@pytest.mark.parametrize(("text", "factor"), [("max", math.inf), ("1", 1.0), ("2.5", 2.5), ("1e-3", 0.001)])
def test_a_pace_is_a_number_above_0_or_max(text: str, factor: float) -> None:
    assert pace(text) == factor


def test_whole_numbers_threads_and_files_are_read() -> None:
    assert whole_number("7", 7, 8) == 7 and thread_count(str(MAX_THREADS)) == MAX_THREADS and thread_count("auto") >= 1
    assert file_ending("a/b.NPZ", ".npz") == Path("a/b.NPZ")


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (pace, "0", "not a pace"), (pace, "nan", "not a pace"), (pace, "inf", "not a pace"),
        (lambda text: whole_number(text, 1, 5), "6", "from 1 to 5"),
        (lambda text: whole_number(text, 1, 5), "2.5", "from 1 to 5"),
        (thread_count, "0", "from 1 to 64"), (lambda text: file_ending(text, ".png"), "a.npz", "does not end in .png"),
    ],
)  # fmt: skip
def test_other_values_are_refused(read: Callable[[str], Any], text: str, words: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=words):
        read(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2026-12-31T23:59:00", "2026-12-31T23:59:00+00:00"), ("2026-12-31 23:59:00Z", "2026-12-31T23:59:00+00:00"),
        ("2027-01-01T01:00:00+02:00", "2026-12-31T23:00:00+00:00"), ("1980-01-01", "1980-01-01T00:00:00+00:00"),
    ],
)  # fmt: skip
def test_a_time_is_utc(text: str, expected: str) -> None:
    assert utc(text).isoformat() == expected


@pytest.mark.parametrize(
    "text", ["", "now", "1979-12-31", "2080-01-01", "2026-01-01T00:00:00.5", "2026-13-01", "2080-01-01T01:00+00:30"]
)
def test_other_times_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="2026-12-31T23:59:00"):
        utc(text)


def test_sources_need_a_fidelity_that_tells_them() -> None:
    check_sources(argparse.Namespace(fidelity="documented", labels=False, powers=()), "labels", "powers")
    check_sources(argparse.Namespace(fidelity="auto", labels=True, powers="all"), "labels", "powers")
    with pytest.raises(UsageError, match="--powers: the fidelity documented has none; choose another"):
        check_sources(argparse.Namespace(fidelity="documented", labels=False, powers="all"), "labels", "powers")
