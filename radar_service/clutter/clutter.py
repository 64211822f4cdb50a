"""Clutter of sea and rain, added to compressed profiles.

Speckle that has passed the beam and the pulse is multiplied, cell by cell, by the root of the sea's local mean power
(texture x mean) plus the rain's. Conditional on the texture both are complex Gaussian with the same correlations, so one
speckle serves both; it is held while the beam passes and drawn anew each revolution.
"""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.azimuth_rows import AzimuthRowCache, BeamWeights, weight_rows
from radar_service.clutter.rain import beam_height, reflectivity
from radar_service.clutter.sea import (
    mean_sigma0,
    peak_wave_period,
    peak_wave_speed,
    texture_length,
    texture_shape,
    wind_factor,
)  # fmt: skip
from radar_service.clutter.sea_cells import SeaCells, sea_place
from radar_service.clutter.texture import SpeckleRows, TextureMotion, TextureRows, TextureTable, gaussian_correlation
from radar_service.propagation.attenuation import attenuation_amplitude, rain_db_per_km
from radar_service.propagation.radar_equation import elevation_gain, received_amplitude
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import Compression, receiver_noise_power
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Gain

Floats = NDArray[np.float64]
Reals = NDArray[np.float32]
Profiles = NDArray[np.complex64]

MATTERS = 10.0**-1.5  # of the noise: clutter is left out where it would add less than 0.14 dB
ROWS_PER_BEAM = 1.506  # rows in the width of two-way power: 2 in the half-power width of a sinc^2 beam, above its band
REACH = 4.0  # two-way widths each side: for a sinc^2 beam to its fourth null, beyond which lies 1e-4 of the power


@dataclass(frozen=True)
class ResolutionCell:
    """What a radar's cell holds. width: integral of the two-way azimuth pattern G^2 [rad]; length: integral over range of
    the compressed pulse's power [m], for a unit peak."""

    width: float
    length: float

    def area(self, distance: Floats) -> Floats:
        """Area of sea [m^2] in the cell at a slant range [m]: d dd = R dR, so R takes the place of the ground distance."""
        return distance * self.width * self.length


def resolution_cell(gain: Gain, compression: Compression, range_step: float) -> ResolutionCell:
    """The cell of a beam and a pulse."""
    offset = (np.arange(2**16, dtype=np.float64) + 0.5) * (2.0 * np.pi / 2**16) - np.pi
    width = float(np.mean(gain(offset) ** 2) * 2.0 * np.pi)
    return ResolutionCell(width, float(np.mean(pulse_power(compression))) * range_step)  # Parseval


def pulse_power(compression: Compression) -> Floats:
    """|spectrum|^2 (size,) in FFT order of the sampled compressed pulse of unit peak."""
    far = np.array([compression.size // 2])  # past the deaf time of a one-antenna radar
    return np.asarray(np.abs(compression.spectrum(_unit_echoes(compression, far))[0]) ** 2)


def _unit_echoes(compression: Compression, column: NDArray[np.int64]) -> Profiles:
    """Rows (E, size) with one unit echo each, laid at a column."""
    gridded = np.zeros((len(column), compression.size), dtype=np.complex64)
    first, weights = compression.kernel.weights(column.astype(np.float64))
    for row, start in enumerate(first):
        gridded[row, (start + np.arange(weights.shape[1])) % compression.size] = weights[row]
    return gridded


def heard_share(scene: Scene, compression: Compression) -> Floats:
    """Share (bins,) of an echo's energy that is left where a one-antenna radar is deaf while it transmits, else 1."""
    radar = scene.radar
    if not radar.eclipsing:
        return np.ones(radar.bins)
    deaf = min(radar.bins, int(np.ceil(radar.pulse * radar.sample_rate)) + 1)  # bins within c T / 2
    column = np.unique(np.linspace(0, deaf - 1, 64).astype(np.int64))
    energy = np.sum(np.abs(compression.profiles(_unit_echoes(compression, column))) ** 2, axis=1) / np.mean(
        pulse_power(compression)
    )
    return np.asarray(np.interp(np.arange(radar.bins), np.append(column, deaf), np.append(energy, 1.0)))


def sea_power(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Mean received power [W] of the sea at slant ranges (N,) [m], averaged over the wind's direction.

    The radar equation with sigma = sigma0 x area of the cell; gas and rain take their share, the sea's mirror is in sigma0.
    """
    radar, environment = scene.radar, scene.environment
    place = sea_place(distance, radar.height, earth_radius)
    sigma0 = mean_sigma0(place.grazing, radar.frequency, environment.sea_state, radar.polarization)
    gain = elevation_gain(radar, place.elevation) ** 2
    return sigma0 * cell.area(distance) * gain * _unit_power(scene, distance)


def rain_power(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Mean received power [W] of rain that falls everywhere, at slant ranges (N,) [m]."""
    radar = scene.radar
    eta = reflectivity(scene.environment.rain_mm_h, radar.wavelength)
    elevation = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2**14 + 1)  # 0.011 degrees: five in the narrowest beam allowed
    height = beam_height(distance, radar.height, earth_radius, elevation, elevation_gain(radar, elevation))
    return eta * cell.area(distance) * distance * height * _unit_power(scene, distance)


def _unit_power(scene: Scene, distance: Floats) -> Floats:
    """Received power [W] of 1 m^2 on boresight at slant ranges (N,) [m], through gas and rain."""
    radar, environment = scene.radar, scene.environment
    rain = rain_db_per_km(environment.rain_mm_h, radar.polarization, radar.frequency)
    return (received_amplitude(radar, distance) * attenuation_amplitude(distance, environment.gas_db_per_km + rain)) ** 2


@dataclass(frozen=True)
class Sea:
    """What the sea adds to speckle. mean: (cells, bins of a cell) root of the mean power over directions [sqrt(W)]."""

    mean: Reals
    cells: SeaCells
    beam: BeamWeights  # over the cells' rows: two-way power
    texture: AzimuthRowCache  # Gaussian
    table: TextureTable

    @cached_property
    def loudest(self) -> Reals:
        """Greatest mean power (cells,) [W] in each cell."""
        return np.asarray(self.mean.max(axis=1) ** 2)

    def reach(self, level: Reals, floor: float) -> int:
        """Bins to which any of the levels (K, cells) lifts the mean power above `floor` [W]."""
        mattering = np.flatnonzero(level.max(axis=0) * self.loudest > floor)
        return (int(mattering[-1]) + 1) * self.mean.shape[1] if len(mattering) else 0

    def level(self, number: NDArray[np.int64]) -> Reals:
        """What the beam sees of the cells (K, cells) from azimuths (K,), a factor on the mean power."""
        first, stop, weights = self.beam.at(number)
        return weight_rows(weights, self.cells.rows.span(first, stop))

    def amplitude(self, level: Reals, columns: int) -> Reals:
        """Root of the mean power (K, columns) [sqrt(W)] for levels (K, cells)."""
        cells = -(-columns // self.mean.shape[1])
        spread = np.sqrt(level[:, :cells, None]) * self.mean[:cells]
        return spread.reshape(len(level), -1)[:, :columns]


@dataclass(frozen=True)
class Clutter:
    """Sea and rain clutter of one radar in one scene, ready to be added to profiles."""

    rain: Reals  # (raining bins,) W
    floor: float  # W; clutter below is left out
    columns: int  # bins of the rows
    beam: BeamWeights  # over the rows of speckle and texture: field
    speckle: AzimuthRowCache
    sea: Sea | None

    def add(self, profiles: Profiles, number: NDArray[np.int64], transmitting: NDArray[np.bool_]) -> None:
        """Adds clutter to profiles (K, bins) [sqrt(W)] of consecutive azimuths (K,) of a scan, counted from the start, to
        those that are `transmitting` (K, 1)."""
        level = None if self.sea is None else self.sea.level(number)
        columns = len(self.rain)
        if self.sea is not None and level is not None:
            columns = min(self.columns, max(columns, self.sea.reach(level, self.floor)))
        if columns == 0:
            return
        first, stop, weights = self.beam.at(number)
        rows = self.speckle.span(first, stop)[:, :columns]
        speckle = weight_rows(weights * transmitting, rows).view(np.complex64)
        speckle *= self._amplitude(level, self.beam.at(number), columns)
        profiles[:, :columns] += speckle

    def _amplitude(self, level: Reals | None, seen: tuple[int, int, Reals], columns: int) -> Reals:
        """Root of the local mean power (K, columns) [sqrt(W)], texture and rain in it."""
        if self.sea is None or level is None:
            return np.sqrt(self.rain[:columns])
        first, stop, weights = seen
        amplitude = self.sea.table.roots(weight_rows(weights, self.sea.texture.span(first, stop)[:, :columns]))
        amplitude *= self.sea.amplitude(level, columns)
        if len(self.rain):
            rain = np.pad(self.rain, (0, columns - len(self.rain)))
            amplitude = np.sqrt(amplitude * amplitude + rain)
        return amplitude


def prepare_clutter(scene: Scene, line_of_sight: OcclusionScene, compression: Compression, seed: int) -> Clutter | None:
    """The clutter of a scene; None where it has neither sea nor rain above the noise."""
    radar, environment = scene.radar, scene.environment
    distance = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step
    cell = resolution_cell(radar.azimuth_gain, compression, radar.range_step)
    radius = line_of_sight.earth_radius
    floor = MATTERS * receiver_noise_power(radar) if environment.noise else 0.0
    heard = heard_share(scene, compression)
    rain = np.zeros(0)
    if environment.rain_mm_h:
        rain = _mattering(rain_power(scene, distance, cell, radius) * heard, floor)
    sea = np.zeros(0)
    if environment.sea_state:
        upwind = float(wind_factor(np.zeros(1), np.zeros(1), radar.wavelength)[0])
        sea = _mattering(sea_power(scene, distance, cell, radius) * heard, floor / upwind)
    columns = max(len(rain), len(sea))
    if columns == 0:
        return None
    turn = min(radar.azimuths, int(np.ceil(2.0 * np.pi / cell.width * ROWS_PER_BEAM)))
    reach = REACH * cell.width
    return Clutter(
        rain.astype(np.float32),
        floor,
        columns,
        BeamWeights(radar.azimuths, turn, radar.azimuth_gain, reach, order=2),
        AzimuthRowCache(turn, SpeckleRows(pulse_power(compression), columns, seed).make),
        _sea_of(scene, line_of_sight, sea, cell, columns, turn, seed) if len(sea) else None,
    )


def _mattering(power: Floats, floor: float) -> Floats:
    """The first bins of power (N,), as far as any is above the floor."""
    above = np.flatnonzero(power > floor)
    return power[: int(above[-1]) + 1] if len(above) else power[:0]


def _sea_of(
    scene: Scene,
    line_of_sight: OcclusionScene,
    power: Floats,
    cell: ResolutionCell,
    columns: int,
    turn: int,
    seed: int,
) -> Sea:
    """The sea of mean power (n,) [W] on speckle of n or more `columns` bins and `turn` rows."""
    radar = scene.radar
    distance = (np.arange(columns, dtype=np.float64) + 0.5) * radar.range_step
    cells = SeaCells(scene, line_of_sight, min(radar.azimuths, 2 * turn), columns * radar.range_step)
    whole = cells.count * cells.bins
    mean = np.pad(np.sqrt(power), (0, whole - len(power))).astype(np.float32).reshape(-1, cells.bins)
    shape = _shape(scene, distance, cell, line_of_sight.earth_radius)
    motion = _texture_motion(scene, turn, float(np.median(shape)))
    texture = AzimuthRowCache(turn, TextureRows(motion, columns, seed).make)
    beam = BeamWeights(radar.azimuths, cells.rows.rows_per_scan, partial(_two_way_gain, radar), REACH * cell.width, order=1)
    return Sea(mean, cells, beam, texture, TextureTable(shape))


def _two_way_gain(radar: Radar, offset: Floats) -> Floats:
    return radar.azimuth_gain(offset) ** 2


def _shape(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Shape nu of the texture (N,): the scene's, or the published one for grazing angle and cell."""
    asked = scene.environment.sea_texture_shape
    if asked is not None:
        return np.full(len(distance), asked)
    grazing = sea_place(distance, scene.radar.height, earth_radius).grazing
    return texture_shape(grazing, cell.area(distance), scene.radar.polarization)


def _texture_motion(scene: Scene, turn: int, shape: float) -> TextureMotion:
    """How the texture of a scene's sea changes; `shape` is the one for which it has its published length."""
    radar, environment = scene.radar, scene.environment
    bearing = np.arange(turn, dtype=np.float64) * (2.0 * np.pi / turn)
    published = texture_length(bearing - environment.wind_from, environment.sea_state)
    length = published / -np.log(gaussian_correlation(shape, float(np.exp(-1.0))))
    drift = partial(_drift, scene, np.stack([np.sin(bearing), np.cos(bearing)], axis=1))
    lifetime = peak_wave_period(environment.sea_state)
    return TextureMotion(turn, radar.rotation_period, lifetime, radar.range_step, length, drift)


def _drift(scene: Scene, outward: Floats, row: NDArray[np.int64], since: Floats, until: Floats) -> Floats:
    """How far the waves have moved along rows (J,) of the turn, seen from the antenna, between instants (J,) [m].

    outward: (turn, 2) unit vectors east, north of all rows.
    """
    environment = scene.environment
    downwind = -np.array([np.sin(environment.wind_from), np.cos(environment.wind_from)])
    moved = downwind * (peak_wave_speed(environment.sea_state) * (until - since))[:, None]
    if not scene.own_ship.at_rest:
        moved -= scene.antenna(until)[:, :2] - scene.antenna(since)[:, :2]
    return np.asarray(np.einsum("ij,ij->i", moved, outward[row]))
