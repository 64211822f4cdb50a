"""The sea around the antenna as cells in range and azimuth: grazing angle, direction factor, and shadows of bodies."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Flags, Floats, Indices, ResultCache, Singles, wrap_angle
from radar_service.stages.clutter.azimuth_rows import BLOCK, AzimuthRowCache
from radar_service.stages.clutter.sea import wind_factor
from radar_service.trace import OcclusionScene, ShadowSectors
from radar_service.world import Scene

KEPT_SCANS = 3  # whose shadow sweeps are kept
SWEEP_STEP = 2.0  # s between the poses from which a moving body's sweep is taken
SWEEP_MARGIN = 0.02  # rad each side, for turns in between
SWEEP_NEAR = 200.0  # m, at 100 m/s: what begins nearer to the antenna may sweep all round in between
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


class ShadowSweeps(NamedTuple):
    """Azimuths that bodies may shadow during one scan: first all that rest together, then each that moves.

    low: (N,) first azimuth [rad].
    width: (N,) [rad]; negative for no azimuth.
    """

    low: Floats
    width: Floats


class SeaCells:
    """Factor on the sea's mean power in each cell: 0 in shadow or on land, else `wind_factor`.

    Rows divide the circle evenly; row 0 points north. Shadows of bodies at rest are computed once for an antenna at rest. All
    others are computed when the beam points at a row, once per scan.
    """

    def __init__(
        self, scene: Scene, line_of_sight: OcclusionScene, rows_per_scan: int, max_range: float, column_bins: int = 1
    ) -> None:
        """max_range: slant range [m] up to which there are cells; column_bins: a divisor of the bins per cell."""
        self.scene, self.line_of_sight = scene, line_of_sight
        self._rests = scene.own_ship.at_rest
        step = scene.radar.range_step
        size = FINE_CELL if self._rests else COARSE_CELL
        self.bins = column_bins * max(1, round(size / (step * column_bins)))  # range bins per cell
        self.count = int(np.ceil(max_range / (step * self.bins) - 1e-9))
        middle = (np.arange(self.count, dtype=np.float64) + 0.5) * step * self.bins
        self._point = sea_point(middle, scene.radar.height, line_of_sight.earth_radius)
        self.rows_per_scan = rows_per_scan
        self._azimuth = np.arange(rows_per_scan, dtype=np.float64) * (2.0 * np.pi / rows_per_scan)
        self._outward = np.stack([np.sin(self._azimuth), np.cos(self._azimuth)], axis=1)
        self._sweeps: ResultCache[int, ShadowSweeps] = ResultCache(KEPT_SCANS, scene.revision)
        self._open = self._open_sea()
        if self._rests:
            for start in range(0, rows_per_scan, BLOCK):
                self._shadow_by_rest(self._open[start : start + BLOCK], start, self._antenna(0.0))
        self.rows = AzimuthRowCache(rows_per_scan, self._computed, revision=scene.revision)

    def _open_sea(self) -> Singles:
        """Factors (rows, cells) of the full circle without shadows."""
        factor = np.empty((self.rows_per_scan, self.count), dtype=np.float32)
        for start in range(0, self.rows_per_scan, BLOCK):
            off_wind = self._azimuth[start : start + BLOCK] - self.scene.environment.wind_from
            factor[start : start + BLOCK] = wind_factor(off_wind[:, None], self._point.grazing, self.scene.radar.wavelength)
        factor[:, self._point.grazing <= 0.0] = 0.0
        return factor

    def _computed(self, scan: int, start: int, stop: int) -> Singles:
        """Factors (stop - start, cells) of some rows at the time when the beam passes the middle one."""
        level = self._open[start:stop].copy()
        sweeps = self._sweeps.get(scan, lambda: self._shadow_sweeps(scan))
        crossing = self._crossing(sweeps, start, stop)
        if not len(crossing):
            return level
        time = self.scene.radar.time_of_turns(scan + 0.5 * (start + stop) / self.rows_per_scan)
        antenna = self._antenna(time)
        if crossing[0] == 0:
            self._shadow_by_rest(level, start, antenna)
        moving = crossing[crossing > 0] - 1
        sectors = self.line_of_sight.moving_shadow_sectors(antenna, time).of(moving)
        row_times = self.scene.radar.time_of_turns(scan + np.arange(start, stop) / self.rows_per_scan)
        for first, last in self.line_of_sight.presences.spans(row_times) if len(moving) else []:
            occluded = partial(
                self.line_of_sight.as_of(float(row_times[first])).occluded_by_moving, antenna=antenna, time=time
            )
            self._shadow(level[first:last], start + first, antenna, sectors, occluded)
        return level

    def _shadow_by_rest(self, level: Singles, start: int, antenna: Floats) -> None:
        occluded = partial(self.line_of_sight.occluded_by_resting, antenna=antenna)
        self._shadow(level, start, antenna, self.line_of_sight.resting_shadow_sector(antenna), occluded)

    def _shadow(
        self, level: Singles, start: int, antenna: Floats, sectors: ShadowSectors, occluded: Callable[[Floats], Flags]
    ) -> None:
        """Sets cells of `level` (rows from `start` on, cells) in sectors (N,) to 0 whose positions (W, 3) are occluded."""
        azimuth = self._azimuth[start : start + len(level), None]
        rows = np.flatnonzero((np.abs(wrap_angle(azimuth - sectors.middle)) <= sectors.half).any(axis=1))
        behind = np.flatnonzero((self._point.distance >= sectors.begin.min()) & (self._point.grazing > 0.0))
        if not len(rows) or not len(behind):
            return
        position = np.zeros((len(rows), len(behind), 3))
        position[..., :2] = antenna[:2] + self._outward[start + rows, None] * self._point.distance[behind, None]
        level[np.ix_(rows, behind)] *= ~occluded(position.reshape(-1, 3)).reshape(position.shape[:2])

    def _shadow_sweeps(self, scan: int) -> ShadowSweeps:
        """The sweeps of a scan, from sectors every SWEEP_STEP or less. From a straight course the edges of a sector turn one way,
        so those at both ends bound it in between."""
        radar = self.scene.radar
        begin, end = radar.time_of_turns(float(scan)), radar.time_of_turns(scan + 1.0)
        times = np.linspace(begin, end, int(np.ceil(radar.rotation_period / SWEEP_STEP)) + 1).tolist()
        sectors = []
        for time, antenna in [(time, self._antenna(time)) for time in times]:
            resting = self.line_of_sight.resting_shadow_sector(antenna)
            sectors.append(np.concatenate([resting, self.line_of_sight.moving_shadow_sectors(antenna, time)], axis=1))
        middle, half, start = np.stack(sectors, axis=1)
        middle = middle[0] + wrap_angle(middle - middle[0])
        low, high = (middle - half).min(axis=0) - SWEEP_MARGIN, (middle + half).max(axis=0) + SWEEP_MARGIN
        width = np.where((start < SWEEP_NEAR).any(axis=0), 2.0 * np.pi, high - low)
        if self._rests or np.isinf(start[0, 0]):  # applied all round already, or there is nothing
            width[0] = -1.0
        return ShadowSweeps(low, width)

    def _crossing(self, sweeps: ShadowSweeps, start: int, stop: int) -> Indices:
        """Numbers of the sweeps in which any of the rows start to stop (exclusive) lie, rising."""
        inside = (self._azimuth[start:stop] - sweeps.low[:, None]) % (2.0 * np.pi) <= sweeps.width[:, None]
        return np.flatnonzero(inside.any(axis=1))

    def _antenna(self, time: float) -> Floats:
        """Position (3,) on the map [m], at the start for earlier times."""
        return np.asarray(self.scene.antenna(max(time, 0.0))[0])
