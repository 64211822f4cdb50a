"""Runs a sweep: lays the store out, or finds what is finished in it, and computes other runs into their own parts of it."""

import contextlib
import threading
from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np

from radar_service.batch.jobs import Executor, Job, JobLost, Outcome, Progress, outcomes
from radar_service.batch.worker_processes import WorkerDied
from radar_service.numerics import ResultCache, arithmetic
from radar_service.simulator import Simulator
from radar_service.sweep.inputs import Inputs, program
from radar_service.sweep.layout import StoreLayout
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import SweepStore, held, lay_out
from radar_service.sweep.variables import ScanReader
from radar_service.terminal import NO_ROOM, named_errors
from radar_service.world import Scene

KEPT_SCENES = 2  # runs that differ in seed alone come one after the other
MAX_REASON = 500  # characters of why a run failed


_stores: ResultCache[Hashable, SweepStore] = ResultCache(2)
_scenes: ResultCache[Hashable, Scene] = ResultCache(KEPT_SCENES)
_last = threading.local()  # the last simulator of each thread: the next one shares its trees for ray tests


def run(address: str, digest: str, number: int) -> None:
    """Computes a run of a store, writes it, and marks it as finished; does nothing where it is finished.

    digest: of the store that is meant. Raises SweepError for another one and for values that are not possible, and OSError.
    """
    store = _stores.get((address, digest), lambda: _opened(address, digest))
    if store.is_finished(number):
        return
    of, spec = store.inputs.runs[number], store.inputs.spec
    scene = _scenes.get((digest, of.scene, repr(of.values), of.radar), lambda: store.inputs.scene(of))
    simulator = Simulator(scene, spec.fidelity, of.seed, labels="labels" in spec.keep)
    reader = ScanReader(simulator, spec, store.variables, store.sizes, store.body_names())
    scans, per_chunk = store.sizes["scan"], store.scans_per_chunk
    for first in range(0, scans, per_chunk):
        rows = [reader.arrays(simulator.scan()) for _ in range(min(per_chunk, scans - first))]
        store.write(number, first, {name: np.stack([row[name] for row in rows]) for name in rows[0]})
    store.write(number, 0, reader.of_run())
    store.finish(number)
    _last.simulator = simulator


def _opened(address: str, digest: str) -> SweepStore:
    store = SweepStore(address)
    if store.digest != digest:
        raise SweepError(f"{address}: another store stands there now; begin again")
    for key, here in (("program", program()), ("arithmetic", arithmetic())):
        if store.made_of[key] != here:
            raise SweepError(
                f"{key}: this worker has {here}, and the store {store.made_of[key]}; bytes would differ: use equal "
                "machines and the same version"
            )
    return store


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
        jobs = (Job(f"run {number}", (address, store.digest, number)) for number in left)
        with contextlib.closing(outcomes(run, jobs, executor, give_up=None)) as some:
            for outcome in progress(some, len(left)):
                _note(store, outcome, tally)
                if max_failures is not None and len(tally.failed) >= max_failures:
                    some.close()
    return tally


def _note(store: SweepStore, outcome: Outcome, tally: Tally) -> None:
    """Counts a run; of one that failed the store gets the reason. Raises SweepError and OSError where no run can go on."""
    error, number = outcome.error, outcome.job.arguments[2]
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
