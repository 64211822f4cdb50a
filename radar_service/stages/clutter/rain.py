"""Rain clutter: the cross-section of a volume of drops, its share of the beam, and the power received from it."""

from functools import partial

import numpy as np

from radar_service.numerics.types import Floats, Indices, Singles
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.radar.parameters import horizon
from radar_service.stages.clutter.azimuth_rows import AzimuthRowCache, BeamWeights
from radar_service.stages.clutter.rain_cell import RainCells
from radar_service.stages.clutter.resolution_cell import TWO_WAY_EXTENT, ResolutionCell, two_way_gain, unit_power
from radar_service.world.scene import Scene

WATER_FACTOR = 0.93  # |K|^2 of liquid water from 0 to 20 C at 3 to 10 cm (Gunn and East 1954)
RAIN_HEIGHT = 3000.0  # m above the sea: rain begins where snow melts, 0.36 km above 0 C in Rec. P.839; a temperate autumn
RAYS = 8  # in the width of two-way power, over which cells are averaged: an edge along the beam moves power by 0.5 dB steps


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
