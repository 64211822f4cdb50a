"""The sea around the antenna as cells in range and azimuth: grazing angle, direction factor, and shadows of bodies."""

from typing import NamedTuple

import numpy as np

from radar_service.clutter.azimuth_rows import BLOCK, AzimuthRowCache, StaticAzimuthRows
from radar_service.clutter.sea import wind_factor
from radar_service.frames import wrap_angle
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Floats, Singles

FINE_CELL, COARSE_CELL = 10.0, 40.0  # m; the second for a moving antenna, whose cells are renewed in each scan


class SeaPoint(NamedTuple):
    """Where the sphere of a slant range meets the sea, arrays of one shape; all are 0 where it does not reach the sea.

    distance: along the ground [m].
    elevation: of the ray at the antenna [rad].
    grazing: angle at the sea [rad].
    """

    distance: Floats
    elevation: Floats
    grazing: Floats


def sea_point(distance: Floats, antenna_height: float, earth_radius: float) -> SeaPoint:
    """The sea z = -d^2 / (2 ae) - height at slant ranges of any shape [m]; grazing is negative beyond the horizon.

    antenna_height: [m]; earth_radius: effective, inf for flat [m].
    """
    reaches = distance > antenna_height
    r2 = distance**2
    # d^2 + (h + d^2/(2 ae))^2 = R^2; the second pass leaves less than a millimetre at 100 km
    ground2 = np.maximum(r2 - antenna_height**2, 0.0)
    for _ in range(2):
        ground2 = np.maximum(r2 - (antenna_height + ground2 / (2.0 * earth_radius)) ** 2, 0.0)
    ground = np.sqrt(ground2)
    dip = np.arctan2(antenna_height + ground2 / (2.0 * earth_radius), ground)
    grazing = dip - ground / earth_radius
    return SeaPoint(np.where(reaches, ground, 0.0), np.where(reaches, -dip, 0.0), np.where(reaches, grazing, 0.0))


class SeaCells:
    """Factor on the sea's mean power in each cell: 0 in shadow or on land, else `wind_factor`.

    Rows divide the circle evenly; row 0 points north. For an antenna at rest all rows are computed once. For a moving one each
    row is computed when the beam points at it, once per scan. Moving bodies cast no shadow on sea clutter.
    """

    def __init__(
        self, scene: Scene, line_of_sight: OcclusionScene, rows_per_scan: int, max_range: float, column_bins: int = 1
    ) -> None:
        """max_range: slant range [m] up to which there are cells; column_bins: a divisor of the bins per cell."""
        self.scene, self.line_of_sight = scene, line_of_sight
        rests = scene.own_ship.at_rest
        step = scene.radar.range_step
        size = FINE_CELL if rests else COARSE_CELL
        self.bins = column_bins * max(1, round(size / (step * column_bins)))  # range bins per cell
        self.count = int(np.ceil(max_range / (step * self.bins) - 1e-9))
        middle = (np.arange(self.count, dtype=np.float64) + 0.5) * step * self.bins
        self._point = sea_point(middle, scene.radar.height, line_of_sight.earth_radius)
        self.rows_per_scan = rows_per_scan
        self.rows = StaticAzimuthRows(self._all_round()) if rests else AzimuthRowCache(rows_per_scan, self._computed)

    def _all_round(self) -> Singles:
        """Factors (rows, cells) of the full circle, for an antenna at rest."""
        starts = range(0, self.rows_per_scan, BLOCK)
        return np.concatenate([self._computed(0, start, min(start + BLOCK, self.rows_per_scan)) for start in starts])

    def _computed(self, scan: int, start: int, stop: int) -> Singles:
        """Factors (stop - start, cells) of some rows at the time when the beam passes the middle one."""
        azimuth = np.arange(start, stop, dtype=np.float64) * (2.0 * np.pi / self.rows_per_scan)
        radar, wind_from = self.scene.radar, self.scene.environment.wind_from
        factor = wind_factor((azimuth - wind_from)[:, None], self._point.grazing, radar.wavelength)
        visible = np.repeat(self._point.grazing[None] > 0, len(azimuth), axis=0)
        time = (scan + 0.5 * (start + stop) / self.rows_per_scan) * radar.rotation_period
        antenna = self.scene.antenna(max(time, 0.0))[0]
        middle, half, begin = self.line_of_sight.resting_shadow_sector(antenna)
        rows = np.flatnonzero(np.abs(wrap_angle(azimuth - middle)) <= half)
        behind = np.flatnonzero(self._point.distance >= begin)
        position = np.zeros((len(rows), len(behind), 3))
        position[..., 0] = antenna[0] + np.sin(azimuth)[rows, None] * self._point.distance[behind]
        position[..., 1] = antenna[1] + np.cos(azimuth)[rows, None] * self._point.distance[behind]
        occluded = self.line_of_sight.occluded(position.reshape(-1, 3), antenna, time, movers=False)
        visible[np.ix_(rows, behind)] &= ~occluded.reshape(position.shape[:2])
        return np.where(visible, factor, 0.0).astype(np.float32)
