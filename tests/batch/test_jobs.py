"""Many jobs: their order, their failures, and where they are done."""

import contextlib
import os
import threading
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import radar_service.batch.jobs as jobs_module
from radar_service.batch.jobs import GIVE_UP, Job, JobLost, JobsFailed, JobsRefused, Outcome, ResultFolder, outcomes, run
from radar_service.batch.worker_processes import processes
from radar_service.numerics.parallel import BLAS_LIMIT


def jobs(*numbers: int) -> list[Job]:
    return [Job(f"job {number}", (number,)) for number in numbers]


def squared(number: int) -> dict[str, int]:
    if number < 0:
        raise ValueError(f"{number} is negative")
    return {"square": number**2}


def test_results_come_in_the_order_of_the_jobs_wherever_they_are_done() -> None:
    numbers = list(range(8))
    expected = [{"square": number**2} for number in numbers]
    assert run(squared, jobs(*numbers)) == expected
    with ThreadPoolExecutor(3) as threads:  # any executor with `submit`
        assert run(squared, jobs(*numbers), threads) == expected
    with processes(2) as executor:
        assert executor is not None and run(squared, jobs(*numbers), executor) == expected


def test_one_process_is_this_one() -> None:
    with processes(1) as executor:
        assert executor is None and run(lambda: os.getpid(), [Job("here", ())], executor) == [os.getpid()]


def test_blas_is_held_to_one_thread_in_each_job() -> None:
    assert not BLAS_LIMIT.is_held and run(lambda: BLAS_LIMIT.is_held, [Job("held", ())]) == [True]


def test_a_job_that_fails_stops_no_other_and_is_named(tmp_path: Path) -> None:
    folder, seen = ResultFolder(tmp_path), list[str]()

    def progress(outcomes: Iterable[Outcome], count: int) -> Iterable[Outcome]:
        for outcome in outcomes:
            seen.append(f"{outcome.job.name} of {count}")
            yield outcome

    with pytest.raises(JobsFailed, match=r"^2 failed and 2 of 4 are done; job -1: -1 is negative$") as failed:
        run(squared, jobs(3, -1, -2, 4), kept=folder, progress=progress)
    assert isinstance(failed.value.__cause__, ValueError) and seen == [f"job {k} of 4" for k in (3, -1, -2, 4)]
    assert [folder.read(job) for job in jobs(3, -1, 4)] == [{"square": 9}, None, {"square": 16}]


def test_the_only_job_fails_with_its_own_words() -> None:
    with pytest.raises(JobsFailed, match="^-5 is negative$"):
        run(squared, jobs(-5))


class Refused(Exception):
    """An error with a sentence of its own."""


@pytest.mark.parametrize(
    ("error", "is_fault"), [(KeyError("x"), True), (ValueError("y"), True), (Refused("z"), False), (OSError("disk"), False)]
)
def test_an_error_of_python_itself_is_a_fault_whose_traceback_is_needed(error: Exception, is_fault: bool) -> None:
    def failing() -> None:
        raise error

    with pytest.raises(JobsFailed) as failed:
        run(failing, [Job("one", ())])
    assert isinstance(failed.value, JobsRefused) is not is_fault and failed.value.__cause__ is error


@pytest.mark.parametrize("elsewhere", [False, True])
def test_where_nothing_works_the_rest_is_not_tried(elsewhere: bool) -> None:
    tried, go = list[int](), threading.Event()

    def failing(number: int) -> None:
        tried.append(number)
        if number == GIVE_UP:  # begun elsewhere before anybody knows of the others
            go.wait(60)
        raise OSError("no such program")

    with ThreadPoolExecutor(1) as threads:
        with pytest.raises(JobsFailed, match=rf"^{GIVE_UP} failed and 0 of 50 are done; job \d: no such program$"):
            run(failing, jobs(*range(50)), threads if elsewhere else None)
        go.set()
    assert tried in (list(range(GIVE_UP)), list(range(GIVE_UP + 1)))


def test_those_who_give_up_never_try_everything() -> None:
    assert sum(outcome.error is not None for outcome in outcomes(squared, jobs(*range(-50, 0)), give_up=None)) == 50


class Dropping:
    """An executor that cancels what it is given."""

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        future.cancel()
        return future


def test_a_job_that_an_executor_drops_is_told_from_one_that_fails() -> None:
    (outcome,) = outcomes(squared, jobs(1), Dropping())
    assert isinstance(outcome.error, JobLost) and "dropped" in str(outcome.error)


def test_an_executor_has_a_bounded_number_of_jobs_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep may have a million."""
    monkeypatch.setattr(jobs_module, "IN_FLIGHT", 3)
    given = list[int]()

    class Counting(ThreadPoolExecutor):
        def submit(self, function: Any, /, *arguments: Any, **more: Any) -> "Future[Any]":
            given.append(arguments[1])
            return super().submit(function, *arguments, **more)

    with Counting(1) as threads, contextlib.closing(outcomes(squared, iter(jobs(*range(9))), threads)) as some:
        assert [next(some).result["square"], given] == [0, [0, 1, 2]]
        assert len({next(some).result["square"] for _ in range(4)}) == 4 and given == [0, 1, 2, 3, 4, 5, 6]


def test_kept_results_are_not_made_again(tmp_path: Path) -> None:
    folder, made = ResultFolder(tmp_path), list[int]()

    def counted(number: int) -> dict[str, Any]:
        made.append(number)
        return {"number": number, "version": 1}

    with_version = [Job(f"job {number}", (number,), {"version": 1}) for number in (1, 2)]
    assert run(counted, with_version[:1], kept=folder) == [{"number": 1, "version": 1}]
    assert run(counted, with_version, kept=folder) == [{"number": k, "version": 1} for k in (1, 2)] and made == [1, 2]


RESULT = {"seed": 3, "program": "a", "value": 0.1}


def test_a_result_is_used_where_it_was_made_of_the_same(tmp_path: Path) -> None:
    folder = ResultFolder(tmp_path / "runs")
    folder.write(Job("one", ()), RESULT)
    for made_of, used in (({}, True), ({"seed": 3, "program": "a"}, True), ({"seed": 4}, False), ({"other": 1}, False)):
        assert (folder.read(Job("one", (), made_of)) == RESULT) is used
    assert folder.read(Job("two", ())) is None


@pytest.mark.parametrize("content", ["", '{"seed": 3', "[]", "7", "null"])
def test_a_file_that_is_cut_or_something_else_is_made_anew(content: str, tmp_path: Path) -> None:
    folder, job = ResultFolder(tmp_path), Job("one", (), {"seed": 3})
    folder.path("one").write_text(content)
    assert folder.read(job) is None
    folder.write(job, RESULT)
    assert folder.read(job) == RESULT and [file.suffix for file in tmp_path.iterdir()] == [".json"]


def test_names_of_any_length_and_letters_have_files_of_their_own(tmp_path: Path) -> None:
    """File systems take 255 bytes."""
    folder = ResultFolder(tmp_path)
    names = ["x" * 300, "x" * 301, "a/b", "a:b", "日本 語" * 40]
    for k, name in enumerate(names):
        folder.write(Job(name, ()), {"k": k})
    assert [folder.read(Job(name, ())) for name in names] == [{"k": k} for k in range(len(names))]
