"""What a sweep keeps of each scan: the arrays, their dimensions, types, units and names, and how they come from a scan.

What varies in number, crossings and plots, fills the first places of its dimension; the rest is NaN, and -1 in whole numbers.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.bench.run import extractor_of
from radar_service.display.video import DB_PER_STEP, Controls, Layout, display_video, layout, peaks, strongest
from radar_service.plots import FloodWarning
from radar_service.radar import Radar
from radar_service.records import Crossing
from radar_service.scans import DESCRIBED, Scan
from radar_service.simulator import Simulator
from radar_service.sweep.spec import SweepError, SweepSpec

Arrays = dict[str, NDArray[Any]]
SPOKE, CELL = ("run", "scan", "azimuth"), ("run", "scan", "azimuth", "range")
CROSSING, PLOT = ("run", "scan", "crossing"), ("run", "scan", "plot")
OWN_SHIP = ("heading", "east", "north", "course", "speed")
OF_RUNS = {"range_first": "slant range of the first bin", "range_step": "length of a bin"}  # where these differ
COORDINATES = (*OF_RUNS, "time", *OWN_SHIP, "reported_azimuth")
VIDEO = (
    "video of a display with its default controls: 0 is below the threshold, b is "
    f"(b - 1) x {DB_PER_STEP} to b x {DB_PER_STEP} dB above it"
)


@dataclass(frozen=True)
class Variable:
    """An array of a store.

    dims: of its dimensions, the first is run. dtype: as numpy names it. fill: of runs that are not finished.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    fill: Any = 0

    @property
    def is_coordinate(self) -> bool:
        """Whether it says where and when, not what."""
        return self.name in COORDINATES


NAN = float("nan")
_CELLS = {
    "video": ("uint8", "1", VIDEO, 0),
    "power": ("float32", *DESCRIBED["power"][1:], NAN),
    "field": ("complex64", *DESCRIBED["field"][1:], complex(NAN, NAN)),
}
_OF_CROSSINGS = {
    "body": ("int32", "1", "number of the body in body_name, -1: no crossing", -1),
    "visible": ("int8", "1", "whether the radar sees the body, -1: no crossing", -1),
    "time": ("float64", "s", "time at which the boresight meets the body", NAN),
    "range": ("float64", "m", "slant range of the body's reference point", NAN),
    "bearing": ("float64", "rad", "bearing of the body's reference point, clockwise from true north", NAN),
    "east": ("float64", "m", "position of the body, east", NAN),
    "north": ("float64", "m", "position of the body, north", NAN),
    "course": ("float64", "rad", "course over ground of the body, clockwise from true north", NAN),
    "speed": ("float64", "m s-1", "speed over ground of the body", NAN),
    "aspect": ("float64", "rad", "bearing of the radar from the body's bow", NAN),
}
_OF_PLOTS = {
    "time": ("float64", "s", "time at which the beam met the centroid", NAN),
    "range": ("float64", "m", "slant range of the centroid", NAN),
    "bearing": ("float64", "rad", "bearing of the centroid, clockwise from true north", NAN),
    "east": ("float64", "m", "position of the centroid, east", NAN),
    "north": ("float64", "m", "position of the centroid, north", NAN),
    "snr_db": ("float64", "dB", "strongest cell over the mean receiver noise", NAN),
    "cells": ("int32", "1", "number of detections", 0),
}


def variables(spec: SweepSpec, max_label: int, has_errors: bool, same_range: bool) -> list[Variable]:
    """Returns the arrays of a specification.

    max_label: the largest number of a source. has_errors: on purpose, of any scene. same_range: whether bins of all runs stand at
    the same ranges.
    """
    result = [] if same_range else [Variable(name, ("run",), "float64", "m", text, NAN) for name, text in OF_RUNS.items()]
    spokes = ["time", *(OWN_SHIP if "own_ship" in spec.keep else ())]
    result += [Variable(name, SPOKE, "float64", *DESCRIBED[name][1:], NAN) for name in spokes]
    if has_errors:
        result.append(Variable("reported_azimuth", SPOKE, "float64", "rad", "boresight as the radar reports it", NAN))
    result += [Variable(name, CELL, *_CELLS[name]) for name in spec.keep if name in _CELLS]
    if "labels" in spec.keep:
        dtype = "uint16" if max_label < 2**16 else "uint32"
        result.append(Variable("labels", CELL, dtype, "1", "number of the strongest source, see names"))
        text = "number of cells with each label in all scans of the run"
        result.append(Variable("label_cells", ("run", "label"), "int64", "1", text))
    for kind, dims, fields in (("truth", CROSSING, _OF_CROSSINGS), ("plots", PLOT, _OF_PLOTS)):
        prefix = kind.removesuffix("s")
        result += [Variable(f"{prefix}_{name}", dims, *field) for name, field in fields.items() if kind in spec.keep]
    return result


def bins_of(radar: Radar, spec: SweepSpec) -> Layout:
    """Returns how the cells of a radar become the bins of a store."""
    first = 0.0 if spec.fidelity == "documented" else 0.5 * radar.range_step  # where sample 0 stands
    return layout(radar.bins, first, radar.range_step, spec.bins, pulses=radar.pulses_integrated)


class ScanReader:
    """Turns the scans of one run, in order, into arrays without their first two dimensions."""

    def __init__(self, simulator: Simulator, spec: SweepSpec, arrays: Sequence[Variable], sizes: Mapping[str, int],
                 bodies: Sequence[str]) -> None:  # fmt: skip
        """arrays: what is kept. sizes: by dimension. bodies: names that truth has the number of.

        Raises SweepError where the radar does not fit.
        """
        self._simulator, self._arrays, self._sizes = simulator, {array.name: array for array in arrays}, sizes
        self._to, self._bodies = bins_of(simulator.scene.radar, spec), {name: k for k, name in enumerate(bodies)}
        for what, here in (("azimuth", simulator.scene.radar.azimuths), ("range", self._to.bins)):
            if here != sizes[what]:
                raise SweepError(
                    f"its radar has {here} in {what}, and the store {sizes[what]}; vary nothing that changes it"
                )
        self._label_cells = np.zeros(sizes.get("label", 0), dtype=np.int64)
        self._plots = extractor_of(spec.plots, simulator.scene) if "plots" in spec.keep else None

    def arrays(self, scan: Scan) -> Arrays:
        """Returns the arrays of a scan. Raises SweepError for more crossings than the store has room for."""
        result: Arrays = {name: getattr(scan, name) for name in ("time", "heading", "course", "speed")}
        result |= {"east": scan.position[:, 0], "north": scan.position[:, 1], "reported_azimuth": scan.azimuth}
        result |= self._cells(scan)
        if "truth_body" in self._arrays:
            result |= self._truth(self._simulator.crossings(scan.number))
        if self._plots is not None:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", FloodWarning)  # a sweep may be about floods
                plots = self._plots.add(scan).plots
            result |= {
                f"plot_{name}": self._padded(f"plot_{name}", [getattr(plot, name) for plot in plots]) for name in _OF_PLOTS
            }
        return {
            name: np.asarray(result[name], dtype=array.dtype) for name, array in self._arrays.items() if "scan" in array.dims
        }

    def of_run(self) -> Arrays:
        """Returns the arrays that have no scans, after all scans."""
        values = {"range_first": self._to.first, "range_step": self._to.step, "label_cells": self._label_cells}
        return {name: np.asarray(value) for name, value in values.items() if name in self._arrays}

    def _cells(self, scan: Scan) -> Arrays:
        result: Arrays = {}
        if "video" in self._arrays:
            result["video"] = display_video(scan.power, self._to, Controls(), self._simulator.noise_power)
        if "power" in self._arrays:
            result["power"] = peaks(scan.power, self._to)
        if "field" in self._arrays:
            result["field"] = strongest(scan.field, self._to)
        if "labels" in self._arrays and scan.labels is not None:
            result["labels"] = _labels_of_peaks(scan, self._to)
            self._label_cells += np.bincount(result["labels"].ravel(), minlength=len(self._label_cells))
        return result

    def _truth(self, crossings: Sequence[Crossing]) -> Arrays:
        if len(crossings) > self._sizes["crossing"]:
            raise SweepError(
                f"truth: a scan has {len(crossings)} crossings, and the store room for {self._sizes['crossing']}; set "
                "max_crossings"
            )
        unknown = {crossing.body for crossing in crossings} - self._bodies.keys()
        if unknown:
            raise SweepError(f"truth: the store does not know the body {min(unknown)!r}; vary no names of bodies")
        values: dict[str, list[Any]] = {
            name: [getattr(crossing, name) for crossing in crossings]
            for name in ("time", "range", "bearing", "course", "speed", "aspect", "visible")
        }
        values |= {"body": [self._bodies[crossing.body] for crossing in crossings]}
        values |= {name: [crossing.position[axis] for crossing in crossings] for axis, name in enumerate(("east", "north"))}
        return {f"truth_{name}": self._padded(f"truth_{name}", some) for name, some in values.items()}

    def _padded(self, name: str, values: Sequence[Any]) -> NDArray[Any]:
        """Values at the first positions of the dimension of an array."""
        variable = self._arrays[name]
        row = np.full(self._sizes[variable.dims[-1]], variable.fill, dtype=variable.dtype)
        row[: len(values)] = values
        return row


def _labels_of_peaks(scan: Scan, to: Layout) -> NDArray[Any]:
    """The labels (A, bins) of the strongest cell in each bin; of the first one where several are equal."""
    assert scan.labels is not None
    if to.bins == to.samples:
        return scan.labels[:, : to.samples]
    power, highest = scan.power[:, : to.samples], peaks(scan.power, to)
    bin_of_cell = np.repeat(np.arange(to.bins), np.diff(np.append(to.starts, to.samples)))
    first = np.where(power == highest[:, bin_of_cell], np.arange(to.samples), to.samples)
    cell = np.minimum.reduceat(first, to.starts, axis=1)
    return np.asarray(np.take_along_axis(scan.labels, cell, axis=1))
