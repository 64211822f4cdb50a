"""A scan: one revolution as arrays, its file and its pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from radar_service.display.palettes import colour_map
from radar_service.display.picture import picture_from_power, render_png
from radar_service.display.ppi import scan_convert
from radar_service.display.units import UNITS, Unit
from radar_service.numerics import Floats, Profiles, Singles
from radar_service.records import Labels, Powers, SpokeBlock, joined
from radar_service.scans.dataset import powered, powers_of, scan_to_xarray
from radar_service.scans.file import read_arrays, write_arrays
from radar_service.terminal import extra

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

PICTURE_SIZE = 600  # pixels of a notebook's picture
PLOT_SIZE = 1000  # pixels of a plot


@dataclass(frozen=True)
class Scan:
    """One revolution of A azimuths and N range cells, all SI and radians.

    In a scan from a file the values of a missing azimuth are NaN; so is `field` where the file has none.
    """

    number: int  # since the start of the simulation
    time: Floats  # (A,) s
    azimuth: Floats  # (A,) from true north, clockwise: the boresight, or with errors on purpose as reported
    heading: Floats  # (A,) of own ship
    position: Floats  # (A, 2) m east and north, of own ship
    course: Floats  # (A,) of own ship
    speed: Floats  # (A,) m/s, of own ship
    range: Floats  # (N,) m, where the samples stand
    range_step: float  # m
    field: Profiles  # (A, N) sqrt(W), compressed, before detection
    power: Singles  # (A, N) W
    labels: Labels | None = None  # (A, N) number of the strongest source, 0 in a missing azimuth
    powers: Powers | None = None  # (A, N) W of each source, by its number

    def save(self, path: str | Path) -> None:
        """Write the scan to a .npz file; `scan_file` has the layout. Raises ValueError for another suffix; OSError."""
        save_scans(path, [self])

    def to_xarray(self, names: Mapping[int, str] | None = None) -> xarray.Dataset:
        """Return the scan as an xarray dataset with coordinates, units and attributes. Raises MissingExtra.

        names: of the sources, as `Simulator.label_names`.
        """
        return scan_to_xarray(self, names=names)

    def plot(
        self, axes: Axes | None = None, *, dynamic_range_db: float = 60.0, range_max: float | None = None, unit: Unit = "m"
    ) -> Axes:  # fmt: skip
        """Plot the PPI with matplotlib, north up and own ship in the middle, and return its axes.

        axes: where to, by default new ones. dynamic_range_db: colours span this much below the strongest cell. range_max:
        half the width [m], by default the whole range. unit: of the axes. Raises MissingExtra, and ValueError for a dynamic
        range not above 0.
        """
        with extra("pictures", "plots of scans"):
            import matplotlib.pyplot as plt  # here: it would take a third of every start
            from matplotlib.colors import ListedColormap

        reach, scale = range_max or float(self.range[-1] + self.range_step / 2.0), UNITS[unit]
        edge = reach / scale.metres
        bright = picture_from_power(np.nan_to_num(self.power), dynamic_range_db)
        image = scan_convert(bright, float(self.range[0]), self.range_step, PLOT_SIZE, reach, interpolation="peak")
        axes = plt.subplots(figsize=(7.0, 6.0), layout="constrained")[1] if axes is None else axes
        drawn = axes.imshow(
            (image / 255.0 - 1.0) * dynamic_range_db, cmap=ListedColormap(colour_map() / 255.0), vmin=-dynamic_range_db,
            vmax=0.0, extent=(-edge, edge, -edge, edge), interpolation="nearest",
        )  # fmt: skip
        axes.figure.colorbar(drawn, ax=axes, label="power relative to the strongest cell [dB]")
        east, north = (f"{side} of own ship [{scale.name}]" for side in ("east", "north"))
        axes.set(xlabel=east, ylabel=north, title=f"scan {self.number}")
        return axes

    def _repr_png_(self) -> bytes:
        """The PPI for notebooks."""
        filled, bright = ~np.isnan(self.time), picture_from_power(np.nan_to_num(self.power))
        heading = float(self.heading[filled][-1]) if filled.any() else None
        return render_png(
            bright, float(self.range[0]), self.range_step, size=PICTURE_SIZE, heading=heading, title=f"scan {self.number}",
            filled=filled,
        )  # fmt: skip

    def __repr__(self) -> str:
        power = np.nan_to_num(self.power)
        azimuth, cell = np.unravel_index(power.argmax(), power.shape)
        level = f"{10.0 * np.log10(power[azimuth, cell]):.1f} dBW" if power[azimuth, cell] > 0 else "no power"
        seconds = f"{np.nanmin(self.time):.3f} to {np.nanmax(self.time):.3f} s" if not np.isnan(self.time).all() else "empty"
        return (
            f"<Scan {self.number}: {len(self.azimuth)} azimuths x {len(self.range)} cells of {self.range_step:.4g} m, "
            f"{seconds},\n  strongest {level} at {np.rad2deg(self.azimuth[azimuth]):.1f} degrees, {self.range[cell]:.1f} m>"
        )


def scan_of(blocks: Iterable[SpokeBlock], azimuths: int | None = None) -> Scan:
    """The blocks of one scan, of which some may be missing, as a scan.

    azimuths: of a whole scan; without it the blocks are all of one. Azimuths without a block are NaN.
    """
    parts = list(blocks)
    block = joined(parts)
    count = azimuths or len(block)
    rows = np.concatenate([part.index + np.arange(len(part)) for part in parts])

    def spread(values: NDArray[Any]) -> NDArray[Any]:
        if len(values) == count:
            return values
        missing = np.nan if values.dtype.kind in "fc" else 0
        result = np.full((count, *values.shape[1:]), missing, dtype=values.dtype)
        result[rows] = values
        return result

    azimuth = _boresight(count) if block.true is None else spread(block.azimuth)
    return Scan(
        block.scan, spread(block.time), azimuth, spread(block.heading), spread(block.position), spread(block.course),
        spread(block.speed), block.range, block.range_step, spread(block.field), spread(block.power),
        None if block.labels is None else spread(block.labels),
        None if block.powers is None else {number: spread(power) for number, power in block.powers.items()},
    )  # fmt: skip


def _boresight(azimuths: int) -> Floats:
    """The boresights (A,) of a scan [rad]."""
    return np.arange(azimuths, dtype=np.float64) * (2.0 * np.pi / azimuths)


def save_scans(path: str | Path, scans: Sequence[Scan], about: Mapping[str, Any] | None = None) -> None:
    """Write whole scans of one radar to a .npz file. about: `name`, `fidelity` and `seed`. Raises ValueError and OSError."""
    first, number = scans[0], np.array([scan.number for scan in scans])
    azimuths, reported = len(first.azimuth), np.stack([scan.azimuth for scan in scans])
    keys = ["time", "heading", "course", "speed", "position", "field", "power"]
    keys += ["labels"] if first.labels is not None else []
    spoke = number[:, None] * azimuths + np.arange(azimuths)
    each = {key: np.stack([getattr(scan, key) for scan in scans]) for key in keys}
    shared: dict[str, Any] = {"azimuth": _boresight(azimuths), "range": first.range, "range_step": first.range_step}
    if not np.array_equal(reported, np.broadcast_to(shared["azimuth"], reported.shape)):
        shared["reported_azimuth"] = reported
    if first.powers is not None:
        numbers = powered(scans)
        shared["power_sources"] = np.array(numbers, dtype=np.uint32)
        each["powers"] = np.stack([powers_of(scan, numbers) for scan in scans])
    came = ~np.isnan(each["time"])
    write_arrays(path, each | shared | {"number": number, "spoke": np.where(came, spoke, -1)} | dict(about or {}))


def load_scan(path: str | Path, index: int = 0) -> Scan:
    """Read one scan of a .npz file that `Scan.save`, `radar-service scan` or the client wrote.

    index: which of its scans, by default the first; -1 is the last. Raises ValueError where the file is none of those, has
    fewer scans, or holds no power (the client's `u8` is brightness); OSError.
    """
    arrays = read_arrays(path)
    numbers = arrays["number"]
    if not -len(numbers) <= index < len(numbers):
        raise ValueError(f"index: {index} is not in {path}, which holds {len(numbers)} scans; give 0 to {len(numbers) - 1}")
    if "power" not in arrays:
        raise ValueError(f"{path}: holds no power; have the client write another encoding than u8")
    power = arrays["power"][index]
    nothing = np.broadcast_to(np.complex64(complex(np.nan, np.nan)), power.shape)
    azimuth = arrays["reported_azimuth"][index] if "reported_azimuth" in arrays else arrays["azimuth"]
    return Scan(
        int(numbers[index]), arrays["time"][index], azimuth, arrays["heading"][index], arrays["position"][index],
        arrays["course"][index], arrays["speed"][index], arrays["range"], float(arrays["range_step"]),
        arrays["field"][index] if "field" in arrays else nothing, power, arrays["labels"][index] if "labels" in arrays else None,
        dict(zip(arrays["power_sources"].tolist(), arrays["powers"][index], strict=True)) if "powers" in arrays else None,
    )  # fmt: skip


def scans_from_xarray(dataset: xarray.Dataset) -> list[Scan]:
    """Returns the scans of a dataset that `scans_to_xarray` or `scan_to_xarray` made, also after a file."""
    scans = dataset if "scan" in dataset.dims else dataset.expand_dims("scan")
    return [_scan(scans.isel(scan=k)) for k in range(scans.sizes["scan"])]


def _scan(dataset: xarray.Dataset) -> Scan:
    if "field" in dataset:
        field = dataset["field"].values
    else:
        field = (dataset["field_real"].values + np.complex64(1j) * dataset["field_imag"].values).astype(np.complex64)
    single: dict[str, Any] = {
        name: dataset[name].values for name in ("time", "azimuth", "heading", "course", "speed", "range")
    }
    position = np.stack([dataset["east"].values, dataset["north"].values], axis=-1)
    step, power = float(dataset.attrs["range_step_m"]), np.asarray(dataset["power"].values, dtype=np.float32)
    labels = np.asarray(dataset["labels"].values, dtype=np.uint32) if "labels" in dataset else None
    return Scan(
        number=int(dataset["scan"]), position=position, range_step=step, field=field, power=power, labels=labels,
        powers=_stored_powers(dataset) if "powers" in dataset else None, **single,
    )  # fmt: skip


def _stored_powers(dataset: xarray.Dataset) -> dict[int, np.ndarray[Any, np.dtype[np.float32]]]:
    return {
        int(number): np.asarray(dataset["powers"].sel(power_source=number).values)
        for number in dataset["power_source"].values
    }
