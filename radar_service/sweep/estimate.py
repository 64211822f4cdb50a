"""What a sweep will take: processor time by the plan of each scene, bytes, and memory of a worker."""

import time
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from radar_service.numerics import arithmetic
from radar_service.processes.limits import peak_memory
from radar_service.scans import Scan
from radar_service.simulator import Simulator
from radar_service.sweep.inputs import Inputs
from radar_service.sweep.layout import StoreLayout
from radar_service.sweep.store import lay_out
from radar_service.sweep.variables import ScanReader

HOUR = 3600.0  # s
UNITS = ("bytes", "kB", "MB", "GB", "TB", "PB")
COPIES = 2  # of a chunk that a worker holds: its scans, and the arrays that they become


@dataclass(frozen=True)
class SceneCost:
    """What the runs of a scene take.

    runs: their number.
    set_up: processor time of preparing one [s].
    scan: that of a scan, by the plan [s].
    realtime_factor: of the plan, measured on this machine.
    write: processor time of turning a scan into arrays, compressing and writing it [s].
    stored: bytes of a scan, compressed.
    """

    scene: str
    runs: int
    set_up: float
    scan: float
    realtime_factor: float
    write: float
    stored: int


@dataclass(frozen=True)
class Estimate:
    """What a sweep takes. memory: of a worker [bytes]."""

    layout: StoreLayout
    scenes: tuple[SceneCost, ...]
    memory: int

    @property
    def cpu_hours(self) -> float:
        """Processor time on this machine."""
        scans = self.layout.sizes["scan"]
        return sum(row.runs * (row.set_up + scans * (row.scan + row.write)) for row in self.scenes) / HOUR

    @property
    def stored(self) -> int:
        """Bytes of the store, compressed as one scan of each scene is."""
        return sum(row.runs * self.layout.sizes["scan"] * row.stored for row in self.scenes)

    def __str__(self) -> str:
        sizes, layout = self.layout.sizes, self.layout
        chunks = -(-sizes["scan"] // layout.scans_per_chunk)
        lines = [
            f"{sizes['run']} runs of {sizes['scan']} scans of {sizes['azimuth']} x {sizes['range']}",
            f"{self.cpu_hours:.3g} CPU hours on this machine",
        ]
        lines += [
            f"  {row.scene}: {row.runs} runs, {row.set_up:.3g} s to prepare, {row.scan:.3g} s a scan "
            f"({row.realtime_factor:.3g} x real time), {row.write:.2g} s to write it"
            for row in self.scenes
        ]
        return "\n".join(
            [
                *lines,
                f"{_size(layout.bytes)} of arrays, some {_size(self.stored)} compressed; {chunks} chunks a "
                f"run of {len(layout.arrays)} arrays",
                f"{_size(self.memory)} of memory a worker, {_size(COPIES * layout.chunk_bytes)} of it for chunks",
            ]
        )


def estimate(inputs: Inputs, layout: StoreLayout) -> Estimate:
    """Returns what a sweep takes, measured on the first run of each scene. Raises SweepError."""
    counts = Counter(np.unravel_index(np.arange(len(inputs.runs)), inputs.runs.shape)[0].tolist())
    costs = tuple(_scene_cost(inputs, layout, scene, count) for scene, count in sorted(counts.items()))
    return Estimate(layout, costs, peak_memory() + COPIES * layout.chunk_bytes)


def _scene_cost(inputs: Inputs, layout: StoreLayout, scene: int, runs: int) -> SceneCost:
    run = next(run for run in inputs.runs.corners() if run.scene == scene)
    loaded = inputs.scene(run)
    begun = time.process_time()
    simulator = Simulator(loaded, inputs.spec.fidelity, run.seed, labels="labels" in inputs.spec.keep)
    set_up = time.process_time() - begun
    scan = simulator.scan()
    write, stored = _written(inputs, layout, simulator, scan)
    factor = simulator.plan.realtime_factor
    if factor is None:  # the specification as printed has no plan: its second scan is timed
        begun = time.process_time()
        simulator.scan()
        factor = loaded.radar.rotation_period / (time.process_time() - begun)
    return SceneCost(inputs.spec.scene[scene], runs, set_up, loaded.radar.rotation_period / factor, factor, write, stored)


def _written(inputs: Inputs, layout: StoreLayout, simulator: Simulator, scan: Scan) -> tuple[float, int]:
    """Processor time [s] and bytes of a scan in a store."""
    single = replace(layout, sizes={**layout.sizes, "run": 1, "scan": 1}, scans_per_chunk=1, coordinates={})
    with TemporaryDirectory(prefix="radar-sweep-") as folder:
        store = lay_out(folder, inputs, single, arithmetic())
        names = [body.name for body in simulator.scene.bodies]
        before, begun = _bytes_in(folder), time.process_time()
        values = ScanReader(simulator, inputs.spec, layout.arrays, layout.sizes, names).arrays(scan)
        store.write(0, 0, {name: array[None] for name, array in values.items()})
        return time.process_time() - begun, _bytes_in(folder) - before


def _bytes_in(folder: str) -> int:
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


def _size(count: float) -> str:
    """Bytes in words."""
    power = 0
    while count >= 1000.0 and power < len(UNITS) - 1:
        count, power = count / 1000.0, power + 1
    return f"{count:.3g} {UNITS[power]}"
