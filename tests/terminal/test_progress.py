"""Progress of long commands where there is no terminal."""

import io
from collections.abc import Iterator

from radar_service.terminal.progress import SECONDS, progress


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
