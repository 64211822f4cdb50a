"""Azimuth rows of the texture of a sea whose waves move ships: the slope of the sea along the line of sight.

A face that rises outward is brighter than one that falls (tilt). So crests show as rows, travel with the waves, and change with
them in seconds; a ship that rides a crest stands in the row of that crest.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Complexes, Floats, Indices, Singles
from radar_service.stages.clutter.texture_rows import TextureGrid, outward_units
from radar_service.world.seaway import Waves

RUN = 32  # columns whose phases are those of their first one and of the place in the run
BEARINGS, DISTANCES = 180, 24  # at which the variance of the beam's sum is known; it is linear between them


@dataclass(frozen=True)
class SeenWaves:
    """Waves as the rows of a radar see them. waves: N of them. cell: length of the resolution cell [m]."""

    waves: Waves
    cell: float

    def slopes(self, outward: Floats) -> tuple[Floats, Floats]:
        """Wavenumber along lines (J, N) [rad/m] of unit vectors (J, 2), and the amplitude of the slope (J, N) for unit variance.

        A pulse of the power exp(-pi r^2 / cell^2) averages over the cell.
        """
        along = outward @ self.waves.wavenumber.T
        slope = self.waves.amplitude * along * np.exp(-((self.cell * along) ** 2) / (4.0 * np.pi))
        return along, slope / np.sqrt(0.5 * np.sum(slope**2, axis=1, keepdims=True))


class WaveRows:
    """Real Gaussian rows, of the sum of many waves, whose sum, weighted by the beam, has unit variance."""

    def __init__(self, seen: SeenWaves, grid: TextureGrid, beam: Floats) -> None:
        """beam: weights (2 M + 1,) of rows -M to M from boresight, whose squares add up to 1."""
        self._seen, self._grid = seen, grid
        self._outward = outward_units(grid.rows_per_scan)
        self._table = self._deviations(beam)

    def make(self, scan: int, start: int, stop: int) -> Singles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns)."""
        grid, row = self._grid, np.arange(start, stop)
        time: Floats = np.maximum((scan + row / grid.rows_per_scan) * grid.rotation_period, 0.0)
        along, slope = self._seen.slopes(self._outward[row])
        phase = self._seen.waves.phases(grid.antenna(time), time)
        return (_sums(along, slope, phase, grid.step, len(grid.distance)) / self._deviation(row)).astype(np.float32)

    def _deviation(self, row: Indices) -> Floats:
        """Standard deviation (J, columns) of the beam's sum of rows."""
        nodes, bearings = self._table.shape
        place = row * (bearings / self._grid.rows_per_scan)
        low = place.astype(np.int64)
        share = (place - low)[:, None]
        at = self._table.T
        by_distance = (1.0 - share) * at[low % bearings] + share * at[(low + 1) % bearings]
        column = np.linspace(0.0, nodes - 1.0, len(self._grid.distance))
        near = np.minimum(column.astype(np.int64), nodes - 2)
        part = column - near
        return np.asarray(by_distance[:, near] * (1.0 - part) + by_distance[:, near + 1] * part)

    def _deviations(self, beam: Floats) -> Floats:
        """The same at the nodes of the table (DISTANCES, BEARINGS)."""
        grid, reach = self._grid, len(beam) // 2
        bearing = np.arange(BEARINGS) * (2.0 * np.pi / BEARINGS)
        distance = np.linspace(0.5, len(grid.distance) - 0.5, DISTANCES) * grid.step
        total: Complexes = np.zeros((DISTANCES, BEARINGS, len(self._seen.waves.amplitude)), dtype=np.complex128)
        for m, weight in enumerate(beam, start=-reach):
            angle = bearing + m * (2.0 * np.pi / grid.rows_per_scan)
            along, slope = self._seen.slopes(np.stack([np.sin(angle), np.cos(angle)], axis=1))
            total += weight * slope * np.exp(1j * along * distance[:, None, None])
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(total) ** 2, axis=2)))


def _sums(along: Floats, slope: Floats, phase: Floats, step: float, columns: int) -> Singles:
    """Slopes (J, columns), the sum of slope x -sin(along r + phase) of waves (J, N), at r = (column + 1/2) step."""
    run = (np.arange(RUN) + 0.5) * step
    first = np.arange(0, columns, RUN) * step
    turn, within = _reduced(phase[:, None] + first[:, None] * along[:, None]), _reduced(run[:, None] * along[:, None])
    left = np.concatenate([np.sin(turn), np.cos(turn)], axis=2) * np.tile(-slope.astype(np.float32), 2)[:, None]
    right = np.concatenate([np.cos(within), np.sin(within)], axis=2)
    return np.asarray((left @ right.swapaxes(1, 2)).reshape(len(along), -1)[:, :columns])


def _reduced(phase: Floats) -> Singles:
    """The same phases in [-pi, pi] [rad]: of these single precision takes the sine fast."""
    return (phase - 2.0 * np.pi * np.rint(phase / (2.0 * np.pi))).astype(np.float32)
