"""The sea around the antenna as cells of range: at which grazing angle, how far, seen or hidden by what stands before it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.azimuth_rows import BLOCK, AzimuthRowCache, StaticAzimuthRows
from radar_service.clutter.sea import wind_factor
from radar_service.frames import wrap_angle
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene

Floats = NDArray[np.float64]
Levels = NDArray[np.float32]

FINE_CELL, COARSE_CELL = 10.0, 40.0  # m; the second for a moving antenna, which looks anew at every revolution


class SeaPlace(NamedTuple):
    """Where the sphere of a slant range meets the sea, arrays of one shape: ground distance [m], elevation of the antenna's
    ray and grazing angle at the sea [rad], both 0 and the distance 0 where the range does not reach down to the sea."""

    distance: Floats
    elevation: Floats
    grazing: Floats


def sea_place(distance: Floats, antenna_height: float, earth_radius: float) -> SeaPlace:
    """The sea z = -d^2 / (2 ae) - height at slant ranges of any shape [m]; grazing is negative past the horizon.

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
    return SeaPlace(np.where(reaches, ground, 0.0), np.where(reaches, -dip, 0.0), np.where(reaches, grazing, 0.0))


class SeaCells:
    """How much the sea in each direction sends back: 0 where it is hidden or where there is land, else `wind_factor`.

    Rows divide the turn evenly, row 0 looks north. For an antenna at rest all rows are looked at once; a moving one looks
    at each row when the beam comes to it, once a revolution. What moves hides no sea.
    """

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene, rows: int, reach: float) -> None:
        """rows: per turn; reach: slant range [m] to which the cells go."""
        self.scene, self.line_of_sight = scene, line_of_sight
        rests = scene.own_ship.at_rest
        step = scene.radar.range_step
        self.bins = max(1, round((FINE_CELL if rests else COARSE_CELL) / step))  # range bins per cell
        self.count = int(np.ceil(reach / (step * self.bins) - 1e-9))
        middle = (np.arange(self.count, dtype=np.float64) + 0.5) * step * self.bins
        self._place = sea_place(middle, scene.radar.height, line_of_sight.earth_radius)
        self.turn = rows
        self.rows = StaticAzimuthRows(self._all_around()) if rests else AzimuthRowCache(rows, self._looked_at)

    def _all_around(self) -> Levels:
        """Levels (rows, cells) of the whole turn, for an antenna at rest."""
        return np.concatenate([self._looked_at(0, j, min(j + BLOCK, self.turn)) for j in range(0, self.turn, BLOCK)])

    def _looked_at(self, scan: int, start: int, stop: int) -> Levels:
        """Levels (stop - start, cells) of some rows as the antenna finds them when it passes the middle one."""
        azimuth = np.arange(start, stop, dtype=np.float64) * (2.0 * np.pi / self.turn)
        radar, wind_from = self.scene.radar, self.scene.environment.wind_from
        factor = wind_factor((azimuth - wind_from)[:, None], self._place.grazing, radar.wavelength)
        seen = np.repeat(self._place.grazing[None] > 0, len(azimuth), axis=0)
        time = (scan + 0.5 * (start + stop) / self.turn) * radar.rotation_period
        antenna = self.scene.antenna(max(time, 0.0))[0]
        middle, half, begin = self.line_of_sight.resting_shadow_sector(antenna)
        rows = np.flatnonzero(np.abs(wrap_angle(azimuth - middle)) <= half)
        behind = np.flatnonzero(self._place.distance >= begin)
        places = np.zeros((len(rows), len(behind), 3))
        places[..., 0] = antenna[0] + np.sin(azimuth)[rows, None] * self._place.distance[behind]
        places[..., 1] = antenna[1] + np.cos(azimuth)[rows, None] * self._place.distance[behind]
        hidden = self.line_of_sight.occluded(places.reshape(-1, 3), antenna, time, movers=False)
        seen[np.ix_(rows, behind)] &= ~hidden.reshape(places.shape[:2])
        return np.where(seen, factor, 0.0).astype(np.float32)
