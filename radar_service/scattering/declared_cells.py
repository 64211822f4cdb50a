"""A declared cross-section on a hull: one echo for each resolution cell, whose energies sum to what is declared.

Echoes closer than a resolution cell would interfere, and their energy would depend on their phases, and so on the aspect. Here
the autocorrelation of the compressed pulse, or that of the beam, is small between any two, and what is left is normalized.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Floats, Indices, batches, distances_from_map, spans, wrap_angle
from radar_service.radar import Radar
from radar_service.scattering.model import ScatteringContext

MAX_OVERLAP = 0.03  # of the autocorrelation along range, summed over two neighbours: 0.13 dB for a pair of any phases
MAX_AZIMUTH_OVERLAP = 0.09  # of neighbours in azimuth: 0.37 dB for a pair that moved since; less would need gaps in the beam
SPACINGS = np.arange(1.0, 12.0, 0.02)  # tried, in resolution cells or beamwidths
SUMMED = 2  # neighbours; further ones meet a short chirp's sidelobes, which add up at random
LONGEST, LAGS = 16, 1024  # spacings that the tables of overlap reach, beyond which there is none, and their entries
STAGGER = 0.25  # spacings by which neighbours in azimuth are moved in range, each the other way: they overlap half as much
MAX_STAGGER = 0.125  # of the distance between them
QUADRATURE = np.array([1.0, 1j, -1.0, -1j])  # neighbours in quadrature
PAIRS = 2**17  # of echoes at a time


class CellSpacing(NamedTuple):
    """Spacing of echoes in range [m] and in azimuth [rad], and how much echoes overlap.

    along, across: lags (L,) [m, rad] and the autocorrelation there, (2, L), of the compressed pulse and of the beam.
    """

    range: float
    azimuth: float
    along: Floats
    across: Floats


class CellEchoes(NamedTuple):
    """Echoes (M,) of bodies, by rising body (M,).

    position: (M, 3) on the map [m]. amplitude: (M,), of 1 m^2 a body in all [m]. span: vertical extent (M,) [m].
    """

    body: Indices
    position: Floats
    amplitude: Complexes
    span: Floats


class _Cells(NamedTuple):
    """Cells in a row on each body (B,), and where scatterers (A,) lie among them.

    first: middle of the first (B,). number: of cells (B,).
    low: cell (A,) at or below a scatterer. high_part: what of it counts for the next (A,).
    """

    first: Floats
    number: Indices
    low: Indices
    high_part: Floats


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
    body: Indices,
    middle: Floats,
    antenna: Floats,
    context: ScatteringContext,
    spacing: CellSpacing,
) -> CellEchoes:
    """The echoes of bodies (B,) of 1 m^2 each at `middle` (B, 3) on the map [m], of which the antenna (3,) sees some scatterers.

    position: (A, 3) of these on the map [m]; power: (A,) in any unit; span: (A,) vertical extents [m]; body: (A,), rising, each
    with power. Echoes of a body form a grid of ranges and azimuths about the middle of power, as long as even power of the same
    variance. Each scatterer shares its power among the neighbours by distance.
    """
    radar, bodies = context.radar, len(middle)
    share = power / np.bincount(body, power, bodies)[body]
    _, slant = distances_from_map(position, antenna, context.earth_radius)
    east, north = position[:, 0] - antenna[0], position[:, 1] - antenna[1]
    bearing = np.arctan2(np.bincount(body, share * east, bodies), np.bincount(body, share * north, bodies))
    azimuth = wrap_angle(np.arctan2(east, north) - bearing[body])
    along, across = _cells(slant, share, body, spacing.range, bodies), _cells(azimuth, share, body, spacing.azimuth, bodies)
    heights = position[:, 2], position[:, 2] ** 2 + span**2 / 12.0
    owner, number_r, number_a, total, (height, square) = _grid(along, across, share, body, heights)
    ranges, turn = along.first[owner] + spacing.range * number_r, across.first[owner] + spacing.azimuth * number_a
    aside = np.minimum(STAGGER * spacing.range, MAX_STAGGER * spacing.azimuth * np.bincount(body, share * slant, bodies)) * (
        across.number > 1
    )
    shifted = ranges + aside[owner] * np.where(number_a % 2, -1.0, 1.0)
    distance = _ground_distance(shifted, height, antenna, context.earth_radius)
    toward = bearing[owner] + turn
    place = np.stack([antenna[0] + distance * np.sin(toward), antenna[1] + distance * np.cos(toward), height], axis=1)
    level = np.stack([middle[:, 0], middle[:, 1], np.bincount(owner, total * height, bodies)], axis=1)
    nearest, of_middle = (distances_from_map(each, antenna, context.earth_radius)[1] for each in (place, level))
    loss = (np.maximum(of_middle, radar.range_min)[owner] / np.maximum(nearest, radar.range_min)) ** 2
    root = np.sqrt(total) * QUADRATURE[(number_r + number_a) % 4]
    root /= np.sqrt(_energy(root * loss, shifted, turn, owner, bodies, spacing))[owner]
    phase = 4.0 * np.pi / radar.wavelength * (nearest - of_middle[owner])
    return CellEchoes(owner, place, root * np.exp(1j * phase), np.sqrt(np.maximum(12.0 * (square - height**2), 0.0)))


def _cells(value: Floats, share: Floats, body: Indices, spacing: float, bodies: int) -> _Cells:
    """Cells so far apart on each of so many bodies, about the middle of its scatterers at `value` (A,), of a share (A,) each."""
    middle = np.bincount(body, share * value, bodies)
    length = np.sqrt(12.0 * np.bincount(body, share * (value - middle[body]) ** 2, bodies))
    count = (length / spacing).astype(np.int64) + 1
    first = middle - spacing * (count - 1) / 2.0
    last = (count - 1)[body]
    at = np.clip((value - first[body]) / spacing, 0.0, last)
    low = np.minimum(at.astype(np.int64), np.maximum(last - 1, 0))
    return _Cells(first, count, low, at - low)


def _grid(
    along: _Cells, across: _Cells, share: Floats, body: Indices, values: Sequence[Floats]
) -> tuple[Indices, Indices, Indices, Floats, list[Floats]]:
    """Cells (M,) of all bodies that get any power: body, numbers along range and azimuth, power, and means of `values` (A,)."""
    count = along.number * across.number
    begin = np.cumsum(count) - count
    low = begin[body] + along.low * across.number[body] + across.low
    cells: list[Indices] = []
    parts: list[Floats] = []
    which: list[Indices] = []
    for up in (0, 1):
        for aside in (0, 1):
            part = share * (along.high_part if up else 1.0 - along.high_part)
            part *= across.high_part if aside else 1.0 - across.high_part
            some = np.flatnonzero(part > 0.0)
            cells.append((low + up * across.number[body] + aside)[some])
            parts.append(part[some])
            which.append(some)
    cell, weight, scatterer = np.concatenate(cells), np.concatenate(parts), np.concatenate(which)
    total = np.bincount(cell, weight, int(count.sum()))
    kept = np.flatnonzero(total > 0.0)
    means = [np.bincount(cell, weight * value[scatterer], len(total))[kept] / total[kept] for value in values]
    owner: Indices = np.repeat(np.arange(len(count)), count)[kept]
    number_r, number_a = np.divmod(kept - begin[owner], across.number[owner])
    return owner, number_r, number_a, np.asarray(total[kept], np.float64), means


def _energy(field: Complexes, slant: Floats, azimuth: Floats, owner: Indices, bodies: int, spacing: CellSpacing) -> Floats:
    """Energies (B,) of the echoes (M,) of bodies, by rising owner, over those of one of amplitude 1.

    field: their amplitudes; slant, azimuth: where they are (M,) [m, rad].
    """
    (lag, along), (turn, across) = spacing.along, spacing.across
    energy: Floats = np.bincount(owner, np.abs(field) ** 2, bodies).astype(np.float64)
    later = np.searchsorted(owner, owner, side="right")  # the end of each echo's body
    for part in batches(later - np.arange(len(owner)), PAIRS):
        first, second = spans(np.arange(len(owner))[part] + 1, later[part])
        first += part.start
        overlap = np.interp(np.abs(slant[first] - slant[second]), lag, along, right=0.0)
        overlap *= np.interp(np.abs(azimuth[first] - azimuth[second]), turn, across, right=0.0)
        overlap *= 2.0 * np.real(field[first] * field[second].conj())
        energy += np.bincount(owner[first], overlap, bodies)
    return energy


def _ground_distance(slant: Floats, height: Floats, antenna: Floats, earth_radius: float) -> Floats:
    """Distances along the earth (M,) [m] of points at slant ranges (M,) and heights (M,) [m]."""
    distance = slant
    for _ in range(3):  # the drop changes by a millionth of the change of distance
        below = height - distance**2 / (2.0 * earth_radius) - antenna[2]
        distance = np.sqrt(np.maximum(slant**2 - below**2, 0.0))
    return distance
