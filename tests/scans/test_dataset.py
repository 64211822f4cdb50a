"""Scans as datasets, and there and back through files."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.__main__ import main
from radar_service.scans.dataset import exporter, scans_to_xarray
from radar_service.scans.scan import Scan, scans_from_xarray
from radar_service.terminal.extras import install_command
from tests.scenes import ONE_TARGET


def simulated(count: int, sector: tuple[float, float] | None = None) -> list[Scan]:
    sim = rs.Simulator(rs.load_scene(ONE_TARGET | {"own_ship": {"heading_deg": 20, "speed_kn": 9}}), "fast", sector=sector)
    return [sim.scan() for _ in range(count)]


def assert_same(ours: list[Scan], others: list[Scan]) -> None:
    for one, other in zip(ours, others, strict=True):
        for name, value in vars(other).items():
            np.testing.assert_array_equal(getattr(one, name), value, err_msg=name)
        assert one.field.dtype == np.complex64 and one.power.dtype == np.float32


def test_a_scan_has_dimensions_coordinates_units_and_attributes() -> None:
    (scan,) = simulated(1)
    dataset = scan.to_xarray()
    assert dataset.field.dims == dataset.power.dims == ("azimuth", "range") and dataset.field.dtype == np.complex64
    assert dict(dataset.sizes) == {"azimuth": 60, "range": len(scan.range)}
    assert dataset.range.attrs == {"units": "m", "long_name": "one-way slant range of the sample"}
    assert {name: dataset[name].attrs["units"] for name in ("field", "power", "azimuth", "speed", "time")} == {
        "field": "W0.5", "power": "W", "azimuth": "rad", "speed": "m s-1", "time": "s",
    }  # fmt: skip
    assert dataset.attrs["Conventions"] == "CF-1.11" and dataset.attrs["range_step_m"] == scan.range_step
    strongest = dataset.power.where(dataset.power == dataset.power.max(), drop=True)
    assert float(strongest.range[0]) == pytest.approx(300, abs=2 * scan.range_step)  # a cell, and the height of the antenna
    assert float(dataset.heading[0]) == pytest.approx(np.deg2rad(20)) and int(dataset.scan) == 0
    assert_same(scans_from_xarray(dataset), [scan])


def test_scans_have_a_dimension_more() -> None:
    scans = simulated(3)
    dataset = scans_to_xarray(scans, {"seed": 4})
    assert dataset.power.dims == ("scan", "azimuth", "range") and dataset.attrs["seed"] == 4
    assert dataset.scan.values.tolist() == [0, 1, 2] and dataset.azimuth.dims == ("azimuth",)
    assert dataset.time.dims == ("scan", "azimuth")
    assert_same(scans_from_xarray(dataset), scans)
    assert_same(scans_from_xarray(scans_to_xarray(scans[:1])), scans[:1])


def opened(path: Path) -> Any:
    """The dataset of a file."""
    options = {"engine": "scipy"} if path.suffix == ".nc" else {"engine": "zarr", "consolidated": False}
    return pytest.importorskip("xarray").open_dataset(path, **options)


@pytest.mark.parametrize("ending", [".zarr", ".nc"])
@pytest.mark.parametrize("sector", [None, (0.3, 1.0)], ids=["whole", "sector"])
def test_files_give_the_scans_back(ending: str, sector: tuple[float, float] | None, tmp_path: Path) -> None:
    scans, path = simulated(2, sector), tmp_path / f"scans{ending}"
    for _ in range(2):  # the second time it is there already
        exporter(path)(path, scans, {"name": "one", "seed": 0})
    with opened(path) as dataset:
        assert dataset.attrs["name"] == "one" and dataset.power.attrs["units"] == "W"
        assert ("field_real" in dataset) == (ending == ".nc")
        assert_same(scans_from_xarray(dataset), scans)


@pytest.mark.parametrize("ending", [".zarr", ".nc"])
def test_the_command_exports_scans_with_labels(ending: str, one_target: Path, tmp_path: Path) -> None:
    path = tmp_path / f"a{ending}"
    assert main(["scan", str(one_target), "--scans", "2", "--seed", "5", "--labels", "-o", str(path)]) == 0
    with opened(path) as dataset:
        assert dataset.attrs["seed"] == 5 and dataset.sizes["scan"] == 2
        made = rs.Simulator(rs.load_scene(one_target), seed=5, labels=True)
        assert_same(scans_from_xarray(dataset), [made.scan() for _ in range(2)])
        assert dataset.source_name.values.tolist() == list(made.label_names.values())


@pytest.mark.parametrize("ending", [".zarr", ".nc"])
def test_labels_and_powers_go_through_files(ending: str, tmp_path: Path) -> None:
    sim = rs.Simulator(rs.load_scene(ONE_TARGET), "fast", labels=True, powers="all", sector=(0.3, 1.0))
    scans, names = [sim.scan() for _ in range(2)], sim.label_names
    dataset = scans_to_xarray(scans, names=names)
    assert dataset.labels.dims == ("scan", "azimuth", "range") and dataset.labels.dtype == np.uint32
    assert dataset.powers.dims == ("scan", "power_source", "azimuth", "range") and dataset.power_source.values.tolist() == [
        256
    ]
    assert str(dataset.source_name.sel(source=256).values) == "p"
    path = tmp_path / f"a{ending}"
    about = {"label_numbers": np.array(list(names), np.uint32), "label_names": np.array(list(names.values()))}
    exporter(path)(path, scans, about)
    with opened(path) as stored:
        assert dict(zip(stored.source.values.tolist(), stored.source_name.values.tolist(), strict=True)) == names
        for one, other in zip(scans, scans_from_xarray(stored), strict=True):
            assert (
                other.labels is not None and one.labels is not None and other.powers is not None and one.powers is not None
            )
            assert other.labels.dtype == np.uint32 and other.labels.tobytes() == one.labels.tobytes()
            for number, power in one.powers.items():
                np.testing.assert_array_equal(other.powers[number], power)


def test_labels_without_names_are_a_variable_alone() -> None:
    scan = rs.Simulator(rs.load_scene(ONE_TARGET), "fast", labels=True).scan()
    dataset = scan.to_xarray()
    assert dataset.labels.attrs["long_name"] == "number of the strongest source" and "source" not in dataset.dims
    assert scan.labels is not None and scans_from_xarray(dataset)[0].labels.tobytes() == scan.labels.tobytes()  # type: ignore[union-attr]
    assert scan.to_xarray({0: "noise", 256: "p"}).source_name.values.tolist() == ["noise", "p"]


def test_scans_that_do_not_fit_are_refused() -> None:
    one, other = simulated(2)
    with pytest.raises(ValueError, match="scans: there are none"):
        scans_to_xarray([])
    with pytest.raises(ValueError, match="scans: their range differs; give scans of one radar"):
        scans_to_xarray([one, replace(other, range=other.range + 1)])
    with pytest.raises(ValueError, match="scans: some have labels and others do not"):
        scans_to_xarray([one, replace(other, labels=np.zeros(other.power.shape, np.uint32))])
    with pytest.raises(ValueError, match="exported to .zarr or .nc; give it one of these endings"):
        exporter(Path("a.hdf"))


@pytest.mark.parametrize("package", ["xarray", "zarr"])
def test_without_the_packages_the_extra_is_named_before_anything_is_computed(
    package: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    assert main(["scan", "nowhere", "-o", str(tmp_path / "a.nc")]) == 2
    message = f"datasets need the package {package}, of the extra xarray; "
    assert capsys.readouterr().err == f"{message}in the folder of the checkout run: `{install_command('xarray')}`\n"
