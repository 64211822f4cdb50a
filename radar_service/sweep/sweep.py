"""Runs a sweep: lays the store out, or finds what is finished in it, and has all other runs computed."""

import contextlib
from dataclasses import dataclass, field

import numpy as np

from radar_service.batch.jobs import Executor, Job, JobLost, Outcome, Progress, outcomes
from radar_service.batch.worker_processes import WorkerDied
from radar_service.sweep.inputs import Inputs
from radar_service.sweep.layout import StoreLayout
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import SweepStore, held, lay_out
from radar_service.sweep.task import RunTask, run
from radar_service.terminal.output_files import NO_ROOM, named_errors

MAX_REASON = 500  # characters of why a run failed


@dataclass
class Tally:
    """What became of the runs of a sweep. kept: finished before; done: by this command; failed: reasons by number."""

    kept: int = 0
    done: int = 0
    failed: dict[int, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{len(self.failed)} failed" if self.failed else ""


def run_sweep(
    inputs: Inputs, layout: StoreLayout, address: str, arithmetic: str, executor: Executor | None = None,
    max_failures: int | None = None, progress: Progress = lambda outcomes, count: outcomes, tally: Tally | None = None,
) -> Tally:  # fmt: skip
    """Computes all runs that the store does not have, and returns what became of them.

    address: of the store. arithmetic: of those who compute. executor, progress: as `batch.jobs.run`. max_failures: failed runs
    after which it ends; None: all runs are tried. tally: is filled, for those who watch. Failed runs are tried again by the next
    command. Raises SweepError, and OSError where the store takes nothing more.
    """
    tally = Tally() if tally is None else tally
    with held(address), named_errors(address):
        store = lay_out(address, inputs, layout, arithmetic)
        store.clear()
        left = np.flatnonzero(~store.finished).tolist()
        tally.kept = len(inputs.runs) - len(left)
        jobs = (Job(f"run {number}", (RunTask(address, store.digest, number),)) for number in left)
        with contextlib.closing(outcomes(run, jobs, executor, give_up=None)) as some:
            for outcome in progress(some, len(left)):
                _note(store, outcome, tally)
                if max_failures is not None and len(tally.failed) >= max_failures:
                    some.close()
    return tally


def _note(store: SweepStore, outcome: Outcome, tally: Tally) -> None:
    """Counts a run; of one that failed the store gets the reason. Raises SweepError and OSError where no run can go on."""
    error, number = outcome.error, outcome.job.arguments[0].number
    if error is None:
        tally.done += 1
        return
    if isinstance(error, JobLost):
        raise SweepError(f"{outcome.job.name}: {error}; the same command goes on where it was")
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        raise OSError(error.errno, f"{error.strerror}; make room, and the same command goes on", store.address)
    reason = str(error) if isinstance(error, SweepError | WorkerDied) else f"{type(error).__name__}: {error}"
    tally.failed[number] = reason[:MAX_REASON]
    store.fail(number, tally.failed[number])
