"""Sea clutter of a scene: its mean power in range and direction, and the texture of its waves.

Where waves move ships, a face of the sea that rises outward is brighter (tilt): crests show as rows, and travel with the waves.
"""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from radar_service.numerics import Complexes, Floats, Gain, Indices, Singles
from radar_service.propagation import elevation_gain
from radar_service.stages.clutter.azimuth_rows import AzimuthRowCache, BeamWeights, beam_weights, weight_rows
from radar_service.stages.clutter.effect import TEXTURE_SHAPE
from radar_service.stages.clutter.resolution_cell import TWO_WAY_EXTENT, ResolutionCell, two_way_gain, unit_power
from radar_service.stages.clutter.sea import (
    mean_sigma0,
    peak_wave_period,
    peak_wave_speed,
    swell_factor,
    texture_length,
    texture_shape,
)
from radar_service.stages.clutter.sea_cells import SeaCells, sea_point
from radar_service.stages.clutter.texture import TextureLaw, TextureTable, gaussian_correlation
from radar_service.stages.clutter.texture_rows import TextureGrid, TextureRows, outward_units
from radar_service.trace import OcclusionScene
from radar_service.world import Scene, Waves, drawn_waves

RUN = 32  # columns whose phases are those of their first one and of the place in the run
BEARINGS, DISTANCES = 180, 24  # at which the variance of the beam's sum is known; it is linear between them
TEXTURE_BLOCK = 64  # rows of texture computed together
COLUMN = 0.25, 0.5  # of the shortest 1/e length along range: the length of a column of texture, and its maximum where the
# radar cannot resolve it. A column of half of it lengthens the correlation by 4 %
PHASES = 8  # of the beam between rows, over which the overlap of its weights is averaged


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
        phase = self._seen.waves.phases(grid.antenna(time)[:, :2], time)
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


def sea_power(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Mean received power [W] of the sea at slant ranges (N,) [m], averaged over the wind's direction.

    The radar equation with sigma = sigma0 x area of the cell, with gas and rain loss. Measured sigma0 includes multipath.
    """
    radar, environment = scene.radar, scene.environment
    point = sea_point(distance, radar.height, earth_radius)
    sigma0 = mean_sigma0(point.grazing, radar.frequency, environment.sea_state, radar.polarization)
    gain = elevation_gain(radar, point.elevation) ** 2
    return sigma0 * cell.area(distance) * gain * unit_power(scene, distance)


@dataclass(frozen=True)
class Sea:
    """The sea's part of the clutter.

    mean: (cells, bins per cell) root of the mean power over directions [sqrt(W)].
    cells: direction factors and shadows.
    beam: weights of the two-way power on the cells' rows.
    texture: Gaussian rows from which the texture is made, in columns of `column_bins` bins.
    texture_beam: weights of the beam on these rows.
    table: the amplitude factor of the texture from a Gaussian, by column.
    column_bins: a divisor of the bins per cell.
    """

    mean: Singles
    cells: SeaCells
    beam: BeamWeights
    texture: AzimuthRowCache
    texture_beam: BeamWeights
    table: TextureTable
    column_bins: int

    @cached_property
    def max_power(self) -> Singles:
        """Maximum mean power (cells,) [W] in each cell."""
        return np.asarray(self.mean.max(axis=1) ** 2)

    def bins_above(self, level: Singles, floor: float) -> int:
        """Number of bins up to the last at which a level of (K, cells) raises the mean power above `floor` [W]."""
        above = np.flatnonzero(level.max(axis=0) * self.max_power > floor)
        return (int(above[-1]) + 1) * self.mean.shape[1] if len(above) else 0

    def level(self, number: Indices) -> Singles:
        """Factor (K, cells) on the mean power in the beam, at azimuths (K,) numbered from the start."""
        first, stop, weights = self.beam.at(number)
        return weight_rows(weights, self.cells.rows.span(first, stop))

    def amplitude(self, number: Indices, level: Singles, columns: int) -> Singles:
        """Root of the local mean power (K, columns) [sqrt(W)], with texture, at azimuths (K,) for their levels (K, cells)."""
        cells, bins = -(-columns // self.mean.shape[1]), self.mean.shape[1]
        first, stop, weights = self.texture_beam.at(number)
        rows = self.texture.span(first, stop)[:, : cells * bins // self.column_bins]
        root = self.table.roots(weight_rows(weights, rows), number).reshape(len(level), cells, -1)
        root *= np.sqrt(level[:, :cells, None])
        amplitude = np.empty((len(level), cells, bins), dtype=np.float32)
        for i in range(self.column_bins):
            part = slice(i, None, self.column_bins)
            np.multiply(root, self.mean[:cells, part], out=amplitude[..., part])
        return amplitude.reshape(len(level), -1)[:, :columns]


def prepare_sea(
    scene: Scene,
    line_of_sight: OcclusionScene,
    power: Floats,
    cell: ResolutionCell,
    columns: int,
    rows_per_scan: int,
    extent: float,
    seed: int,
) -> Sea:
    """The sea of a scene.

    power: (n,) mean power over directions [W], from bin 0.
    columns, rows_per_scan: of the speckle that the sea modulates; columns are n or more.
    extent: beyond this offset from boresight the beam is cut [rad].
    """
    radar, step = scene.radar, scene.radar.range_step
    middle = (np.arange(columns, dtype=np.float64) + 0.5) * step
    seaway = scene.environment.seaway
    waves = None if seaway is None else SeenWaves(drawn_waves(seaway, scene.environment.stream), cell.length)
    stretch = 1.0 if waves else _stretch(float(np.median(_shape(scene, middle, cell, line_of_sight.earth_radius))))
    law = _texture_law(scene, cell, stretch)
    shortest = law.across if waves is None else 2.0 / float(np.linalg.norm(waves.waves.wavenumber, axis=1).max())
    column_bins = _column_bins(float(np.hypot(shortest, law.cell)), cell.length, step)
    cells = SeaCells(scene, line_of_sight, min(radar.azimuths, 2 * rows_per_scan), columns * step, column_bins)
    total = cells.count * cells.bins
    mean = np.pad(np.sqrt(power), (0, total - len(power))).astype(np.float32).reshape(-1, cells.bins)
    distance = (np.arange(total // column_bins, dtype=np.float64) + 0.5) * step * column_bins
    ground = sea_point(distance, radar.height, line_of_sight.earth_radius).distance
    grid = _texture_grid(scene, ground, rows_per_scan, step * column_bins)
    gain, reach = partial(two_way_gain, radar, stretch=stretch), stretch * TWO_WAY_EXTENT * cell.width
    rows = (
        WaveRows(waves, grid, _row_weights(rows_per_scan, gain, reach))
        if waves
        else TextureRows(law, grid, _overlap(rows_per_scan, gain, reach), seed)
    )
    return Sea(
        mean,
        cells,
        BeamWeights(radar.azimuths, cells.rows.rows_per_scan, partial(two_way_gain, radar), extent, order=1),
        AzimuthRowCache(rows_per_scan, rows.make, TEXTURE_BLOCK, scene.own_revision),
        BeamWeights(radar.azimuths, rows_per_scan, gain, reach, order=2),
        TextureTable(_shape(scene, distance, cell, line_of_sight.earth_radius), _shape_factors(scene)),
        column_bins,
    )


def _shape(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Shape nu of the texture (N,): the scene's, or the published one for grazing angle and cell."""
    requested = scene.environment.effect_keys[TEXTURE_SHAPE]
    if requested is not None:
        return np.full(len(distance), requested)
    grazing = sea_point(distance, scene.radar.height, earth_radius).grazing
    return texture_shape(grazing, cell.area(distance), scene.radar.polarization)


def _shape_factors(scene: Scene) -> Floats | None:
    """Factors (azimuths,) of waves on the published shape; None without waves, or with the scene's shape."""
    seaway, radar = scene.environment.seaway, scene.radar
    if seaway is None or scene.environment.effect_keys[TEXTURE_SHAPE] is not None:
        return None
    return swell_factor(np.arange(radar.azimuths, dtype=np.float64) * radar.azimuth_step - seaway.towards)


def _column_bins(length: float, cell_length: float, step: float) -> int:
    """Bins in a column of texture of this 1/e length [m]; cell_length: of the resolution cell [m], step: of a bin [m]."""
    usual, maximum = COLUMN
    return max(1, round(min(maximum * length, max(usual * length, cell_length)) / step))


def _stretch(shape: float) -> float:
    """Length over which a Gaussian falls to 1/e where its texture of shape nu does so over 1."""
    return 1.0 / float(np.sqrt(-np.log(gaussian_correlation(shape, float(np.exp(-1.0))))))


def _overlap(rows_per_scan: int, gain: Gain, extent: float) -> Floats:
    """Sum of products of the beam's weights on rows -M to M apart (2 M + 1,), 1 in the middle."""
    azimuth = np.arange(PHASES) / PHASES * (2.0 * np.pi / rows_per_scan)
    _, _, weights = beam_weights(azimuth, rows_per_scan, gain, extent)
    energy = np.sum(weights**2, axis=1)
    if not energy.all():  # a beam far narrower than a row may miss them all; then it is as wide as one
        weights = np.where(energy[:, None] > 0.0, weights, np.arange(weights.shape[1]) == weights.shape[1] // 2)
    products = np.mean([np.correlate(each, each, "full") / np.sum(each**2) for each in weights], axis=0)
    return np.asarray(products)


def _row_weights(rows_per_scan: int, gain: Gain, extent: float) -> Floats:
    """The beam's weights (2 M + 1,) on rows about one on boresight; their squares add up to 1."""
    _, _, (weights,) = beam_weights(np.zeros(1), rows_per_scan, gain, extent)
    return np.asarray(weights / np.sqrt(np.sum(weights**2)))


def _texture_law(scene: Scene, cell: ResolutionCell, stretch: float) -> TextureLaw:
    """Correlation of the Gaussian field, `stretch` times as long as that of the texture.

    A pulse of the power exp(-pi r^2 / length^2) gives a white field the correlation exp(-pi r^2 / (2 length^2)).
    """
    along, across = texture_length(np.array([0.0, 0.5 * np.pi]), scene.environment.sea_state) * stretch
    length = stretch * cell.length * np.sqrt(2.0 / np.pi)
    return TextureLaw(float(along), float(across), scene.environment.wind_from, float(length))


def _texture_grid(scene: Scene, distance: Floats, rows_per_scan: int, step: float) -> TextureGrid:
    """Rows of texture in columns `step` [m] long, at ground distances (columns,) [m]."""
    environment = scene.environment
    downwind = -np.array([np.sin(environment.wind_from), np.cos(environment.wind_from)])
    waves, lifetime = downwind * peak_wave_speed(environment.sea_state), peak_wave_period(environment.sea_state)
    return TextureGrid(rows_per_scan, scene.radar.rotation_period, step, distance, lifetime, waves, scene.antenna)
