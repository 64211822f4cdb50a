"""The layout of a store: its arrays, their sizes and chunks, and the coordinates that are known before the first run."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats
from radar_service.radar import Radar
from radar_service.sources.numbers import source_names
from radar_service.sweep.inputs import Inputs
from radar_service.sweep.spec import SweepError, SweepRun
from radar_service.sweep.variables import Variable, bins_of, variables
from radar_service.world import Scene

CHUNK_BYTES = 64 * 2**20  # of the largest array: video of seas and ships compresses to a fifth of it, as object stores like


@dataclass(frozen=True)
class Coordinate:
    """Values of a coordinate that are known before the first run."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any]


@dataclass(frozen=True)
class StoreLayout:
    """A store before its runs.

    sizes: by dimension.
    scans_per_chunk: a chunk has so many scans of one run.
    arrays: what runs write.
    coordinates: by name.
    labels: number and name of each source, by scene.
    """

    sizes: Mapping[str, int]
    scans_per_chunk: int
    arrays: tuple[Variable, ...]
    coordinates: Mapping[str, Coordinate]
    labels: Mapping[str, Mapping[str, str]]

    def shape(self, variable: Variable) -> tuple[int, ...]:
        """Returns the shape of an array."""
        return tuple(self.sizes[dim] for dim in variable.dims)

    def chunks(self, variable: Variable) -> tuple[int, ...]:
        """Returns the shape of the chunks of an array: never of more than one run."""
        of_run = {"run": 1, "scan": self.scans_per_chunk}
        return tuple(of_run.get(dim, self.sizes[dim]) for dim in variable.dims)

    @property
    def bytes_per_run(self) -> int:
        """Bytes of a run, not compressed."""
        return sum(map(self._bytes, self.arrays))

    @property
    def bytes(self) -> int:
        """Bytes of all runs, not compressed."""
        return self.sizes["run"] * self.bytes_per_run

    @property
    def chunk_bytes(self) -> int:
        """Bytes of a chunk of each array, not compressed: a worker holds them at a time."""
        return self.bytes_per_run * self.scans_per_chunk // self.sizes["scan"]

    def _bytes(self, variable: Variable) -> int:
        """Bytes of an array in one run."""
        return int(np.prod(self.shape(variable)[1:], dtype=np.int64)) * np.dtype(variable.dtype).itemsize

    def in_chunks(self, scans_per_chunk: int | None) -> "StoreLayout":
        """Returns the same in chunks of so many scans; None: of CHUNK_BYTES at most."""
        scans, largest = self.sizes["scan"], max(map(self._bytes, self.arrays))
        return replace(self, scans_per_chunk=min(scans, scans_per_chunk or max(1, CHUNK_BYTES * scans // largest)))


def layout_of(inputs: Inputs) -> StoreLayout:
    """Returns the layout of a store. Loads each scene with the values of its first run.

    Raises SweepError where a value is not possible, as far as that shows without files, or runs do not fit in the same arrays.
    """
    spec, corners = inputs.spec, inputs.runs.corners()
    radars = [(run, inputs.radar(run)) for run in corners]
    _check_sizes(inputs, radars)
    first = {run.scene: run for run in reversed(corners)}
    scenes = {spec.scene[k]: inputs.scene(first[k]) for k in sorted(first)}
    to, steps = bins_of(radars[0][1], spec), {bins_of(radar, spec).step for _, radar in radars}
    same_range = len(steps) == 1 and not any(key.split(".")[0] == "radar" for key in inputs.runs.drawn)
    names = list(dict.fromkeys(body.name for scene in scenes.values() for body in scene.bodies))
    labels = (
        {name: {str(k): v for k, v in source_names(scene).items()} for name, scene in scenes.items()}
        if "labels" in spec.keep
        else {}
    )
    largest = max((int(number) for numbers in labels.values() for number in numbers), default=0)
    arrays = variables(spec, largest, any(map(_has_errors, scenes.values())), same_range)
    sizes = {
        "run": len(inputs.runs), "scan": spec.scans, "azimuth": radars[0][1].azimuths, "range": to.bins, "body": len(names),
        "crossing": spec.max_crossings or max(1, 2 * max(len(scene.bodies) for scene in scenes.values())),
        "plot": spec.plots.max_plots, "label": largest + 1,
    }  # fmt: skip
    ranges: Floats | None = to.first + to.step * np.arange(to.bins, dtype=np.float64) if same_range else None
    layout = StoreLayout(sizes, spec.scans, tuple(arrays), _coordinates(inputs, sizes, names, ranges), labels)
    return layout.in_chunks(spec.scans_per_chunk)


def _check_sizes(inputs: Inputs, radars: list[tuple[SweepRun, Radar]]) -> None:
    """Raises SweepError where radars have different numbers of azimuths or bins."""
    (first, reference), spec = radars[0], inputs.spec
    for run, radar in radars:
        bins, others = bins_of(reference, spec).bins, bins_of(radar, spec).bins
        unequal = f"run {first.number} has {{}} {{}}, and run {run.number} {{}}; all share arrays: {{}}"
        if radar.azimuths != reference.azimuths:
            remedy = "give radars of as many azimuths, or make a sweep of each"
            raise SweepError(unequal.format(reference.azimuths, "azimuths", radar.azimuths, remedy))
        if others != bins:
            raise SweepError(unequal.format(bins, "bins", others, f"set bins to {min(radar.bins, reference.bins)} or less"))


def _has_errors(scene: Scene) -> bool:
    return scene.errors is not None or any(radar.errors is not None for radar in scene.radars)


def _coordinates(
    inputs: Inputs, sizes: Mapping[str, int], bodies: list[str], ranges: Floats | None
) -> dict[str, Coordinate]:
    """All that is known before the first run. ranges: of bins, where all runs have the same."""
    runs = list(inputs.runs)
    azimuth = np.arange(sizes["azimuth"]) * (2.0 * np.pi / sizes["azimuth"])
    result = {
        "run": Coordinate(("run",), np.arange(len(runs)), {"long_name": "number of the run"}),
        "scan": Coordinate(("scan",), np.arange(sizes["scan"]), {"long_name": "number of the scan"}),
        "azimuth": Coordinate(("azimuth",), azimuth, {"units": "rad", "long_name": "boresight, clockwise from true north"}),
        "body_name": Coordinate(("body",), _texts(bodies), {"long_name": "name of the body of that number"}),
        "scene": Coordinate(("run",), _texts([inputs.spec.scene[run.scene] for run in runs]), {"long_name": "scene"}),
        "radar_id": Coordinate(
            ("run",), _texts([run.radar or "" for run in runs]), {"long_name": "radar, empty: the first"}
        ),
        "seed": Coordinate(("run",), np.array([run.seed for run in runs]), {"long_name": "seed of the simulation"}),
    }
    if ranges is not None:
        attributes = {"units": "m", "long_name": "one-way slant range of the bin's middle"}
        result["range"] = Coordinate(("range",), ranges, attributes)
    if not bodies:
        del result["body_name"]
    for key in inputs.spec.vary:
        values = _values([run.values[key] for run in runs])
        result[key.replace("/", "_")] = Coordinate(("run",), values, {"long_name": f"value of the scene key {key}"})
    return result


def _values(values: list[Any]) -> NDArray[Any]:
    """Values of a key as an array: numbers, truth values, or texts; lists and tables as JSON."""
    if all(isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.bool_)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.float64)
    return _texts([value if isinstance(value, str) else json.dumps(value) for value in values])


def _texts(values: list[str]) -> NDArray[Any]:
    return np.array(values, dtype=object)
