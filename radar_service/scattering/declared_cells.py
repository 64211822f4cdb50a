"""A declared cross-section on a hull: one echo for each resolution cell, whose energies sum to what is declared.

Echoes closer than a resolution cell would interfere, and their energy would depend on their phases, and so on the aspect. Here
the autocorrelation of the compressed pulse, or that of the beam, is small between any two, and what is left is normalized. In
range they lie on one line of sight, so a turn of the body changes their spacing in second order only.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.numerics.frames import distances_from_map, wrap_angle
from radar_service.numerics.types import Complexes, Floats
from radar_service.radar.parameters import Radar
from radar_service.scattering.model import ScatteringContext

MAX_OVERLAP = 0.03  # of the autocorrelation along range, summed over two neighbours: 0.13 dB for a pair of any phases
MAX_AZIMUTH_OVERLAP = 0.09  # of neighbours in azimuth: 0.37 dB for a pair that moved since; less would need gaps in the beam
SPACINGS = np.arange(1.0, 12.0, 0.02)  # tried, in resolution cells or beamwidths
SUMMED = 2  # neighbours; further ones meet a short chirp's sidelobes, which add up at random
LONGEST, LAGS = 16, 1024  # spacings that the tables of overlap reach, beyond which there is none, and their entries
STAGGER = 0.25  # spacings by which neighbours in azimuth are moved in range, each the other way: they overlap half as much
MAX_STAGGER = 0.125  # of the distance between them


class CellSpacing(NamedTuple):
    """Spacing of echoes in range [m] and in azimuth [rad], and how much echoes overlap.

    along, across: lags (L,) [m, rad] and the autocorrelation there, (2, L), of the compressed pulse and of the beam.
    """

    range: float
    azimuth: float
    along: Floats
    across: Floats


class CellEchoes(NamedTuple):
    """Echoes (M,): position (M, 3) on the map [m], amplitude (M,) of 1 m^2 in all [m], vertical extent `span` (M,) [m]."""

    position: Floats
    amplitude: Complexes
    span: Floats


@lru_cache(maxsize=64)
def cell_spacing(radar: Radar) -> CellSpacing:
    """The least spacing at which echoes of this radar hardly overlap."""
    frequency = np.linspace(-3.0, 3.0, 2**14 + 1) * radar.bandwidth
    if radar.modulation != "none":
        power = np.abs(radar.chirp.compressed(frequency)) ** 2
        cell = radar.range_resolution
    else:  # a rectangular pulse behind a Gaussian filter (receive.plain_pulse)
        power = np.sinc(frequency * radar.pulse) ** 2 * np.exp(-4.0 * np.log(2.0) * (frequency / radar.bandwidth) ** 2)
        cell = SPEED_OF_LIGHT / 2.0 * max(radar.pulse, 0.5 / radar.bandwidth)
    along = _spectrum(power, 2.0 / SPEED_OF_LIGHT * frequency)
    rows = 2**14
    gain = radar.azimuth_gain(wrap_angle(np.arange(rows, dtype=np.float64) * (2.0 * np.pi / rows)))
    across = _spectrum(np.abs(np.fft.fft(gain)) ** 2, np.asarray(np.fft.fftfreq(rows, 2.0 * np.pi / rows), np.float64))
    azimuth = _first_spacing(across, radar.beamwidth, 1, MAX_AZIMUTH_OVERLAP)
    spacing = _first_spacing(along, cell, SUMMED, MAX_OVERLAP)
    lags = [np.linspace(0.0, LONGEST * step, LAGS) for step in (spacing, azimuth)]
    tables = (np.array([lag, _autocorrelation(power, lag)]) for lag, power in zip(lags, (along, across), strict=True))
    return CellSpacing(spacing, azimuth, *tables)


def _spectrum(power: Floats, frequency: Floats) -> Floats:
    """Power, of sum 1, and frequency (2, F) without what is too weak to count."""
    counted = power > 1e-6 * power.max()
    return np.array([power[counted] / power[counted].sum(), frequency[counted]])


def _autocorrelation(spectrum: Floats, lag: Floats) -> Floats:
    """Autocorrelation (L,) at lags (L,)."""
    return np.asarray(np.cos(2.0 * np.pi * lag[:, None] * spectrum[1]) @ spectrum[0])


def _first_spacing(spectrum: Floats, cell: float, count: int, limit: float) -> float:
    """The first of SPACINGS, in units of `cell`, at which the autocorrelation sums to `limit` over `count` multiples, or the
    one with the least sum."""
    best, least = cell, np.inf
    for spacing in (cell * SPACINGS).tolist():
        overlap = float(np.abs(_autocorrelation(spectrum, spacing * np.arange(1, count + 1))).sum())
        if overlap < least:
            best, least = spacing, overlap
        if least <= limit:
            break
    return best


def cell_echoes(
    position: Floats,
    power: Floats,
    span: Floats,
    middle: Floats,
    antenna: Floats,
    context: ScatteringContext,
    spacing: CellSpacing,
) -> CellEchoes:
    """The echoes of a body of 1 m^2 at `middle` (3,) on the map [m], of which the antenna (3,) sees some scatterers.

    position: (A, 3) of these on the map [m]; power: (A,) in any unit; span: (A,) vertical extents [m]. Echoes form a grid of
    ranges and azimuths about the middle of power, as long as even power of the same variance. Each scatterer shares its power
    among the neighbours by distance, so all changes smoothly with the aspect, except for the number of cells.
    """
    radar, share = context.radar, power / power.sum()
    _, slant = distances_from_map(position, antenna, context.earth_radius)
    east, north = (position[:, :2] - antenna[:2]).T
    bearing = float(np.arctan2(share @ east, share @ north))
    azimuth = wrap_angle(np.arctan2(east, north) - bearing)
    ranges, along = _cells(slant, share, spacing.range)
    azimuths, across = _cells(azimuth, share, spacing.azimuth)
    weight = np.einsum("am,an->mna", along * share[:, None], across).reshape(-1, len(share))
    total = weight.sum(axis=1)
    kept = np.flatnonzero(total > 0.0)
    weight, total = weight[kept] / total[kept, None], total[kept]
    number_r, number_a = np.divmod(kept, len(azimuths))
    height = weight @ position[:, 2]
    variance = weight @ (position[:, 2] ** 2 + span**2 / 12.0) - height**2
    aside = min(STAGGER * spacing.range, MAX_STAGGER * spacing.azimuth * float(share @ slant)) if len(azimuths) > 1 else 0.0
    shifted = ranges[number_r] + aside * (-1.0) ** number_a
    distance = _ground_distance(shifted, height, antenna, context.earth_radius)
    toward = bearing + azimuths[number_a]
    plan = antenna[:2] + distance[:, None] * np.stack([np.sin(toward), np.cos(toward)], axis=1)
    place = np.column_stack([plan, height])
    _, nearest = distances_from_map(np.vstack([place, [*middle[:2], total @ height]]), antenna, context.earth_radius)
    loss = np.maximum(nearest, radar.range_min)
    loss = (loss[-1] / loss[:-1]) ** 2
    root = np.sqrt(total) * 1j ** (number_r + number_a)  # neighbours in quadrature
    root /= np.sqrt(_energy(root * loss, shifted, azimuths[number_a], spacing))
    amplitude = root * np.exp(4j * np.pi / radar.wavelength * (nearest[:-1] - nearest[-1]))
    return CellEchoes(place, amplitude, np.sqrt(np.maximum(12.0 * variance, 0.0)))


def _energy(field: Complexes, slant: Floats, azimuth: Floats, spacing: CellSpacing) -> float:
    """Energy of echoes (M,) of amplitude `field` at ranges [m] and azimuths [rad] (M,), over that of one of amplitude 1."""
    (lag, along), (turn, across) = spacing.along, spacing.across
    overlap = np.interp(np.abs(slant[:, None] - slant), lag, along, right=0.0)
    overlap *= np.interp(np.abs(azimuth[:, None] - azimuth), turn, across, right=0.0)
    return float(np.real(field @ overlap @ field.conj()))


def _cells(value: Floats, share: Floats, spacing: float) -> tuple[Floats, Floats]:
    """Middles (M,) of cells so far apart, and the part (A, M) of each scatterer at `value` (A,) in each of them."""
    middle = share @ value
    length = np.sqrt(12.0 * (share @ (value - middle) ** 2))
    count = int(length / spacing) + 1
    cells = middle + spacing * (np.arange(count) - (count - 1) / 2.0)
    apart = np.abs(np.clip(value, cells[0], cells[-1])[:, None] - cells)
    return cells, np.asarray(np.maximum(0.0, 1.0 - apart / spacing))


def _ground_distance(slant: Floats, height: Floats, antenna: Floats, earth_radius: float) -> Floats:
    """Distances along the earth (M,) [m] of points at slant ranges (M,) and heights (M,) [m]."""
    distance = slant
    for _ in range(3):  # the drop changes by a millionth of the change of distance
        below = height - distance**2 / (2.0 * earth_radius) - antenna[2]
        distance = np.sqrt(np.maximum(slant**2 - below**2, 0.0))
    return distance
