"""Scans as xarray datasets, and as files of Zarr and netCDF: arrays with coordinates, units and attributes (CF-1.11).

Dimensions are azimuth and range, of several scans scan before them, and of the power of each source also power_source. NetCDF
has no complex numbers: there `field` is `field_real` and `field_imag`. Times are seconds of simulation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from radar_service.numerics import Singles
from radar_service.terminal import extra, written

if TYPE_CHECKING:
    import xarray

    from radar_service.scans.scan import Scan

Export = Callable[[Path, "Sequence[Scan]", Mapping[str, Any]], None]
RAY, CELL = ("azimuth",), ("azimuth", "range")
DESCRIBED: dict[str, tuple[tuple[str, ...], str, str]] = {  # dimensions, units, long_name
    "azimuth": (RAY, "rad", "boresight, clockwise from true north"),
    "range": (("range",), "m", "one-way slant range of the sample"),
    "time": (RAY, "s", "time of simulation"),
    "heading": (RAY, "rad", "heading of own ship, clockwise from true north"),
    "east": (RAY, "m", "position of own ship, east"),
    "north": (RAY, "m", "position of own ship, north"),
    "course": (RAY, "rad", "course over ground of own ship, clockwise from true north"),
    "speed": (RAY, "m s-1", "speed over ground of own ship"),
    "field": (CELL, "W0.5", "compressed field before detection"),
    "power": (CELL, "W", "received power"),
    "labels": (CELL, "1", "number of the strongest source"),
    "powers": (("power_source", *CELL), "W", "power of each source alone"),
    "power_source": (("power_source",), "1", "number of the source"),
    "source": (("source",), "1", "number of the source"),
    "source_name": (("source",), "1", "name of the source of that number"),
}
OF_ALL = ("azimuth", "range")  # equal in all scans of a radar
DATA = ("field", "power", "labels", "powers")
OPTIONAL = ("labels", "powers", "power_source", "source", "source_name")


def scans_to_xarray(
    scans: Sequence[Scan], about: Mapping[str, Any] | None = None, names: Mapping[int, str] | None = None
) -> xarray.Dataset:
    """Returns scans of one radar as a dataset with the dimensions scan, azimuth and range.

    about: attributes beside those of the scans, as `name`, `seed` and `fidelity`; names: of the sources that labels and powers
    have the numbers of. Raises ValueError for no scan, for scans of several radars, and where not all have labels, or powers;
    MissingExtra where xarray is not installed.
    """
    if not scans:
        raise ValueError("scans: there are none; give at least one scan")
    for name in OF_ALL:
        if any(not np.array_equal(getattr(scan, name), getattr(scans[0], name)) for scan in scans):
            raise ValueError(f"scans: their {name} differs; give scans of one radar")
    for name in ("labels", "powers"):
        if len({getattr(scan, name) is None for scan in scans}) > 1:
            raise ValueError(f"scans: some have {name} and others do not; give scans of one kind")
    numbers = powered(scans)
    each = [_dataset(scan, about, names, numbers) for scan in scans]
    dataset: xarray.Dataset = _library().concat(
        each, "scan", data_vars="all", coords="different", compat="equals", join="exact"
    )
    return dataset.assign_coords(scan=("scan", [scan.number for scan in scans], {"long_name": "number of the scan"}))


def scan_to_xarray(scan: Scan, names: Mapping[int, str] | None = None) -> xarray.Dataset:
    """Returns a scan as a dataset with the dimensions azimuth and range. names: of the sources. Raises MissingExtra."""
    return _dataset(scan, None, names, powered([scan]))


def _dataset(
    scan: Scan, about: Mapping[str, Any] | None, names: Mapping[int, str] | None, numbers: Sequence[int]
) -> xarray.Dataset:
    """The dataset of a scan, with the powers of the sources of these numbers."""
    library = _library()
    values = {name: getattr(scan, name, None) for name in DESCRIBED}
    values |= {"east": scan.position[:, 0], "north": scan.position[:, 1]}
    if scan.powers is not None:
        values |= {"powers": powers_of(scan, numbers), "power_source": np.array(numbers, dtype=np.uint32)}
    if names:
        values |= {"source": np.array(list(names), np.uint32), "source_name": np.array(list(names.values()), dtype=object)}
    variables = {
        name: library.Variable(dims, values[name], {"units": units, "long_name": text})
        for name, (dims, units, text) in DESCRIBED.items()
        if name not in OPTIONAL or values[name] is not None
    }
    attributes = {
        "Conventions": "CF-1.11", "title": "scan of a simulated marine radar", "range_step_m": scan.range_step,
        "source": f"radar-service {version('radar-service')}",
    }  # fmt: skip
    coordinates = {name: variables[name] for name in variables if name not in DATA} | {"scan": scan.number}
    dataset: xarray.Dataset = library.Dataset(
        {name: variables[name] for name in DATA if name in variables}, coordinates, attributes | dict(about or {})
    )
    return dataset


def exporter(path: Path) -> Export:
    """Returns what writes scans to a path that ends in .zarr (a folder) or .nc (netCDF 3): a function of path, scans, attributes.

    Raises ValueError for another ending, and MissingExtra where a package is not installed: now, not after the scans. The
    function raises OSError.
    """
    _library()
    if path.suffix.lower() not in EXPORTS:
        raise ValueError(f"{path}: scans are exported to {' or '.join(EXPORTS)}; give it one of these endings")
    return EXPORTS[path.suffix.lower()]


def _exported(scans: Sequence[Scan], about: Mapping[str, Any] | None) -> xarray.Dataset:
    """The dataset of scans with what a file of scans says about them, see `scan_file`."""
    rest = dict(about or {})
    numbers, names = (rest.pop(key, np.array(())).tolist() for key in ("label_numbers", "label_names"))
    return scans_to_xarray(scans, rest, dict(zip(numbers, names, strict=True)))


def _to_zarr(path: Path, scans: Sequence[Scan], about: Mapping[str, Any] | None = None) -> None:
    from zarr.storage import MemoryStore

    files: dict[str, Any] = {}  # in memory: after an error zarr would go on writing to a folder
    _exported(scans, about).to_zarr(MemoryStore(files), mode="w", consolidated=False)
    with written(path) as part:
        for name, content in files.items():
            (part / name).parent.mkdir(parents=True, exist_ok=True)
            (part / name).write_bytes(content.to_bytes())


def _to_netcdf(path: Path, scans: Sequence[Scan], about: Mapping[str, Any] | None = None) -> None:
    with written(path) as part:
        _split(_exported(scans, about)).to_netcdf(part, engine="scipy", format="NETCDF3_64BIT")


EXPORTS: dict[str, Export] = {".zarr": _to_zarr, ".nc": _to_netcdf}


def _library() -> Any:
    with extra("xarray", "datasets"):
        import xarray
        import zarr  # noqa: F401  # the extra brings both
    return xarray


def _split(dataset: xarray.Dataset) -> xarray.Dataset:
    """The dataset with the parts of the field in its place."""
    field = dataset["field"]
    parts = {f"field_{name}": (field.dims, getattr(field.values, name), field.attrs) for name in ("real", "imag")}
    return dataset.drop_vars("field").assign(parts)


def powered(scans: Iterable[Scan]) -> list[int]:
    """The numbers of the sources (P,) that any of the scans has the power of, rising."""
    return sorted({number for scan in scans for number in scan.powers or ()})


def powers_of(scan: Scan, numbers: Sequence[int]) -> Singles:
    """The power (P, A, N) of the sources of these numbers [W]. A source that the scan does not have has no power."""
    nothing = np.where(np.isnan(scan.power), scan.power, np.float32(0.0))
    powers = [(scan.powers or {}).get(number, nothing) for number in numbers]
    return np.array(powers, dtype=np.float32).reshape(len(numbers), *scan.power.shape)
