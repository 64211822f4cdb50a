"""Clutter of sea and rain, added to compressed profiles.

Speckle is weighted by the beam and has the correlation of the pulse. In each cell it is multiplied by the root of the sea's local
mean power (texture x mean) plus the rain's. Conditional on the texture both are complex Gaussian with the same correlations, so
one speckle serves both. Over the sea it changes while the beam passes; rain alone has it constant. It is new in each scan.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from radar_service.numerics import Flags, Floats, Gain, Indices, Singles
from radar_service.propagation import elevation_gain
from radar_service.radar import horizon
from radar_service.receive import Compression, receiver_noise_power
from radar_service.records import square_law
from radar_service.stages.clutter.azimuth_rows import AzimuthRowCache, BeamWeights, changing_beam, weight_rows
from radar_service.stages.clutter.effect import RAIN, RAIN_CELL, SEA, RainCells
from radar_service.stages.clutter.resolution_cell import (
    MIN_CLUTTER_TO_NOISE,
    TWO_WAY_EXTENT,
    ResolutionCell,
    pulse_power,
    received_share,
    resolution_cell,
    two_way_gain,
    unit_power,
)
from radar_service.stages.clutter.sea import speckle_time, wind_factor
from radar_service.stages.clutter.sea_clutter import Sea, prepare_sea, sea_power
from radar_service.stages.clutter.texture import SpeckleRows
from radar_service.stages.stage import RandomField
from radar_service.trace import OcclusionScene
from radar_service.world import Scene

WATER_FACTOR = 0.93  # |K|^2 of liquid water from 0 to 20 C at 3 to 10 cm (Gunn and East 1954)
RAIN_HEIGHT = 3000.0  # m above the sea: rain begins where snow melts, 0.36 km above 0 C in Rec. P.839; a temperate autumn
RAYS = 8  # in the width of two-way power, over which cells are averaged: an edge along the beam moves power by 0.5 dB steps
ROWS_PER_BEAM = 1.506  # rows in the width of two-way power: 2 in the half-power width of a sinc^2 beam, above its band
BEAM_EXTENT = 4.0  # two-way widths each side: for a sinc^2 beam to its fourth null, beyond which lies 1e-4 of the power
NEARLY_ALL = 1.0 - 1e-6  # share of the rain above which the rest is rounding of single precision, at most 2^-22


def reflectivity(rain_mm_h: float, wavelength: float) -> float:
    """Cross-section of rain per volume eta [m^2/m^3]: pi^5 |K|^2 Z / lambda^4, Z = 200 R^1.6 mm^6/m^3.

    rain_mm_h: 0 and up, else ValueError; wavelength: [m], drops small against it (Rayleigh: 3 cm and longer). Sources:
    Probert-Jones 1962; Marshall and Palmer 1948 (with Gunn, 1952, for the coefficients).
    """
    if not rain_mm_h >= 0:
        raise ValueError(f"rain_mm_h: {rain_mm_h:g} is not allowed; 0 mm/h or more")
    z = 200.0 * rain_mm_h**1.6 * 1e-18  # m^6/m^3
    return float(np.pi**5 * WATER_FACTOR * z / wavelength**4)


def beam_height(distance: Floats, antenna_height: float, earth_radius: float, elevation: Floats, gain: Floats) -> Floats:
    """Integral of the two-way elevation pattern over the rain in the beam, an angle [rad], at each slant range.

    distance: (N,) [m]; antenna_height: [m]; earth_radius: effective, inf for flat [m]; elevation: (M,) rising over the
    extent of the beam [rad]; gain: (M,) one-way power gain there. Rain fills the air from the sea to RAIN_HEIGHT.
    """
    from scipy.integrate import cumulative_trapezoid  # here: few scenes have rain, and it would slow every start

    integral = np.concatenate([[0.0], cumulative_trapezoid(gain**2, elevation)])
    bend = distance / (2.0 * earth_radius)
    dip = -np.sqrt(2.0 * antenna_height / earth_radius)  # beyond the horizon the sea's bulge limits the beam
    floor = np.arcsin(np.clip(-antenna_height / distance - bend, -1.0, 1.0))
    beyond = distance > horizon(0.0, antenna_height, earth_radius)
    bottom = np.where(beyond, dip, floor)
    top = np.arcsin(np.clip((RAIN_HEIGHT - antenna_height) / distance - bend, -1.0, 1.0))
    filled = np.interp(top, elevation, integral) - np.interp(bottom, elevation, integral)
    return np.asarray(np.maximum(filled, 0.0))


def rain_power(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float, eta: float) -> Floats:
    """Mean received power [W] of uniform rain at slant ranges (N,) [m].

    earth_radius: effective, inf for flat [m]; eta: cross-section per volume [m^2/m^3].
    """
    radar = scene.radar
    elevation = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2**14 + 1)  # 0.011 degrees: five in the narrowest beam allowed
    height = beam_height(distance, radar.height, earth_radius, elevation, elevation_gain(radar, elevation))
    return eta * cell.area(distance) * distance * height * unit_power(scene, distance)


class RainRows:
    """Rain with cells at any azimuths: its power, and what its cells leave of power from behind. Safe for several threads."""

    def __init__(self, scene: Scene, cells: RainCells, unit: Floats, width: float) -> None:
        """unit: (n,) power of rain of cross-section 1 m^2/m^3 everywhere, without loss in cells [W]; width: of the two-way
        azimuth pattern [rad]."""
        self._scene, self._cells, radar = scene, cells, scene.radar
        self._edges = np.arange(len(unit) + 1, dtype=np.float64)[None] * radar.range_step
        self._uniform = reflectivity(scene.environment.rain_mm_h, radar.wavelength)
        self._unit, rays = unit, int(np.ceil(2.0 * np.pi / width * RAYS))
        self._rows = AzimuthRowCache(rays, self._make, revision=scene.own_revision)
        self._beam = BeamWeights(radar.azimuths, rays, partial(two_way_gain, radar), TWO_WAY_EXTENT * width, order=1)
        self._apart = (self._uniform * unit).astype(np.float32)

    def at(self, number: Indices) -> tuple[Singles, Singles | None]:
        """Mean power of the rain (K, n) [W], and the share of power (K, n) that comes through cells, at consecutive azimuths (K,)
        numbered from the start; where the beam meets no cell, power (n,) and None."""
        first, stop, weights = self._beam.at(number)
        rows = self._rows.span(first, stop)
        if (rows[:, : len(self._unit)] == self._apart).all() and (rows[:, -1] == 1.0).all():
            return self._apart, None
        mean = weights @ rows
        return mean[:, : len(self._unit)], mean[:, len(self._unit) :]

    def _make(self, scan: int, start: int, stop: int) -> Singles:
        """Rows of rays start to stop (exclusive) of a scan: the power of rain on each, then the share through cells (R, 2 n).

        Range cells are cut where the ray enters and leaves; half of the way through a range cell weakens its own rain.
        """
        radar, turns = self._scene.radar, np.arange(start, stop) / self._rows.rows_per_scan
        time = radar.time_of_turns(scan + turns)
        eta, db = np.full((len(turns), len(self._unit)), self._uniform), np.zeros((len(turns), len(self._unit)))
        for cell, rows, inside in self._cells.paths(self._scene.antenna(time), time, 2.0 * np.pi * turns, self._edges):
            step = self._edges[0, 1]
            eta[rows] += reflectivity(cell.rain_mm_h, radar.wavelength) / step * np.diff(inside, axis=1)
            db[rows] += cell.db_per_m(radar) * (inside[:, 1:] + inside[:, :-1])
        share = np.ones_like(db)
        wet = np.flatnonzero(db[:, -1] > 0.0)
        share[wet] = 10.0 ** (db[wet] / -10.0)
        return np.concatenate([eta * self._unit * share, share], axis=1).astype(np.float32)


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
        rain = _in_columns(self.rain, self.field.shape[1])
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
            amplitude = np.sqrt(amplitude * amplitude + _in_columns(rain, columns))
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


def _in_columns(power: Singles, columns: int) -> Singles:
    """Power (..., n) [W] in the first columns (..., columns), 0 where it ends before."""
    power = power[..., :columns]
    return np.pad(power, [(0, 0)] * (power.ndim - 1) + [(0, columns - power.shape[-1])])
