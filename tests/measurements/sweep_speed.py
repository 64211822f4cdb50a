"""How fast sweeps are, beside as many independent `scan` processes: `python -m tests.measurements.sweep_speed [ROUNDS [RUNS]]`.

Each round has RUNS tasks of a second or more, a seed each: by `scan` processes, N at a time; by `sweep --jobs N`; and by Dask
with two workers on loopback. It prints the processor time of a task, and by how much that of `scan` is longer, by processor time
and by the wall clock.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from radar_service.processes.limits import processor_time_of
from radar_service.sweep.inputs import inputs_of
from tests.batch.loopback_cluster import loopback_cluster

SCANS = 8
SPEC = 'scene = "open-sea"\nseeds = {runs}\nscans = {scans}\n'
PROGRAM = [sys.executable, "-m", "radar_service"]
ROOT = Path(__file__).parents[2]


def by_scan(folder: Path, seeds: list[int], jobs: int) -> None:
    """One process of `scan` for each seed."""

    def one(seed: int) -> None:
        _run("scan", "open-sea", "--scans", str(SCANS), "--seed", str(seed), "-o", str(folder / f"{seed}.npz"))

    with ThreadPoolExecutor(jobs) as threads:
        list(threads.map(one, seeds))


def by_sweep(folder: Path, *options: str) -> None:
    """The same seeds in one store."""
    _run("sweep", str(folder / "sweep.toml"), "-o", str(folder / "out.zarr"), *options)


def _run(*words: str) -> None:
    subprocess.run([*PROGRAM, *words], check=True, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True)


def descendants(pid: int) -> list[int]:
    """All processes that a process has started, and theirs."""
    found: list[int] = []
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, thread.read_text().split()):
            found += [child, *descendants(child)]
    return found


def measured(action: Callable[[], None], others: list[int]) -> tuple[float, float]:
    """Processor time of children, and of other processes, and the wall clock [s]."""

    def cpu() -> float:
        return sum(os.times()[2:4]) + sum(processor_time_of(pid) or 0.0 for pid in others)

    before, begun = cpu(), time.monotonic()
    action()
    return cpu() - before, time.monotonic() - begun


def main(rounds: int, runs: int) -> None:
    times: dict[tuple[int, str], list[tuple[float, float]]] = {}
    turns = [(1, "scan"), (1, "sweep"), (2, "scan"), (2, "sweep"), (2, "dask")]
    with TemporaryDirectory() as name, loopback_cluster(2) as scheduler:
        (Path(name) / "sweep.toml").write_text(SPEC.format(runs=2, scans=1))
        by_sweep(Path(name), "--scheduler", scheduler)  # its workers import the package once, whatever follows
        cluster = descendants(os.getpid())
        for k in range(rounds * len(turns)):
            jobs, who = turns[k % len(turns)]
            folder = Path(name) / str(k)
            folder.mkdir()
            (folder / "sweep.toml").write_text(SPEC.format(runs=runs, scans=SCANS))
            seeds = [run.seed for run in inputs_of(folder / "sweep.toml").runs]
            options = ["--scheduler", scheduler] if who == "dask" else ["--jobs", str(jobs)]
            action = partial(by_scan, folder, seeds, jobs) if who == "scan" else partial(by_sweep, folder, *options)
            times.setdefault((jobs, who), []).append(measured(action, cluster if who == "dask" else []))
            print(f"{jobs} at a time, {who}: {times[jobs, who][-1]}", file=sys.stderr, flush=True)
    for (jobs, who), some in times.items():
        cpu, wall = (median(a[k] / b[k] for a, b in zip(times[jobs, "scan"], some, strict=True)) for k in (0, 1))
        each = median(time[0] for time in some) / runs
        print(
            f"{jobs} at a time, {who}: {each:.2f} s of CPU a task; scan takes {cpu:.2f} of it, {wall:.2f} by the wall clock"
        )


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*given, *(3, 8)[len(given) :])
