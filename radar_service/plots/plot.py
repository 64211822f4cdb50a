"""A plot: the position and time that a radar reports for one cluster of detections."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats, Indices, wrap_angle, wrap_bearing
from radar_service.plots.detections import Detections
from radar_service.plots.groups import Groups
from radar_service.radar import Radar

MAX_SPEED = 51.4  # m/s: 100 kn
CENTROID_CUT = 1e-3  # of a plot's peak: weaker cells are noise and sidelobes; points at 48 dB err by 3 mm, 22 mm without


@dataclass(frozen=True, kw_only=True)
class Plot:
    """What one cluster of detections reports. SI, angles [rad] clockwise from true north.

    scan: number of the scan in which the centroid lies.
    time: at which the beam met the centroid [s].
    range, bearing: of the centroid, from the antenna.
    east, north: of the centroid on the map [m].
    snr_db: of the strongest cell, over the mean receiver noise.
    cells: number of detections.
    range_extent: from and to, outer edges of the cells [m].
    bearing_extent: from and to, clockwise, outer edges of the spokes.
    correlated: whether the scan before had a plot from where a craft of 100 kn comes; None: not asked (`ScanTags`).
    """

    scan: int
    time: float
    range: float
    bearing: float
    east: float
    north: float
    snr_db: float
    cells: int
    range_extent: tuple[float, float]
    bearing_extent: tuple[float, float]
    correlated: bool | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data: the names of the fields, and `type`; without `correlated` where that is None."""
        return {"type": "plot", **{name: value for name, value in asdict(self).items() if value is not None}}


class ScanTags:
    """Correlation from scan to scan as a tag of the plots of one radar.

    It is no gate: MSC.192(79) 5.3.1.1 has targets of 100 kn, and whether plots of N scans are a track is for the tracker.
    """

    def __init__(self, radar: Radar) -> None:
        self._reach = MAX_SPEED * radar.rotation_period + 2.0 * radar.range_step
        self._before = np.empty((0, 2))

    def of(self, plots: Sequence[Plot]) -> tuple[Plot, ...]:
        """Returns the plots of the next scan with their tags."""
        from scipy.spatial import cKDTree  # here: it takes half of the start of a tracker, which needs plots alone

        place = np.array([(plot.east, plot.north) for plot in plots]).reshape(-1, 2)
        before, self._before = self._before, place
        near = np.zeros(len(place), dtype=np.bool_)
        if len(before) and len(place):
            near = np.asarray(cKDTree(before).query(place)[0] <= self._reach)
        return tuple(replace(plot, correlated=tag) for plot, tag in zip(plots, near.tolist(), strict=True))


@dataclass(frozen=True)
class ScanGeometry:
    """How spokes and cells lie. azimuths: spokes per scan; first, step: of cells [m]; noise_power: of a cell [W]."""

    azimuths: int
    first: float
    step: float
    noise_power: float


def plot_columns(detections: Detections, plots: Groups, geometry: ScanGeometry) -> dict[str, NDArray[Any]]:
    """Returns the values of each plot (P,) by the names of Plot's fields; extents are (P, 2).

    The position is the centroid of the power above the threshold, and above CENTROID_CUT of its peak: cells at the edge of that
    count little, so that a centroid does not jump where a cell more is in. detections: (C,), in the order of their plots.
    """
    strongest, first = plots.strongest(detections.power), plots.start
    peak, reference = detections.power[strongest], detections.azimuth[strongest]
    level = np.maximum(detections.threshold, CENTROID_CUT * peak[plots.of_each])
    weight = np.maximum(detections.power - level, 0.0)
    weight /= plots.total(weight)[plots.of_each]
    offset = wrap_angle(detections.azimuth - reference[plots.of_each])
    distance: Floats = geometry.first + geometry.step * detections.cell.astype(np.float64)

    def mean(values: NDArray[Any], origin: NDArray[Any]) -> Floats:
        return origin + plots.total(weight * (values - origin[plots.of_each]))

    centroid, bearing = mean(distance, distance[first]), reference + plots.total(weight * offset)
    edge, half = geometry.step / 2.0, np.pi / geometry.azimuths
    return {
        "scan": ((mean(detections.spoke, detections.spoke[first]) + 0.5) // geometry.azimuths).astype(np.int64),
        "time": mean(detections.time, detections.time[first]), "range": centroid, "bearing": wrap_bearing(bearing),
        "east": plots.total(weight * detections.east) + centroid * np.sin(bearing),
        "north": plots.total(weight * detections.north) + centroid * np.cos(bearing),
        "snr_db": 10.0 * np.log10(peak / geometry.noise_power), "cells": plots.count,
        "range_extent": np.stack([plots.minimum(distance) - edge, plots.maximum(distance) + edge], axis=1),
        "bearing_extent": wrap_bearing(
            reference[:, None] + np.stack([plots.minimum(offset) - half, plots.maximum(offset) + half], axis=1)
        ),
    }  # fmt: skip


def plots_of(columns: Mapping[str, NDArray[Any]], rows: Indices) -> list[Plot]:
    """Returns the plots of some rows (K,) of `plot_columns`."""
    values = {name: column[rows].tolist() for name, column in columns.items()}
    values |= {name: map(tuple, values[name]) for name in ("range_extent", "bearing_extent")}
    return [Plot(**dict(zip(values, row, strict=True))) for row in zip(*values.values(), strict=True)]
