"""The short modules of terminal, each under its name."""

import argparse
import io
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from jinja2 import UndefinedError

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
from radar_service.terminal.html_pages import html_page
from radar_service.terminal.progress_bar import SECONDS, progress

# html_pages: templates escape what fills them, and say what they were not given.
STUDY = {"scenario": "s & <s>", "source": "", "series": [{"environment": '"', "targets": []}]}


def test_what_fills_a_page_is_escaped() -> None:
    values = {"criterion": lambda study: "<b>", "figure": lambda series: ""}
    page = html_page("bench/detection/report.html", study=STUDY, **values)
    assert page.count("s &amp; &lt;s&gt;") == 2 and "<h2>&#34;</h2>" in page and "<p>&lt;b&gt;" in page
    assert "pip install &#39;.[pictures]&#39;" in page


def test_a_value_that_a_template_lacks_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="criterion"):
        html_page("bench/detection/report.html", study=STUDY)


# progress_bar: progress of long commands where there is no terminal.
class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def written(step: float, count: int) -> list[str]:
    """The lines of items that take `step` seconds each."""
    now: Iterator[float] = iter(step * k for k in range(count + 1))
    stream = io.StringIO()
    assert list(progress(range(count), count, "runs", "seed {}".format, stream, lambda: next(now))) == list(range(count))
    return stream.getvalue().splitlines()


def test_slow_items_have_a_line_each_with_rate_and_time_left() -> None:
    assert written(2 * SECONDS, 3) == [
        "seed 0: 1 of 3 runs, 0.1 runs a second, 20 s left",
        "seed 1: 2 of 3 runs, 0.1 runs a second, 10 s left",
        "seed 2: 3 of 3 runs, 0.1 runs a second, 0 s left",
    ]


def test_quick_items_have_few_lines() -> None:
    lines = written(SECONDS / 10, 101)
    assert len(lines) == 11 and lines[0].startswith("seed 0: 1 of 101") and lines[-1].startswith("seed 100: 101 of 101")


def test_items_in_no_time_have_no_rate() -> None:
    assert written(0.0, 1) == ["seed 0: 1 of 1 runs"]


def test_parts_of_one_of_many_jobs_have_a_line_after_a_while_and_no_bar() -> None:
    for to, expected in ((io.StringIO(), "3 of 7"), (Terminal(), "3 of 7")):
        now = iter(2.0 * k for k in range(8))
        assert list(progress(range(7), 7, "scans", "part {}".format, to, lambda now=now: next(now), within=True)) == [
            *range(7)
        ]
        lines = to.getvalue().splitlines()
        assert [line.partition(": ")[2][: len(expected)] for line in lines] == [expected, "6 of 7"]
    quick = io.StringIO()
    assert list(progress(range(3), 3, "scans", str, quick, lambda: 0.0, within=True)) == [0, 1, 2] and not quick.getvalue()


def test_nothing_has_no_line() -> None:
    assert written(1.0, 0) == []


def test_a_terminal_has_a_bar() -> None:
    terminal = Terminal()
    assert list(progress([1, 2], 2, "runs", str, terminal)) == [1, 2]
    assert "2/2" in terminal.getvalue() and "of 2 runs" not in terminal.getvalue()


def test_a_remark_stands_at_the_end_of_both() -> None:
    stream, terminal, done = io.StringIO(), Terminal(), list[int]()
    for to in (stream, terminal):
        done.clear()
        for item in progress(range(3), 3, "runs", str, to, lambda: 0.0, lambda: f"{len(done)} failed" if done else ""):
            done.append(item)
    assert stream.getvalue().splitlines() == ["0: 1 of 3 runs, 1 failed", "2: 3 of 3 runs, 3 failed"]
    assert "3 failed" in terminal.getvalue()


# arguments: values of the command line are read, or refused with what is allowed.
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
