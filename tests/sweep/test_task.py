"""One run of a sweep: the values of `scan`, written once, by whoever may."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.arithmetic import arithmetic
from radar_service.sweep import sweep as task_module
from radar_service.sweep.layout import layout_of
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import SweepStore, lay_out
from radar_service.sweep.sweep import RunTask, run
from tests.sweep.sweeps import SPEC, content, inputs, open_dataset


def laid_out(folder: Path, spec: str = SPEC) -> SweepStore:
    of = inputs(folder, spec)
    return lay_out(str(folder / "out.zarr"), of, layout_of(of), arithmetic())


@pytest.mark.same_bytes
def test_a_run_has_the_values_of_a_simulator(tmp_path: Path) -> None:
    store = laid_out(tmp_path, SPEC.replace("bins = 40", ""))
    of = store.inputs()
    run(RunTask(store.address, store.digest, 2))
    dataset = open_dataset(store.address)
    sim = rs.Simulator(of.scene(of.runs[2]), seed=int(dataset.seed[2]))
    for number in range(3):
        scan = sim.scan()
        np.testing.assert_array_equal(dataset.power[2, number], scan.power)
        np.testing.assert_array_equal(dataset.time[2, number], scan.time)
        assert dataset.truth_range[2, number, 0] == sim.crossings(number)[0].range
    np.testing.assert_allclose(dataset.range, scan.range, rtol=1e-12)  # rounding of one product
    assert store.finished.tolist() == [False, False, True, False] and np.isnan(dataset.power[1]).all()


def test_a_finished_run_is_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = laid_out(tmp_path)
    run(RunTask(store.address, store.digest, 0))
    monkeypatch.setattr(task_module, "Simulator", None)
    run(RunTask(store.address, store.digest, 0))


def test_a_run_that_is_made_again_has_the_same_bytes(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    run(RunTask(store.address, store.digest, 1))
    before = content(store.address)
    (tmp_path / "out.zarr" / "digest" / "c" / "1").unlink()
    (tmp_path / "out.zarr" / "power" / "c" / "1" / "0" / "0" / "0").write_bytes(b"half")
    run(RunTask(store.address, store.digest, 1))
    assert content(store.address) == before


def test_runs_that_differ_in_seed_alone_share_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, loaded = laid_out(tmp_path, SPEC.replace("seeds", "seed = 9\nseeds")), list[int]()  # none that others have kept
    scene = task_module.Inputs.scene

    def counted(of: Any, one: Any) -> Any:
        loaded.append(one.number)
        return scene(of, one)

    monkeypatch.setattr(task_module.Inputs, "scene", counted)
    for number in (0, 1, 2, 3, 0):
        run(RunTask(store.address, store.digest, number))
    assert loaded == [0, 2]


def test_ranges_that_differ_are_written_run_by_run(tmp_path: Path) -> None:
    store = laid_out(tmp_path, SPEC + '"radar.range_max_m" = [600, 1200]')
    for number in (0, 2):
        run(RunTask(store.address, store.digest, number))
    dataset = open_dataset(store.address)
    step = dataset.range_step.values
    assert step[2] == pytest.approx(2.0 * step[0], rel=0.01) and np.isnan(step[1]) and "range_first" in dataset.coords


def test_a_store_of_something_else_is_refused(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    with pytest.raises(SweepError, match="another store stands there now; begin again"):
        run(RunTask(store.address, "0" * 32, 0))


@pytest.mark.parametrize("what", ["program", "arithmetic"])
def test_a_worker_that_would_make_other_bytes_refuses(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = laid_out(tmp_path)
    monkeypatch.setattr(task_module, what, lambda: "another")
    with pytest.raises(
        SweepError, match=f"^{what}: this worker has another, and the store .*; bytes would differ: use equal"
    ):
        run(RunTask(store.address, store.digest, 0))
    assert not store.finished.any()
