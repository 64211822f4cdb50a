"""Sea clutter of a scene: its mean power in range and direction, and the texture of its waves."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from radar_service.clutter.azimuth_rows import AzimuthRowCache, BeamWeights, weight_rows
from radar_service.clutter.resolution_cell import ResolutionCell, unit_power
from radar_service.clutter.sea import mean_sigma0, peak_wave_period, peak_wave_speed, texture_length, texture_shape
from radar_service.clutter.sea_cells import SeaCells, sea_point
from radar_service.clutter.texture import TextureMotion, TextureRows, TextureTable, gaussian_correlation
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.radar.parameters import Radar
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Floats, Indices, Singles


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
    texture: Gaussian rows from which the texture is made.
    table: the amplitude factor of the texture from a Gaussian.
    """

    mean: Singles
    cells: SeaCells
    beam: BeamWeights
    texture: AzimuthRowCache
    table: TextureTable

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

    def amplitude(self, level: Singles, columns: int) -> Singles:
        """Root of the mean power (K, columns) [sqrt(W)] for levels (K, cells)."""
        cells = -(-columns // self.mean.shape[1])
        amplitude = np.sqrt(level[:, :cells, None]) * self.mean[:cells]
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
    radar = scene.radar
    distance = (np.arange(columns, dtype=np.float64) + 0.5) * radar.range_step
    cells = SeaCells(scene, line_of_sight, min(radar.azimuths, 2 * rows_per_scan), columns * radar.range_step)
    total = cells.count * cells.bins
    mean = np.pad(np.sqrt(power), (0, total - len(power))).astype(np.float32).reshape(-1, cells.bins)
    shape = _shape(scene, distance, cell, line_of_sight.earth_radius)
    motion = _texture_motion(scene, rows_per_scan, float(np.median(shape)))
    texture = AzimuthRowCache(rows_per_scan, TextureRows(motion, columns, seed).make)
    beam = BeamWeights(radar.azimuths, cells.rows.rows_per_scan, partial(_two_way_gain, radar), extent, order=1)
    return Sea(mean, cells, beam, texture, TextureTable(shape))


def _two_way_gain(radar: Radar, offset: Floats) -> Floats:
    return radar.azimuth_gain(offset) ** 2


def _shape(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Shape nu of the texture (N,): the scene's, or the published one for grazing angle and cell."""
    requested = scene.environment.sea_texture_shape
    if requested is not None:
        return np.full(len(distance), requested)
    grazing = sea_point(distance, scene.radar.height, earth_radius).grazing
    return texture_shape(grazing, cell.area(distance), scene.radar.polarization)


def _texture_motion(scene: Scene, rows_per_scan: int, shape: float) -> TextureMotion:
    """How the texture of a scene's sea changes; `shape` is the one for which it has its published length."""
    radar, environment = scene.radar, scene.environment
    bearing = np.arange(rows_per_scan, dtype=np.float64) * (2.0 * np.pi / rows_per_scan)
    published = texture_length(bearing - environment.wind_from, environment.sea_state)
    length = published / -np.log(gaussian_correlation(shape, float(np.exp(-1.0))))
    drift = partial(_drift, scene, np.stack([np.sin(bearing), np.cos(bearing)], axis=1))
    lifetime = peak_wave_period(environment.sea_state)
    return TextureMotion(rows_per_scan, radar.rotation_period, lifetime, radar.range_step, length, drift)


def _drift(scene: Scene, outward: Floats, row: Indices, since: Floats, until: Floats) -> Floats:
    """Outward motion of the waves along rows (J,) relative to the antenna between two times (J,) [m].

    outward: (rows per scan, 2) unit vectors east, north of all rows.
    """
    environment = scene.environment
    downwind = -np.array([np.sin(environment.wind_from), np.cos(environment.wind_from)])
    moved = downwind * (peak_wave_speed(environment.sea_state) * (until - since))[:, None]
    if not scene.own_ship.at_rest:
        moved -= scene.antenna(until)[:, :2] - scene.antenna(since)[:, :2]
    return np.asarray(np.einsum("ij,ij->i", moved, outward[row]))
