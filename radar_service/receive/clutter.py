"""Clutter of sea and rain, added to compressed profiles.

Speckle that has passed the beam and the pulse is multiplied, cell by cell, by the root of the sea's local mean power
(texture x mean) plus the rain's. Conditional on the texture both are complex Gaussian with the same correlations, so one
speckle serves both; it is held while the beam passes and drawn anew each revolution.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.echoes import elevation_gain, received_amplitude
from radar_service.echo.propagation import gas_amplitude, rain_db_per_km
from radar_service.echo.rain_clutter import beam_height, reflectivity
from radar_service.echo.sea_cells import SeaCells, sea_place
from radar_service.echo.sea_clutter import (
    mean_sigma0,
    peak_wave_period,
    peak_wave_speed,
    texture_length,
    texture_shape,
    wind_factor,
)  # fmt: skip
from radar_service.echo.sight import Landscape
from radar_service.echo.turn_rows import Pattern, TurnRows, beam_weights
from radar_service.receive.compression import Compression
from radar_service.receive.texture import SpeckleRows, TextureMotion, TextureRows, TextureTable, gaussian_correlation
from radar_service.scene.world import Scene

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


def resolution_cell(pattern: Pattern, compression: Compression, range_step: float) -> ResolutionCell:
    """The cell of a beam and a pulse."""
    offset = (np.arange(2**16, dtype=np.float64) + 0.5) * (2.0 * np.pi / 2**16) - np.pi
    width = float(np.mean(pattern(offset) ** 2) * 2.0 * np.pi)
    return ResolutionCell(width, float(np.mean(pulse_power(compression))) * range_step)  # Parseval


def pulse_power(compression: Compression) -> Floats:
    """|spectrum|^2 (size,) in FFT order of the sampled compressed pulse of unit peak."""
    far = np.array([compression.size // 2])  # past the deaf time of a one-antenna radar
    return np.asarray(np.abs(compression.spectrum(_unit_echoes(compression, far))[0]) ** 2)


def _unit_echoes(compression: Compression, column: NDArray[np.int64]) -> Profiles:
    """Rows (E, size) with one unit echo each, laid at a column."""
    laid = np.zeros((len(column), compression.size), dtype=np.complex64)
    first, weights = compression.kernel.weights(column.astype(np.float64))
    for row, start in enumerate(first):
        laid[row, (start + np.arange(weights.shape[1])) % compression.size] = weights[row]
    return laid


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


def noise_level(compression: Compression) -> float:
    """Mean power [W] of receiver noise in a sample."""
    return float(2.0 * np.sum(np.square(compression.noise_multiplier, dtype=np.float64)) / compression.size**2)


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
    return (received_amplitude(radar, distance) * gas_amplitude(distance, environment.gas_db_per_km + rain)) ** 2


@dataclass
class Clutter:
    """Sea and rain clutter of one radar in one scene, ready to be added to profiles."""

    sea: Reals  # (columns,) W, mean over directions
    rain: Reals  # (columns,)
    floor: float  # W; clutter below is left out
    pattern: Pattern
    azimuth_step: float
    reach: float  # rad, of the beam
    speckle: TurnRows
    texture: TurnRows | None  # with the sea: Gaussian rows
    table: TextureTable | None
    cells: SeaCells | None

    def add(self, profiles: Profiles, number: NDArray[np.int64], transmitting: NDArray[np.bool_]) -> None:
        """Adds clutter to profiles (K, bins) [sqrt(W)] of consecutive azimuths (K,), counted from the start, to those that
        are `transmitting` (K, 1)."""
        azimuth = number.astype(np.float64) * self.azimuth_step
        power = self._mean(azimuth)
        columns = power.shape[1]
        if columns == 0:
            return
        first, stop, weight = beam_weights(azimuth, self.speckle.turn, self.pattern, self.reach)
        weight32 = (weight / np.sqrt(np.sum(weight**2, axis=1))[:, None]).astype(np.float32)
        rows = self.speckle.span(first, stop)[:, :columns].view(np.float32)
        speckle = (weight32 @ rows).view(np.complex64)
        if self.texture is not None and self.table is not None:
            gaussian = weight32 @ self.texture.span(first, stop)[:, :columns]
            power *= self.table.roots(gaussian) ** 2
        power += self.rain[:columns]
        profiles[:, :columns] += speckle * np.sqrt(power * transmitting)

    def _mean(self, azimuth: Floats) -> Reals:
        """Mean power of the sea (K, columns) [W] as far out as any clutter matters on these azimuths (K,)."""
        raining = np.flatnonzero(self.rain > self.floor)
        columns = int(raining[-1]) + 1 if len(raining) else 0
        if self.cells is None:
            return np.zeros((len(azimuth), columns), dtype=np.float32)
        first, stop, weight = beam_weights(azimuth, self.cells.rows.turn, lambda x: self.pattern(x) ** 2, self.reach)
        weight /= weight.sum(axis=1)[:, None]
        level = weight.astype(np.float32) @ self.cells.rows.span(first, stop).view(np.float32)
        strongest = np.repeat(level.max(axis=0), self.cells.bins)[: len(self.sea)] * self.sea
        mattering = np.flatnonzero(strongest > self.floor)
        columns = max(columns, int(mattering[-1]) + 1 if len(mattering) else 0)
        return np.repeat(level, self.cells.bins, axis=1)[:, :columns] * self.sea[:columns]


def clutter_of(scene: Scene, landscape: Landscape, compression: Compression, pattern: Pattern, seed: int) -> Clutter | None:
    """The clutter that a scene asks for, None where neither sea nor rain. pattern: one-way gain in azimuth."""
    radar, environment = scene.radar, scene.environment
    if not environment.sea_state and not environment.rain_mm_h:
        return None
    distance = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step
    cell = resolution_cell(pattern, compression, radar.range_step)
    radius = landscape.earth_radius
    sea = sea_power(scene, distance, cell, radius) if environment.sea_state else np.zeros(radar.bins)
    rain = rain_power(scene, distance, cell, radius) if environment.rain_mm_h else np.zeros(radar.bins)
    heard = heard_share(scene, compression)
    sea, rain = sea * heard, rain * heard
    floor = MATTERS * noise_level(compression) if environment.noise else 0.0
    upwind = float(wind_factor(np.zeros(1), np.zeros(1), radar.wavelength)[0])
    mattering = np.flatnonzero(np.maximum(sea * upwind, rain) > floor)
    columns = int(mattering[-1]) + 1 if len(mattering) else 1
    turn = min(radar.azimuths, int(np.ceil(2.0 * np.pi / cell.width * ROWS_PER_BEAM)))
    speckle = TurnRows(turn, SpeckleRows(pulse_power(compression), columns, seed).make)
    made = Clutter(
        sea[:columns].astype(np.float32), rain[:columns].astype(np.float32), floor, pattern, radar.azimuth_step,
        REACH * cell.width, speckle, None, None, None,
    )  # fmt: skip
    if environment.sea_state:
        made.cells = SeaCells(scene, landscape, min(radar.azimuths, 2 * turn), float(distance[columns - 1]))
        shape = _shape(scene, distance[:columns], cell, radius)
        made.table = TextureTable(shape)
        motion = _texture_motion(scene, turn, float(np.median(shape)))
        made.texture = TurnRows(turn, TextureRows(motion, columns, seed).make)
    return made


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
    drift = partial(_drift, scene, turn)
    lifetime = peak_wave_period(environment.sea_state)
    return TextureMotion(turn, radar.rotation_period, lifetime, radar.range_step, length, drift)


def _drift(scene: Scene, turn: int, row: NDArray[np.int64], since: Floats, until: Floats) -> Floats:
    """How far the waves have moved outward along rows (J,) of the turn, seen from the antenna, between instants (J,) [m]."""
    environment = scene.environment
    bearing = row.astype(np.float64) * (2.0 * np.pi / turn)
    outward = np.stack([np.sin(bearing), np.cos(bearing)], axis=1)
    downwind = -np.array([np.sin(environment.wind_from), np.cos(environment.wind_from)])
    waves = downwind * (peak_wave_speed(environment.sea_state) * (until - since))[:, None]
    own = scene.antenna(until)[:, :2] - scene.antenna(since)[:, :2]
    return np.asarray(np.einsum("ij,ij->i", waves - own, outward))
