"""Runs one function for many jobs: in this process, in others, or wherever an executor sends them.

An executor has `submit`, as those of `concurrent.futures` and of Dask (`Client.get_executor`). BLAS is held to
one thread in each job.
"""

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol

from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.terminal.output_files import make_folder

GIVE_UP = 3  # failures before the first success after which nothing else is tried
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


class Kept(Protocol):
    """Results of earlier commands."""

    def read(self, job: Job) -> Any:
        """Returns the result of a job; None where there is none that was made of the same."""

    def write(self, job: Job, result: Any) -> Any:
        """Keeps a result; returns it as `read` will. Raises OSError."""


class JobsFailed(Exception):
    """Jobs failed. The text says how many, and what the first one said; its error is the cause."""

    @property
    def is_fault(self) -> bool:
        """Whether the first error is Python's own, as a KeyError is: its text explains nothing, and its traceback is needed."""
        error = self.__cause__
        return type(error).__module__ == "builtins" and not isinstance(error, OSError | ImportError)


Progress = Callable[[Iterable[Outcome], int], Iterable[Outcome]]


def run(
    function: Callable[..., Any], jobs: Sequence[Job], executor: Executor | None = None, kept: Kept | None = None,
    progress: Progress = lambda outcomes, count: outcomes,
) -> list[Any]:  # fmt: skip
    """Returns function(*job.arguments) of each job, in their order.

    executor: None for this process; kept: gives the results of earlier commands, and keeps the new ones; progress: wraps the
    outcomes as they come, and gets their number. A job that fails stops no other, but for GIVE_UP failures before the first
    success. Raises JobsFailed in the end where jobs failed, and OSError where a result cannot be kept.
    """
    results = {job.name: kept.read(job) if kept else None for job in jobs}
    left = [job for job in jobs if results[job.name] is None]
    failed: list[Outcome] = []
    for outcome in progress(_outcomes(function, left, executor), len(left)):
        if outcome.error is not None:
            failed.append(outcome)
            continue
        results[outcome.job.name] = kept.write(outcome.job, outcome.result) if kept else outcome.result
    if failed:
        first, done = failed[0], sum(result is not None for result in results.values())
        many = "" if len(jobs) == 1 else f"{len(failed)} failed and {done} of {len(jobs)} are done; {first.job.name}: "
        raise JobsFailed(f"{many}{first.error}") from first.error
    return [results[job.name] for job in jobs]


@contextlib.contextmanager
def processes(count: int) -> Iterator[Executor | None]:
    """So many processes as an executor; None for one, which is this process."""
    if count == 1:
        yield None
        return
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _outcomes(function: Callable[..., Any], jobs: Sequence[Job], executor: Executor | None) -> Iterator[Outcome]:
    """What becomes of each job, as they end; it ends early after GIVE_UP failures and no success."""
    outcomes = _here(function, jobs) if executor is None or len(jobs) == 1 else _elsewhere(function, jobs, executor)
    succeeded, failures = False, 0
    for outcome in outcomes:
        yield outcome
        succeeded, failures = succeeded or outcome.error is None, failures + (outcome.error is not None)
        if not succeeded and failures == GIVE_UP:
            outcomes.close()
            return


def _here(function: Callable[..., Any], jobs: Sequence[Job]) -> Generator[Outcome, None, None]:
    for job in jobs:
        try:
            outcome = Outcome(job, limited(function, *job.arguments))
        except Exception as error:
            outcome = Outcome(job, error=error)
        yield outcome


def _elsewhere(function: Callable[..., Any], jobs: Sequence[Job], executor: Executor) -> Generator[Outcome, None, None]:
    futures = {executor.submit(limited, function, *job.arguments): job for job in jobs}
    try:
        for future in as_completed(futures):
            error = future.exception()
            if isinstance(error, Exception):
                yield Outcome(futures[future], error=error)
            else:
                yield Outcome(futures[future], future.result())
    finally:
        for future in futures:
            future.cancel()


def limited(function: Callable[..., Any], *arguments: Any) -> Any:
    """Returns function(*arguments), with BLAS held to one thread."""
    with BLAS_LIMIT.held():
        return function(*arguments)


class ResultFolder:
    """A `Kept`: JSON objects as files of a folder, so that a command that was stopped goes on where it was."""

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
        path, text = self.path(job.name), json.dumps(result, allow_nan=False)
        part = path.with_suffix(".part")
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
        return json.loads(text)
