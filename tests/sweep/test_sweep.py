"""Whole sweeps: what they leave, what fails, and that no kill changes a byte."""

import errno
from collections.abc import Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.batch.dask_cluster import cluster
from radar_service.batch.jobs import Outcome
from radar_service.batch.worker_processes import WorkerDied
from radar_service.sweep import sweep as sweep_module
from radar_service.sweep.estimate import COPIES, HOUR, estimate
from radar_service.sweep.layout import layout_of
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import SweepStore
from tests.batch.loopback_cluster import loopback_cluster
from tests.sweep.killing import ended, files, killed, moments, started
from tests.sweep.sweeps import SPEC, content, inputs, open_dataset, swept, written

MORE = SPEC.replace("seeds = 2", "seeds = 3")  # 6 runs


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a sweep that this process made in order."""
    folder = tmp_path_factory.mktemp("undisturbed")
    _, address, tally = swept(folder, MORE)
    assert (tally.done, tally.kept, tally.failed) == (6, 0, {})
    return content(address)


def test_all_runs_are_there(undisturbed: dict[str, bytes], tmp_path: Path) -> None:
    for name, data in undisturbed.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    dataset = open_dataset(address := str(tmp_path))
    assert SweepStore(address).finished.all() and not np.isnan(dataset.power).any() and len(np.unique(dataset.video)) > 3
    strongest = dataset.power.isel(scan=0).max(dim=("azimuth", "range")).values  # noise and signal add up to some dB
    assert np.all(strongest[3:] > 4.0 * strongest[:3])  # 15 against 5 dBsm


def test_a_cluster_gives_the_bytes_of_one(undisturbed: dict[str, bytes], tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with loopback_cluster(1) as scheduler, cluster(scheduler) as workers:
        _, address, tally = swept(tmp_path, MORE, executor=workers.executor, arithmetic=workers.arithmetic)
    assert content(address) == undisturbed and (tally.done, tally.failed) == (6, {})


def go_on_until_whole(folder: Path, seed: int, count: int, whole: int, *options: str) -> int:
    """Kills a sweep at drawn moments and goes on; returns how many kills met it."""
    spec, store = written(folder, MORE), folder / "out.zarr"
    kills = 0
    for at, victims in moments(seed, count, whole):
        process = started(spec, store, *options)
        kills += killed(process, store, at, victims)
        ended(process)
    process = started(spec, store, *options)
    ended(process)
    assert process.returncode == 0
    return kills


@pytest.mark.same_bytes
def test_a_sweep_that_is_killed_has_the_bytes_of_one(undisturbed: dict[str, bytes], tmp_path: Path) -> None:
    assert go_on_until_whole(tmp_path, 9, 1, len(undisturbed), "--jobs", "1") == 1
    assert content(tmp_path / "out.zarr") == undisturbed


@pytest.mark.study
def test_a_sweep_that_is_killed_at_twenty_moments_has_the_bytes_of_one(
    undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    kills = sum(
        go_on_until_whole(tmp_path / str(seed), seed, 4, len(undisturbed), "--jobs", "2") for seed in range(100, 105)
    )
    assert kills >= 10  # the others came when all was done
    for seed in range(100, 105):
        assert content(tmp_path / str(seed) / "out.zarr") == undisturbed


@pytest.mark.study
def test_a_sweep_on_dask_that_is_killed_at_twenty_moments_has_the_bytes_of_one(
    undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    with loopback_cluster(2) as scheduler:
        kills = sum(
            go_on_until_whole(tmp_path / str(seed), seed, 4, len(undisturbed), "--scheduler", scheduler)
            for seed in range(200, 205)
        )
    assert kills >= 10
    for seed in range(200, 205):
        assert content(tmp_path / str(seed) / "out.zarr") == undisturbed


def test_a_run_that_fails_is_recorded_and_the_rest_go_on(tmp_path: Path) -> None:
    """Half of the runs have a mesh that is rubbish, which nobody knows before they begin."""
    written(tmp_path)
    (tmp_path / "rubbish.obj").write_text("v nowhere")
    spec, told = SPEC + '"body.cube.mesh" = ["cube.obj", "rubbish.obj"]\n', list[str]()

    def progress(outcomes: Iterable[Outcome], count: int) -> Iterable[Outcome]:
        for outcome in outcomes:
            yield outcome
            told.append(str(tally))

    tally = sweep_module.Tally()
    _, address, _ = swept(tmp_path, spec, tally=tally, progress=progress)
    store = SweepStore(address)
    assert (tally.done, sorted(tally.failed)) == (4, [2, 3, 6, 7]) and (told[1], told[2], told[7]) == (
        "",
        "1 failed",
        "4 failed",
    )
    assert store.failures == tally.failed and "rubbish.obj" in tally.failed[2]
    assert store.finished.tolist() == [True, True, False, False] * 2
    dataset = open_dataset(address)
    assert np.isnan(dataset.power[2]).all() and dataset.failure[2] == tally.failed[2]
    again = swept(tmp_path, spec)[2]
    assert (again.kept, again.done, sorted(again.failed)) == (4, 0, [2, 3, 6, 7])


def test_enough_failures_end_it(tmp_path: Path) -> None:
    spec = SPEC.replace("seeds = 2", "seeds = 20\nmax_crossings = 1")
    _, address, tally = swept(tmp_path, spec, max_failures=3)
    assert len(tally.failed) == 3 and len(SweepStore(address).failures) == 3


class Failing:
    """An executor whose jobs end with an error."""

    def __init__(self, error: BaseException | None) -> None:
        self.error = error

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        if self.error is None:
            future.cancel()
        else:
            future.set_exception(self.error)
        return future


def test_workers_that_die_again_and_again_fail_their_run_alone(tmp_path: Path) -> None:
    _, address, tally = swept(tmp_path, executor=Failing(WorkerDied("its worker process died 3 times")))
    assert SweepStore(address).failures == dict.fromkeys(range(4), "its worker process died 3 times") == tally.failed


def test_a_full_disk_ends_it_with_the_remedy(tmp_path: Path) -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(OSError, match="make room, and the same command goes on") as raised:
        swept(tmp_path, executor=Failing(full))
    assert str(raised.value.filename).endswith("out.zarr") and not SweepStore(str(tmp_path / "out.zarr")).failures


def test_a_scheduler_that_ends_ends_it(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="^run 0: its executor dropped it: .*; the same command goes on where it was$"):
        swept(tmp_path, executor=Failing(None))


def test_a_store_that_another_command_has_is_left_alone(tmp_path: Path) -> None:
    def progress(outcomes: Iterable[Outcome], count: int) -> Iterable[Outcome]:
        with pytest.raises(SweepError, match="another command writes to it"):
            swept(tmp_path)
        yield from outcomes

    assert swept(tmp_path, progress=progress)[2].done == 4


def test_files_are_counted(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").touch()
    assert files(tmp_path) == 1 and files(tmp_path / "none") == 0


# estimate: what a sweep will take, before it begins.


def test_it_adds_up_what_it_measures(tmp_path: Path) -> None:
    of = inputs(tmp_path, SPEC.replace("seeds = 2", "seeds = 50"))
    layout = layout_of(of)
    taken = estimate(of, layout)
    (cost,) = taken.scenes
    assert cost.runs == 100 and cost.scan == pytest.approx(1.0 / cost.realtime_factor)  # a scan is of a second
    assert taken.cpu_hours == pytest.approx(100 * (cost.set_up + 3 * (cost.scan + cost.write)) / HOUR)
    assert taken.memory > COPIES * layout.chunk_bytes and min(cost.set_up, cost.scan, cost.write) > 0.0
    lines = str(taken).splitlines()
    assert lines[0] == "100 runs of 3 scans of 60 x 40" and "CPU hours on this machine" in lines[1]
    assert lines[-2].startswith(f"{layout.bytes / 1e6:.3g} MB of arrays") and "memory a worker" in lines[-1]
    assert f"; 2 chunks a run of {len(layout.arrays)} arrays" in lines[-2]  # of two scans each


def test_bytes_are_those_that_a_sweep_leaves(tmp_path: Path) -> None:
    """One scan stands for all: noise compresses alike. The marks and coordinates of four runs are left out, 2 kB."""
    of, address, _ = swept(tmp_path, SPEC)
    store = SweepStore(address)
    files = [path for each in store.variables for path in (tmp_path / "out.zarr" / each.name / "c").rglob("*")]
    there = sum(path.stat().st_size for path in files if path.is_file())
    assert estimate(of, layout_of(of)).stored == pytest.approx(there, rel=0.15)


def test_the_specification_as_printed_has_a_time_too(tmp_path: Path) -> None:
    of = inputs(tmp_path, 'scene = "small.toml"\nfidelity = "documented"')
    assert estimate(of, layout_of(of)).scenes[0].realtime_factor > 0.0
