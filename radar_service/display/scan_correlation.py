"""Scan-to-scan correlation: how much power the scan before had around the place of each cell.

An echo that stays has it there again; a sea spike has not. The scan before is kept as maxima over short intervals of range.
An interval is as long as a target moves along the beam in one scan at SPEED; a cell is compared with the interval of its place
and one to each side. Own ship's motion between the scans is taken out, so places are over ground.
"""

import math

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats, Singles
from radar_service.radar import Radar
from radar_service.records import SpokeBlock

SPEED = 15.0  # m/s along the beam, up to which any target is kept: 29 kn; a longer gate would keep more spikes
NO_SPOKE = -(2**62)  # before all numbers: a scan before the first spoke they are negative
SCANS = 3  # in memory: places up to half a turn to either side of the spoke a scan ago, and the interval itself


class ScanMemory:
    """The maxima of the newest spokes of one radar.

    radar: its azimuths and rate of rotation; distance: ranges (N,) of its cells [m]; step: between them [m].
    """

    def __init__(self, radar: Radar, distance: Floats, step: float) -> None:
        self._azimuths, self._azimuth_step = radar.azimuths, radar.azimuth_step
        self._distance, self._near_edge = distance.astype(np.float32), float(distance[0]) - 0.5 * step
        self._interval = max(1, math.ceil(SPEED * radar.rotation_period / step))  # cells
        self._length = self._interval * step
        rows = SCANS * radar.azimuths
        self._power = np.zeros((rows, -(-len(distance) // self._interval)), dtype=np.float32)
        self._position = np.zeros((rows, 2))
        self._number = np.full(rows, NO_SPOKE)  # of the spoke in each row

    def take(self, block: SpokeBlock) -> Singles:
        """Keeps the spokes of a block; returns the maximum power (K, N) [W] around the place of each cell a scan ago.

        It is inf where that is not known: in the first scan, where spokes are missing, and beyond the last cell.
        """
        self._keep(block)
        number = block.first + np.arange(len(block)) - self._azimuths
        row = number % len(self._number)
        moved = np.nan_to_num(block.position - self._position[row])  # a position that is not reported counts as kept
        known = self._number[row] == number
        if np.any(moved[known]):
            power = self._over_ground(block.azimuth, number, moved)
        else:
            power = np.repeat(self._power[row], self._interval, axis=1)[:, : len(self._distance)]
        power[~known] = np.inf
        return power

    def _keep(self, block: SpokeBlock) -> None:
        """Keeps the spokes of a block in place of those SCANS scans before them."""
        number = block.first + np.arange(len(block))
        row = number % len(self._number)
        maxima = np.maximum.reduceat(block.power, np.arange(0, block.power.shape[1], self._interval), axis=1)
        self._power[row], self._position[row], self._number[row] = _with_neighbours(maxima), block.position, number

    def _over_ground(self, azimuth: Floats, number: NDArray[np.intp], moved: Floats) -> Singles:
        """The maxima (K, N) where the cells of spokes at `azimuth` (K,) were before own ship had `moved` (K, 2) [m]."""
        along = (moved[:, 0] * np.sin(azimuth) + moved[:, 1] * np.cos(azimuth)).astype(np.float32)[:, None]
        across = (moved[:, 0] * np.cos(azimuth) - moved[:, 1] * np.sin(azimuth)).astype(np.float32)[:, None]  # to the right
        ahead = self._distance + along
        at = np.floor((np.hypot(ahead, across) - self._near_edge) / self._length).astype(np.intp)
        turned = np.rint(np.arctan2(across, ahead) / self._azimuth_step).astype(np.intp)  # in spokes, clockwise
        spoke = number[:, None] + turned
        row, intervals = spoke % len(self._number), self._power.shape[1]
        known = (self._number[row] == spoke) & (at >= 0) & (at < intervals)
        return np.where(known, self._power[row, np.clip(at, 0, intervals - 1)], np.float32(np.inf))


def _with_neighbours(maxima: Singles) -> Singles:
    """The maximum (K, B) of each block and the one to each side."""
    wide = maxima.copy()
    wide[:, 1:] = np.maximum(wide[:, 1:], maxima[:, :-1])
    wide[:, :-1] = np.maximum(wide[:, :-1], maxima[:, 1:])
    return wide


def excess_db(power: Singles, earlier: Singles) -> Singles:
    """By how much cells (K, N) [W] exceed what was `earlier` there [W]; 0 where they do not, inf where nothing was [dB]."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.fmax(power / earlier, np.float32(1.0))  # 0 over 0 is no excess
    excess: Singles = np.float32(10.0) * np.log10(ratio)
    return excess
