"""One run of a sweep: computed, and written into its own part of the store. Local workers and those of Dask call `run`."""

import threading
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics.arithmetic import arithmetic
from radar_service.numerics.result_cache import ResultCache
from radar_service.simulator import Simulator
from radar_service.sweep.inputs import Inputs, program
from radar_service.sweep.runs import SweepRun
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import SweepStore
from radar_service.sweep.variables import ScanReader
from radar_service.world.scene import Scene

KEPT_SCENES = 2  # runs that differ in seed alone come one after the other


@dataclass(frozen=True)
class RunTask:
    """One run of the sweep in a store. digest: of the store that is meant, should another one stand at its address."""

    address: str
    digest: str
    number: int


@dataclass(frozen=True)
class OpenStore:
    """A store and what it is made of, as a worker keeps them from run to run."""

    store: SweepStore
    inputs: Inputs


_stores: ResultCache[Hashable, OpenStore] = ResultCache(2)
_scenes: ResultCache[Hashable, Scene] = ResultCache(KEPT_SCENES)
_last = threading.local()  # the last simulator of each thread: the next one shares its trees for ray tests


def run(task: RunTask) -> None:
    """Computes a run, writes it, and marks it as finished; does nothing where it is finished.

    Raises SweepError for a store of something else and for values that are not possible, and OSError.
    """
    opened = _stores.get((task.address, task.digest), lambda: _opened(task))
    if opened.store.is_finished(task.number):
        return
    of = opened.inputs.runs[task.number]
    scene = _scenes.get((task.digest, of.scene, repr(of.values), of.radar), lambda: opened.inputs.scene(of))
    simulator = Simulator(scene, opened.inputs.spec.fidelity, of.seed, labels="labels" in opened.inputs.spec.keep)
    write_run(opened.store, opened.inputs, of, simulator)
    _last.simulator = simulator


def write_run(store: SweepStore, inputs: Inputs, run: SweepRun, simulator: Simulator) -> None:
    """Computes the scans of a run chunk by chunk, and writes them; the mark comes last. Raises SweepError and OSError."""
    reader = ScanReader(simulator, inputs.spec, store.variables, store.sizes, store.body_names())
    scans, per_chunk = store.sizes["scan"], store.scans_per_chunk
    for first in range(0, scans, per_chunk):
        rows = [reader.arrays(simulator.scan()) for _ in range(min(per_chunk, scans - first))]
        store.write(run.number, first, {name: np.stack([row[name] for row in rows]) for name in rows[0]})
    store.write(run.number, 0, reader.of_run())
    store.finish(run.number)


def _opened(task: RunTask) -> OpenStore:
    store = SweepStore(task.address)
    if store.digest != task.digest:
        raise SweepError(f"{task.address}: another store stands there now; begin again")
    for key, here in (("program", program()), ("arithmetic", arithmetic())):
        if store.made_of[key] != here:
            raise SweepError(
                f"{key}: this worker has {here}, and the store {store.made_of[key]}; bytes would differ: use equal "
                "machines and the same version"
            )
    return OpenStore(store, store.inputs())
