"""The store of a sweep: what lies in it, when it counts as laid out, and what it refuses."""

import errno
import fcntl
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
import zarr

from radar_service.sweep.layout import layout_of
from radar_service.sweep.spec import SweepError
from radar_service.sweep.store import FORMAT, LEVEL, SweepStore, held, lay_out
from tests.sweep.sweeps import SCENE, SPEC, content, inputs, open_dataset, swept


def laid_out(
    folder: Path, name: str = "out.zarr", spec: str = SPEC, scene: str = SCENE, arithmetic: str = "x"
) -> SweepStore:
    of = inputs(folder / "in", spec, scene)
    return lay_out(str(folder / name), of, layout_of(of), arithmetic)


def test_format_and_codec_of_each_array_are_pinned(tmp_path: Path) -> None:
    laid_out(tmp_path)
    group = zarr.open_group(tmp_path / "out.zarr", mode="r")
    arrays = [array for _, array in (*group.arrays(), *group["inputs"].arrays())]  # type: ignore[union-attr]
    assert len(arrays) > 20 and group.metadata.zarr_format == FORMAT == 3
    for array in arrays:
        assert array.metadata.zarr_format == 3 and array.compressors == (zarr.codecs.ZstdCodec(level=LEVEL),)
        assert array.metadata.to_dict()["codecs"][0]["name"] in ("bytes", "vlen-utf8")


def test_a_store_that_is_laid_out_has_no_run_and_is_opened_again(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    before = content(tmp_path / "out.zarr")
    assert not store.finished.any() and not store.failures and laid_out(tmp_path).digest == store.digest
    assert content(tmp_path / "out.zarr") == before
    assert [*store.inputs.runs] == [*inputs(tmp_path / "in").runs]
    assert (store.sizes["run"], store.scans_per_chunk, store.body_names()) == (4, 2, ["buoy", "cube"])


def test_two_layouts_have_the_same_bytes(tmp_path: Path) -> None:
    laid_out(tmp_path)
    laid_out(tmp_path, "other.zarr")
    assert content(tmp_path / "out.zarr") == content(tmp_path / "other.zarr")


def test_a_layout_that_was_cut_anywhere_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file system ends at each of its first renames, in turn, and the temporary file stays."""
    expected = content(Path(laid_out(tmp_path).address))
    rename, renames, last = Path.replace, 0, 0

    def ends(path: Path, to: Path) -> Path:
        nonlocal renames
        renames += 1
        if renames >= last:
            to.with_suffix(".0.partial").touch()
            raise OSError(errno.EIO, "cut")
        return rename(path, to)

    for end in (1, 2, 3, 7, 20, 30):
        last, renames = end, 0
        with monkeypatch.context() as patch, pytest.raises(OSError, match="cut"):
            patch.setattr(Path, "replace", ends)
            laid_out(tmp_path, "cut.zarr")
    store = laid_out(tmp_path, "cut.zarr")
    store.clear()
    assert content(tmp_path / "cut.zarr") == expected


def test_a_run_counts_when_its_mark_is_there(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    store.write(2, 0, {"power": np.ones((2, 60, 40), np.float32)})
    store.write(2, 2, {"power": np.ones((1, 60, 40), np.float32)})
    assert not store.is_finished(2)
    store.finish(2)
    assert store.finished.tolist() == [False, False, True, False] and SweepStore(store.address, write=False).is_finished(2)
    store.fail(1, "too wet")
    assert SweepStore(store.address).failures == {1: "too wet"}
    (tmp_path / "out.zarr" / "power" / "c" / "0.abc.partial").touch()
    store.clear()
    assert not store.failures and not [*(tmp_path / "out.zarr").rglob("*.partial")]
    assert not (tmp_path / "out.zarr" / "failure" / "c" / "1").exists()  # as if it had never failed


def test_a_mark_of_something_else_is_none(tmp_path: Path) -> None:
    """A run that was copied from another store, or to another number."""
    one, other = laid_out(tmp_path), laid_out(tmp_path, "other.zarr", arithmetic="y")
    other.finish(1)
    for number in (1, 3):
        mark = tmp_path / "out.zarr" / "digest" / "c" / str(number)
        mark.parent.mkdir(exist_ok=True, parents=True)
        mark.write_bytes((tmp_path / "other.zarr" / "digest" / "c" / "1").read_bytes())
    assert not one.finished.any() and other.finished.tolist() == [False, True, False, False]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"spec": SPEC.replace("scans = 3", "scans = 4")}, "spec.scans is 3 there, and 4 here"),
        ({"spec": SPEC.replace("bins = 40", "")}, "spec.bins is 40 there, and absent here"),
        ({"spec": SPEC.replace("[5, 15]", "[5, 16]")}, r"spec.vary is \[\['body.buoy.rcs_dbsm', \[5, 15\]\]\] there, and"),
        ({"scene": SCENE.replace("= 10", "= 11")}, "scenes.small.toml is [0-9a-f]{32} there"),
        ({"arithmetic": "y"}, "arithmetic is x there, and y here"),
    ],
)
def test_a_store_of_another_sweep_is_refused_by_the_difference(change: dict[str, str], message: str, tmp_path: Path) -> None:
    before = content(laid_out(tmp_path).address)
    with pytest.raises(
        SweepError, match=f"out.zarr: it is of another sweep: {message}.*; give another name, or what it was"
    ):
        laid_out(tmp_path, **change)
    assert content(tmp_path / "out.zarr") == before


def test_what_is_no_sweep_is_left_alone(tmp_path: Path) -> None:
    folder, file, group = tmp_path / "folder.zarr", tmp_path / "file.zarr", tmp_path / "group.zarr"
    folder.mkdir()
    (folder / "thesis.txt").write_text("years of work")
    file.write_text("a file")
    zarr.create_group(group, zarr_format=3, attributes={"mine": 1})
    zarr.create_group(tmp_path / "old.zarr", zarr_format=2)
    before = content(tmp_path)
    for name, message in (
        ("folder.zarr", "it exists, and is no Zarr store"),
        ("group.zarr", "it holds another Zarr group"),
        ("old.zarr", "it exists, and is no Zarr store"),
    ):
        with pytest.raises(SweepError, match=f"{name}: {message}; give another name"):
            laid_out(tmp_path, name)
    with pytest.raises(SweepError, match="file.zarr: it exists, and is no folder; give another name"), held(str(file)):
        pass
    with pytest.raises(SweepError, match="there is no sweep; give the store of one"):
        SweepStore(str(group))
    with pytest.raises(SweepError, match="there is no sweep; give the store of one"):
        SweepStore(str(tmp_path / "none.zarr"))
    after = content(tmp_path)
    assert all(after[name] == before[name] for name in before) and not (tmp_path / "none.zarr").exists()


def test_a_store_has_one_writer_at_a_time(tmp_path: Path) -> None:
    address = laid_out(tmp_path).address
    descriptor = os.open(address, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    with pytest.raises(SweepError, match="out.zarr: another command writes to it; wait for its end"), held(address):
        pass
    os.close(descriptor)
    with held(address), pytest.raises(SweepError), held(address):
        pass


def test_an_object_store_is_one_more_address(tmp_path: Path) -> None:
    """fsspec's file system in memory stands for one: its puts are whole objects."""
    pytest.importorskip("fsspec")
    of = inputs(tmp_path)
    with held("memory://sweep/out.zarr"):
        store = lay_out("memory://sweep/out.zarr", of, layout_of(of), "x")
        store.write(1, 0, {"power": np.ones((3, 60, 40), np.float32)})
        store.finish(1)
        store.clear()
    again = lay_out("memory://sweep/out.zarr", of, layout_of(of), "x")
    assert again.finished.tolist() == [False, True, False, False]
    with pytest.raises(SweepError, match="it is of another sweep: arithmetic is x there, and y here"):
        lay_out("memory://sweep/out.zarr", of, layout_of(of), "y")
    with pytest.raises(
        SweepError, match=r"^nowhere://x.zarr: it cannot be used \(.*\); give a folder, or an address that fsspec"
    ):
        lay_out("nowhere://x.zarr", of, layout_of(of), "x")


def test_the_class_balance_is_that_of_the_labels_of_all_finished_runs(tmp_path: Path) -> None:
    """Two bodies make one class, and so does land; a scene without labels has none."""
    pier = SCENE + '[[body]]\nname = "pier"\nmesh = "cube.obj"\nposition_m = [-200, 100, 0]\nmaterial = "concrete"\n'
    _, address, _ = swept(tmp_path, SPEC.replace('"truth"', '"labels"'), pier)
    dataset, balance = open_dataset(address), SweepStore(address, write=False).class_balance()
    numbers = dataset.labels.values
    assert numbers.size == 4 * 3 * 60 * 40 and balance.keys() == {
        "noise",
        "range sidelobes and faint parts",
        "land",
        "bodies",
    }
    assert balance["noise"] == (numbers == 0).mean() and balance["land"] == ((numbers >= 16) & (numbers < 256)).mean()
    assert balance["bodies"] == (numbers >= 256).mean() and sum(balance.values()) == pytest.approx(1.0)
    assert dataset.label_cells.sum().item() == numbers.size and dataset.label_cells.names == dataset.labels.names
    assert laid_out(tmp_path / "power").class_balance() == {}


def test_xarray_opens_it_with_names_units_and_coordinates(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    store.write(1, 0, {"power": np.full((3, 60, 40), 7, np.float32)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        dataset = open_dataset(store.address)
    assert dataset.sizes["run"] == 4 and dataset.power.dims == ("run", "scan", "azimuth", "range")
    assert (dataset.power.units, dataset.range.units, dataset.azimuth.units, dataset.time.units) == ("W", "m", "rad", "s")
    assert all(dataset[name].attrs["long_name"] for name in dataset.variables)
    coordinates = {"run", "scan", "azimuth", "range", "seed", "scene", "time", "digest", "failure", "body.buoy.rcs_dbsm"}
    assert coordinates <= set(dataset.coords) and {"video", "power", "truth_range"} <= set(dataset.data_vars)
    assert (dataset.power.sel(run=1) == 7).all() and dataset.power.sel(run=0).isnull().all()
    by_value = dataset.assign_coords(rcs=dataset["body.buoy.rcs_dbsm"]).set_xindex("rcs").sel(rcs=5)
    assert by_value.run.values.tolist() == [0, 1]
