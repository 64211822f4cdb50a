"""Antenna patterns: one-way power gain relative to boresight, as printed in the specification and as it should be.

An echo's amplitude goes as the one-way power gain, its power as the square of it (DESIGN row 2).
"""

from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from radar_service.radar.parameters import Pattern, Taylor

Floats = NDArray[np.float64]

HALF_POWER_U = 0.442946470689452  # root of sinc(u)^2 = 1/2; twice it is the 0.8859 of the half-power width
PLAIN_TAYLOR = Taylor(30.0, 4)  # nbar 4 is the least that holds 30 dB (Taylor 1955)
PRINTED_APERTURE = 2.783 / (2.0 * HALF_POWER_U)  # times the uniform one of its nominal beamwidth
TABLE_APERTURE = 1.7  # times the uniform one of its half-power width: somewhat more than a cosine-squared taper
TABLE_STEPS = 2**17  # to half a turn
LOWEST_GAIN = 1e-30  # -300 dB: keeps the logarithm of a table's zeros finite


def printed_gain(offset: Floats | float, beamwidth: float) -> Floats:
    """One-way gain exactly as printed, u = 2.783 t / t3dB inside sin(pi u) / (pi u); its half-power width is 0.318 t3dB.

    offset: any shape, from boresight [rad]; beamwidth: nominal one-way half-power width [rad]. Source: seed eq. 2.
    """
    u = 2.783 * np.asarray(offset, dtype=np.float64) / beamwidth
    gain: Floats = np.sinc(u) ** 2  # eq. 2, with G0 = 1
    return gain


def printed_two_way(azimuth: Floats | float, elevation: Floats | float, beamwidth: float, beamwidth_el: float) -> Floats:
    """Two-way pattern exactly as printed, which the specification multiplies onto the AMPLITUDE (DESIGN row 2).

    azimuth, elevation: offsets from boresight, broadcastable [rad]; the beamwidths one-way [rad]. Source: seed eqs. 3, 9.
    """
    two_way: Floats = (printed_gain(azimuth, beamwidth) * printed_gain(elevation, beamwidth_el)) ** 2  # eqs. 3, 9
    return two_way


def sinc2_gain(offset: Floats, beamwidth: float) -> Floats:
    """Uniform aperture: sinc^2 with u = 0.8859 t / t3dB, first sidelobe -13.26 dB (Balanis, Antenna Theory, 2016)."""
    gain: Floats = np.sinc(2.0 * HALF_POWER_U / beamwidth * offset) ** 2
    return gain


def gaussian_gain(offset: Floats, beamwidth: float) -> Floats:
    """Gaussian of half-power width `beamwidth` [rad]: no sidelobes at all."""
    gain: Floats = np.exp(-4.0 * np.log(2.0) * (offset / beamwidth) ** 2)
    return gain


def taylor_gain(offset: Floats, beamwidth: float, taylor: Taylor = PLAIN_TAYLOR) -> Floats:
    """Taylor line source, stretched to the half-power width (T. T. Taylor, 1955)."""
    return _sinc_sum_gain(offset, beamwidth, *_taylor_source(taylor))


def cosine_gain(offset: Floats, beamwidth: float) -> Floats:
    """Cosine aperture: first sidelobe -23.0 dB, half-power width 1.189 lambda / a (Balanis, Antenna Theory, 2016)."""
    return _sinc_sum_gain(offset, beamwidth, *_cosine_source())


def cosine2_gain(offset: Floats, beamwidth: float) -> Floats:
    """Cosine-squared aperture: first sidelobe -31.5 dB, half-power width 1.441 lambda / a (Balanis 2016; Harris 1978)."""
    return _sinc_sum_gain(offset, beamwidth, *_cosine2_source())


def table_gain(offset: Floats, table: tuple[tuple[float, float], ...]) -> Floats:
    """A measured pattern: rows of (offset [rad], one-way power gain) rising from 0, the last one holding beyond.

    Between rows the level in dB follows a monotone cubic (Fritsch and Carlson 1980), level at boresight: straight lines leave
    corners, whose spectrum the beam's filter over the turn cuts off at -50 dB, and a beam 12 dB further from the true one.
    """
    inside = np.minimum(np.abs(offset), table[-1][0])
    gain: Floats = 10.0 ** _table_curve(table)(inside)
    return gain


@cache
def _table_curve(table: tuple[tuple[float, float], ...]) -> Callable[[Floats], Floats]:
    """log10 of a table's gain over the offset [rad], symmetric about 0 and flat at its end."""
    from scipy.interpolate import PchipInterpolator  # here: it would take a sixth of every start

    offset, gain = np.asarray(table, dtype=np.float64).T
    level = np.log10(np.maximum(gain, LOWEST_GAIN))
    beyond = 2.0 * offset[-1] - offset[-2]
    return PchipInterpolator(
        np.concatenate([-offset[:0:-1], offset, [beyond]]), np.concatenate([level[:0:-1], level, level[-1:]])
    )


PATTERNS: dict[str, Callable[[Floats, float], Floats]] = {
    "sinc2": sinc2_gain,
    "printed": printed_gain,
    "gaussian": gaussian_gain,
    "taylor": taylor_gain,
    "cosine": cosine_gain,
    "cosine2": cosine2_gain,
}


def one_way_gain(offset: Floats | float, beamwidth: float, pattern: Pattern = "sinc2") -> Floats:
    """One-way power gain relative to boresight, 1 at offset 0, for one of the two principal planes.

    offset: any shape, from boresight, wrapped to +-pi by the caller [rad]; beamwidth: one-way half-power width [rad] (a
    table brings its own). Raises ValueError for an unknown name, listing the known ones.
    """
    offsets = np.asarray(offset, dtype=np.float64)
    if isinstance(pattern, Taylor):
        return taylor_gain(offsets, beamwidth, pattern)
    if not isinstance(pattern, str):
        return table_gain(offsets, pattern)
    if pattern not in PATTERNS:
        raise ValueError(f'pattern: "{pattern}" is not one of {", ".join(PATTERNS)}; or give a table of (offset, gain)')
    return PATTERNS[pattern](offsets, beamwidth)


def quick_gain(offset: Floats, beamwidth: float, pattern: Pattern) -> Floats:
    """`one_way_gain` for many offsets, by lines between places of a table: within 3e-6 of it (h^2 / 8 of the second
    derivative), several times faster."""
    gain, rise = _gain_table(beamwidth, pattern)
    place = np.abs(offset)
    place *= (len(gain) - 1) / np.pi
    entry = place.astype(np.intp)
    place -= entry
    place *= rise.take(entry, mode="clip")
    place += gain.take(entry, mode="clip")
    return place


@lru_cache(maxsize=8)
def _gain_table(beamwidth: float, pattern: Pattern) -> tuple[Floats, Floats]:
    """Gains at offsets from 0 to pi, at least 500 in the beamwidth of a uniform aperture, and the rise from each to the next."""
    steps = max(TABLE_STEPS, int(np.ceil(500.0 * np.pi / aperture_beamwidth(beamwidth, pattern))))
    gain = one_way_gain(np.arange(steps + 2, dtype=np.float64) * (np.pi / steps), beamwidth, pattern)
    return gain[:-1], np.diff(gain)


def aperture_beamwidth(beamwidth: float, pattern: Pattern) -> float:
    """Half-power width [rad] that a uniform aperture as long as this antenna's would have: it says how fast the gain
    varies, and so how finely a turn must be sampled (0.8859 lambda / a)."""
    if isinstance(pattern, Taylor):
        _, _, half_power = _taylor_source(pattern)
        return beamwidth * HALF_POWER_U / half_power
    if not isinstance(pattern, str):
        return _table_beamwidth(pattern) / TABLE_APERTURE
    if pattern == "printed":
        return beamwidth / PRINTED_APERTURE
    sources = {"cosine": _cosine_source, "cosine2": _cosine2_source}
    if pattern in sources:
        return beamwidth * HALF_POWER_U / sources[pattern]()[2]
    return beamwidth


def _table_beamwidth(table: tuple[tuple[float, float], ...]) -> float:
    """Half-power width [rad] of a table; of a pattern that never falls so far, a whole turn."""
    fine = np.linspace(0.0, np.pi, 100_001)
    below = np.flatnonzero(table_gain(fine, table) < 0.5)
    return 2.0 * float(fine[below[0]]) if len(below) else 2.0 * np.pi


Source = tuple[tuple[float, ...], tuple[float, ...], float]  # places u, weights of the sincs there, u of half power


@cache
def _taylor_source(taylor: Taylor) -> Source:
    """F_n at u = n, n = -(nbar - 1) to nbar - 1 (Taylor 1955)."""
    nbar = taylor.nbar
    a2 = (np.arccosh(10.0 ** (taylor.sidelobe_db / 20.0)) / np.pi) ** 2
    sigma2 = nbar**2 / (a2 + (nbar - 0.5) ** 2)
    m = np.arange(1, nbar)
    n = np.arange(nbar)
    column = n[:, None]
    zeros = np.prod(1.0 - column**2 / (sigma2 * (a2 + (m - 0.5) ** 2)), axis=1)
    others = np.where(m == column, 1.0, 1.0 - column**2 / m**2).prod(axis=1)
    own = np.where(n == 0, 1.0, 0.5 * (-1.0) ** (n + 1))  # sinc(u) / (1 - u^2 / n^2) as u goes to n
    weights = (zeros / others * own).tolist()
    return _with_half_power((*(-n[:0:-1]).tolist(), *n.tolist()), (*weights[:0:-1], *weights))


@cache
def _cosine_source() -> Source:
    return _with_half_power((-0.5, 0.5), (np.pi / 4.0, np.pi / 4.0))


@cache
def _cosine2_source() -> Source:
    return _with_half_power((-1.0, 0.0, 1.0), (0.5, 1.0, 0.5))


def _with_half_power(places: tuple[float, ...], weights: tuple[float, ...]) -> Source:
    low, high = 0.1, 1.5  # the main lobe falls through half power once in between
    for _ in range(4):  # to 1e-12; scipy.optimize would take a tenth of a second to load
        u = np.linspace(low, high, 1025)
        above = int(np.flatnonzero(_sinc_sum(u, places, weights) > np.sqrt(0.5))[-1])
        low, high = float(u[above]), float(u[above + 1])
    return places, weights, (low + high) / 2.0


def _sinc_sum_gain(
    offset: Floats, beamwidth: float, places: tuple[float, ...], weights: tuple[float, ...], half_power: float
) -> Floats:
    gain: Floats = _sinc_sum(2.0 * half_power / beamwidth * offset, places, weights) ** 2
    return gain


def _sinc_sum(u: Floats, places: tuple[float, ...], weights: tuple[float, ...]) -> Floats:
    """Voltage pattern of a cosine-sum aperture as shifted sincs, which have no removable singularities to step around."""
    field = np.zeros(np.shape(u))
    for place, weight in zip(places, weights, strict=True):
        field += weight * np.sinc(u - place)
    return field
