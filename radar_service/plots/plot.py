"""A plot: the position and time that a radar reports for one cluster of detections."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from radar_service.numerics.frames import wrap_angle, wrap_bearing
from radar_service.numerics.types import Floats
from radar_service.plots.detections import Detections
from radar_service.plots.groups import Groups

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

    def as_dict(self) -> dict[str, Any]:
        """Plain data: the names of the fields, and `type`."""
        return {"type": "plot", **asdict(self)}


@dataclass(frozen=True)
class ScanGeometry:
    """How spokes and cells lie. azimuths: spokes per scan; first, step: of cells [m]; noise_power: of a cell [W]."""

    azimuths: int
    first: float
    step: float
    noise_power: float


def centroid_ranges(detections: Detections, plots: Groups, geometry: ScanGeometry) -> Floats:
    """Returns the range (P,) of the centroid of each plot [m], as `plot_of` has it but for rounding."""
    peak = plots.maximum(detections.power)[plots.of_each]
    weight = detections.power - np.maximum(detections.threshold, CENTROID_CUT * peak)
    weight = np.maximum(weight, 0.0)
    return geometry.first + geometry.step * (plots.total(weight * detections.cell) / plots.total(weight))


def plot_of(detections: Detections, geometry: ScanGeometry) -> Plot:
    """Returns the plot of one cluster.

    Its position is the centroid of the power above the threshold, and above CENTROID_CUT of its peak: cells at the edge of that
    count little, so that a centroid does not jump where a cell more is in.
    """
    level = np.maximum(detections.threshold, CENTROID_CUT * detections.power.max())
    weight = np.maximum(detections.power - level, 0.0)
    weight /= weight.sum()
    strongest = int(detections.power.argmax())
    reference = detections.azimuth[strongest]
    offset = wrap_angle(detections.azimuth - reference)
    distance = geometry.first + geometry.step * detections.cell
    centroid, bearing = float(weight @ distance), float(reference + weight @ offset)
    half = np.pi / geometry.azimuths
    return Plot(
        scan=int((weight @ (detections.spoke - detections.spoke[0]) + detections.spoke[0] + 0.5) // geometry.azimuths),
        time=float(weight @ (detections.time - detections.time[0]) + detections.time[0]),
        range=centroid,
        bearing=float(wrap_bearing(np.asarray(bearing))),
        east=float(weight @ detections.east + centroid * np.sin(bearing)),
        north=float(weight @ detections.north + centroid * np.cos(bearing)),
        snr_db=float(10.0 * np.log10(detections.power[strongest] / geometry.noise_power)),
        cells=len(detections),
        range_extent=(float(distance.min() - geometry.step / 2.0), float(distance.max() + geometry.step / 2.0)),
        bearing_extent=(
            float(wrap_bearing(reference + offset.min() - half)), float(wrap_bearing(reference + offset.max() + half)),
        ),
    )  # fmt: skip
