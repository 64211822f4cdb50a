"""Runs one function for many jobs: in this process, in others (`worker_processes`), or on a cluster (`dask_cluster`).

An executor has `submit`, as those of `concurrent.futures`. BLAS is held to one thread in each job.
"""

import hashlib
import json
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Protocol

from radar_service.numerics import BLAS_LIMIT
from radar_service.terminal import UsageError, make_folder, write_file

GIVE_UP = 3  # failures before the first success after which nothing else is tried
IN_FLIGHT = 1000  # jobs that an executor has at a time: a sweep may have a million
MAX_NAME = 100  # characters of a file's name: a job may be named after a command that is longer than file systems take


class Executor(Protocol):
    """Where jobs are done."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> "Future[Any]":
        """Begins function(*arguments) elsewhere."""


@dataclass(frozen=True)
class Job:
    """One call of the function.

    name: for people, and of the file that keeps the result; unique.
    made_of: what the result depends on, as plain data that the result repeats; a kept result is used where all of it is equal.
    """

    name: str
    arguments: tuple[Any, ...]
    made_of: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What became of a job: its result, or the error that it raised."""

    job: Job
    result: Any = None
    error: Exception | None = None


class JobsFailed(Exception):
    """Jobs failed. The text says how many, and what the first one said; its error is the cause."""


class JobsRefused(JobsFailed, UsageError):
    """Jobs failed, and the first error is none of Python's own, as a KeyError is, whose traceback alone explains it."""


class JobLost(Exception):
    """An executor has dropped a job. The text says why."""


Progress = Callable[[Iterable[Outcome], int], Iterable[Outcome]]


def run(
    function: Callable[..., Any], jobs: Sequence[Job], executor: Executor | None = None, kept: "ResultFolder | None" = None,
    progress: Progress = lambda outcomes, count: outcomes,
) -> list[Any]:  # fmt: skip
    """Returns function(*job.arguments) of each job, in their order.

    executor: None for this process; kept: results of earlier commands; progress: wraps the outcomes as they come, and gets their
    number. A job that fails stops no other, but for GIVE_UP failures before the first success. Raises JobsFailed at the end, and
    OSError where a result cannot be kept.
    """
    results = {job.name: kept.read(job) if kept else None for job in jobs}
    left = [job for job in jobs if results[job.name] is None]
    failed: list[Outcome] = []
    for outcome in progress(outcomes(function, left, executor), len(left)):
        if outcome.error is not None:
            failed.append(outcome)
            continue
        results[outcome.job.name] = kept.write(outcome.job, outcome.result) if kept else outcome.result
    if failed:
        first, done = failed[0], sum(result is not None for result in results.values())
        many = "" if len(jobs) == 1 else f"{len(failed)} failed and {done} of {len(jobs)} are done; {first.job.name}: "
        is_fault = type(first.error).__module__ == "builtins" and not isinstance(first.error, OSError | ImportError)
        raise (JobsFailed if is_fault else JobsRefused)(f"{many}{first.error}") from first.error
    return [results[job.name] for job in jobs]


def outcomes(
    function: Callable[..., Any], jobs: Iterable[Job], executor: Executor | None = None, give_up: int | None = GIVE_UP
) -> Generator[Outcome, None, None]:
    """Yields what becomes of each job, as they end.

    give_up: failures without a success after which it ends early; None for never. A generator that is closed cancels the rest.
    """
    some = _here(function, jobs) if executor is None else _elsewhere(function, iter(jobs), executor)
    succeeded, failures = False, 0
    try:
        for outcome in some:
            yield outcome
            succeeded, failures = succeeded or outcome.error is None, failures + (outcome.error is not None)
            if not succeeded and failures == give_up:
                return
    finally:
        some.close()


def _here(function: Callable[..., Any], jobs: Iterable[Job]) -> Generator[Outcome, None, None]:
    for job in jobs:
        try:
            outcome = Outcome(job, limited(function, *job.arguments))
        except Exception as error:
            outcome = Outcome(job, error=error)
        yield outcome


def _elsewhere(function: Callable[..., Any], jobs: Iterator[Job], executor: Executor) -> Generator[Outcome, None, None]:
    """Jobs of an executor, which has up to IN_FLIGHT at a time."""
    ended: SimpleQueue[Future[Any]] = SimpleQueue()
    futures: dict[Future[Any], Job] = {}

    def submit(job: Job) -> None:
        future = executor.submit(limited, function, *job.arguments)
        futures[future] = job
        future.add_done_callback(ended.put)

    try:
        for job in islice(jobs, IN_FLIGHT):
            submit(job)
        while futures:
            future = ended.get()
            yield _outcome(futures.pop(future), future)
            for job in islice(jobs, 1):
                submit(job)
    finally:
        for future in [*futures]:
            future.cancel()


def _outcome(job: Job, future: "Future[Any]") -> Outcome:
    """What became of a job whose future has ended."""
    try:
        error = future.exception()
    except CancelledError:
        error = JobLost("its executor dropped it: a scheduler that ends, or loses its client, does so")
    if error is None:
        return Outcome(job, future.result())
    return Outcome(job, error=error if isinstance(error, Exception) else JobLost(f"{type(error).__name__}: {error}"))


def limited(function: Callable[..., Any], *arguments: Any) -> Any:
    """Returns function(*arguments), with BLAS held to one thread."""
    with BLAS_LIMIT.held():
        return function(*arguments)


class ResultFolder:
    """Results as JSON objects in files of a folder, so that a command that was stopped goes on where it was."""

    def __init__(self, folder: Path) -> None:
        """folder: is made where it is absent. Raises OSError."""
        make_folder(folder)
        self.folder = folder

    def path(self, name: str) -> Path:
        """The file of a job."""
        plain = "".join(c if c.isascii() and c.isalnum() or c in "-_" else "-" for c in name)[:MAX_NAME]
        return self.folder / f"{plain}-{hashlib.blake2b(name.encode(), digest_size=4).hexdigest()}.json"

    def read(self, job: Job) -> dict[str, Any] | None:
        """Returns the result of a job, where its file is whole and was made of the same; None otherwise."""
        try:
            result: dict[str, Any] = json.loads(self.path(job.name).read_text(encoding="utf-8"))
            return result if {name: result[name] for name in job.made_of} == dict(job.made_of) else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def write(self, job: Job, result: Any) -> Any:
        """Writes the file as a whole or not at all; returns the result as JSON has it. Raises OSError."""
        text = json.dumps(result, allow_nan=False)
        write_file(self.path(job.name), text)
        return json.loads(text)
