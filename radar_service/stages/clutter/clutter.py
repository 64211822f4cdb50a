"""Clutter of sea and rain, added to compressed profiles.

Speckle is weighted by the beam and has the correlation of the pulse. In each cell it is multiplied by the root of the sea's local
mean power (texture x mean) plus the rain's. Conditional on the texture both are complex Gaussian with the same correlations, so
one speckle serves both. Over the sea it changes while the beam passes; rain alone has it constant. It is new in each scan.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Flags, Floats, Gain, Indices, Singles
from radar_service.receive.compression import Compression, receiver_noise_power
from radar_service.receive.detection import square_law
from radar_service.stages.clutter.azimuth_rows import AzimuthRowCache, BeamWeights, changing_beam, weight_rows
from radar_service.stages.clutter.effect import RAIN, RAIN_CELL, SEA
from radar_service.stages.clutter.rain import RainRows, rain_power, reflectivity
from radar_service.stages.clutter.resolution_cell import MIN_CLUTTER_TO_NOISE, pulse_power, received_share, resolution_cell
from radar_service.stages.clutter.sea import speckle_time, wind_factor
from radar_service.stages.clutter.sea_clutter import Sea, prepare_sea, sea_power
from radar_service.stages.clutter.texture import SpeckleRows
from radar_service.stages.stage import RandomField
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.scene import Scene

ROWS_PER_BEAM = 1.506  # rows in the width of two-way power: 2 in the half-power width of a sinc^2 beam, above its band
BEAM_EXTENT = 4.0  # two-way widths each side: for a sinc^2 beam to its fourth null, beyond which lies 1e-4 of the power
NEARLY_ALL = 1.0 - 1e-6  # share of the rain above which the rest is rounding of single precision, at most 2^-22


@dataclass(frozen=True)
class ClutterRows(RandomField):
    """Clutter of some azimuths (K,).

    rain: mean power of the rain alone in the first bins (n,), or (K, n) behind structures [W], 0 beyond.
    """

    rain: Singles

    def powers(self) -> dict[int, Singles]:
        power = square_law(self.field)
        if not len(self.rain):
            return {SEA: power}
        share = self.rain_share
        return {RAIN: power * share, SEA: power * (np.float32(1.0) - share)}

    def behind(self, power: Floats) -> "ClutterRows":
        """The clutter behind structures that leave a share (K,) of its power."""
        share = power.astype(np.float32)[:, None]
        rain = self.rain if not len(self.rain) else self.rain * share
        return ClutterRows(self.field * np.sqrt(share), self.amplitude * np.sqrt(share), rain)

    @property
    def rain_share(self) -> Singles:
        """Share of the rain in the local mean power, as `amplitude`."""
        columns = self.field.shape[1]
        rain = self.rain[..., :columns]
        rain = np.pad(rain, [(0, 0)] * (rain.ndim - 1) + [(0, columns - rain.shape[-1])])
        mean = self.amplitude * self.amplitude
        share = np.divide(rain, mean, out=np.zeros_like(mean), where=mean > 0.0)
        share[share > NEARLY_ALL] = 1.0
        return np.asarray(share)


@dataclass(frozen=True)
class Clutter:
    """Sea and rain clutter of one radar in one scene, ready to be added to profiles.

    rain: mean power in the bins that have rain clutter (n,) [W].
    floor: mean power below which clutter is not added [W].
    columns: bins of the rows of speckle.
    beam: weights of the field on these rows.
    speckle: rows of speckle.
    sea: None where there is no sea clutter.
    cells: rain with cells, in place of `rain`; None without any.
    """

    rain: Singles
    floor: float
    columns: int
    beam: BeamWeights
    speckle: AzimuthRowCache
    sea: Sea | None
    cells: RainRows | None = None

    def rows(self, number: Indices, transmitting: Flags) -> "ClutterRows | None":
        """The clutter of consecutive azimuths (K,) of a scan; None where it is nowhere above the floor.

        number: (K,) counted from the start; transmitting: (K, 1) which azimuths are not blind.
        """
        level = None if self.sea is None else self.sea.level(number)
        rain, left = (self.rain, None) if self.cells is None else self.cells.at(number)
        if self.cells is not None:
            rain = rain[..., : len(_above_floor(rain.reshape(-1, rain.shape[-1]).max(axis=0, initial=0.0), self.floor))]
        columns = rain.shape[-1]
        if self.sea is not None and level is not None:
            columns = min(self.columns, max(columns, self.sea.bins_above(level, self.floor)))
        if columns == 0:
            return None
        first, stop, weights = self.beam.at(number)
        rows = self.speckle.span(first, stop)[:, :columns]
        speckle = weight_rows(weights if transmitting.all() else weights * transmitting, rows).view(np.complex64)
        amplitude = self._amplitude(number, level, columns, rain, left)
        speckle *= amplitude
        return ClutterRows(speckle, amplitude, rain)

    def _amplitude(
        self, number: Indices, level: Singles | None, columns: int, rain: Singles, left: Singles | None
    ) -> Singles:
        """Root of the local mean power (K, columns) [sqrt(W)], with texture and rain; left: share (K, n) through cells."""
        if self.sea is None or level is None:
            return np.sqrt(rain[..., :columns])
        amplitude = self.sea.amplitude(number, level, columns)
        if left is not None:
            amplitude *= np.sqrt(left[:, :columns])
        if rain.shape[-1]:
            rain = np.pad(rain, [(0, 0)] * (rain.ndim - 1) + [(0, columns - rain.shape[-1])])
            amplitude = np.sqrt(amplitude * amplitude + rain)
        return amplitude


def prepare_clutter(
    scene: Scene, line_of_sight: OcclusionScene, compression: Compression, seed: int, speckle_seed: int
) -> Clutter | None:
    """Returns the clutter of a scene; None where neither sea nor rain is strong enough. seed: of the sea's texture."""
    radar, environment = scene.radar, scene.environment
    distance = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step
    cell = resolution_cell(radar.azimuth_gain, compression, radar.range_step)
    earth_radius = line_of_sight.earth_radius
    floor = MIN_CLUTTER_TO_NOISE * receiver_noise_power(radar) if environment.noise else 0.0
    received = received_share(scene, compression)
    rain = np.zeros(0)
    of_cells = environment.effect_keys.get(RAIN_CELL)
    rates = [environment.rain_mm_h, *(each.rain_mm_h for each in of_cells.cells)] if of_cells else [environment.rain_mm_h]
    if any(rates):
        eta = sum(reflectivity(rate, radar.wavelength) for rate in rates)
        rain = _above_floor(rain_power(scene, distance, cell, earth_radius, eta) * received, floor)
    sea = np.zeros(0)
    if environment.sea_state:
        upwind = float(wind_factor(np.zeros(1), np.zeros(1), radar.wavelength)[0])
        sea = _above_floor(sea_power(scene, distance, cell, earth_radius) * received, floor / upwind)
    columns = max(len(rain), len(sea))
    if columns == 0:
        return None
    cells = None
    if of_cells:
        unit = rain_power(scene, distance[:columns], cell, earth_radius, 1.0) * received[:columns]
        cells = RainRows(scene, of_cells, unit, cell.width)
    rows_per_scan = min(radar.azimuths, int(np.ceil(2.0 * np.pi / cell.width * ROWS_PER_BEAM)))
    extent = BEAM_EXTENT * cell.width
    beam: tuple[Gain, float, int] = radar.azimuth_gain, extent, rows_per_scan
    if len(sea):
        beam = changing_beam(radar.azimuth_gain, extent, radar.rotation_period, speckle_time(radar.wavelength))
    gain, reach, speckle_rows = *beam[:2], min(radar.azimuths, beam[2])
    return Clutter(
        rain.astype(np.float32),
        floor,
        columns,
        BeamWeights(radar.azimuths, speckle_rows, gain, reach, order=2),
        AzimuthRowCache(speckle_rows, SpeckleRows(pulse_power(compression), columns, speckle_seed, scene.random_key).make),
        prepare_sea(scene, line_of_sight, sea, cell, columns, rows_per_scan, extent, seed) if len(sea) else None,
        cells,
    )


def _above_floor(power: Floats, floor: float) -> Floats:
    """The bins of power (N,) [W] up to the last one above the floor [W]."""
    above = np.flatnonzero(power > floor)
    return power[: int(above[-1]) + 1] if len(above) else power[:0]
