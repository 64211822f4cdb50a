"""Antenna patterns: one-way power gain relative to boresight, as printed in the specification and as it should be.

An echo's amplitude goes as the one-way power gain, its power as the square of it (DESIGN row 2).
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Floats = NDArray[np.float64]
Pattern = str | tuple[tuple[float, float], ...]  # a name, or rows of (offset [rad], one-way power gain)

HALF_POWER_U = 0.442946470689452  # root of sinc(u)^2 = 1/2; twice it is the 0.8859 of the half-power width
TAYLOR_SIDELOBE_DB, TAYLOR_NBAR = 30.0, 4  # nbar 4 is the least that holds 30 dB (Taylor 1955)
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


def taylor_gain(offset: Floats, beamwidth: float) -> Floats:
    """Taylor line source, sidelobes 30 dB down, nbar 4, stretched to the half-power width (T. T. Taylor, 1955)."""
    coefficients, half_power = _taylor_source()
    gain: Floats = _taylor_field(2.0 * half_power / beamwidth * offset, coefficients) ** 2
    return gain


def table_gain(offset: Floats, table: tuple[tuple[float, float], ...]) -> Floats:
    """A measured pattern: rows of (offset [rad], one-way power gain) rising from 0; dB linear between, last beyond."""
    rows = np.asarray(table, dtype=np.float64)
    levels = np.log10(np.maximum(rows[:, 1], LOWEST_GAIN))
    gain: Floats = 10.0 ** np.interp(np.abs(offset), rows[:, 0], levels)
    return gain


PATTERNS: dict[str, Callable[[Floats, float], Floats]] = {
    "sinc2": sinc2_gain,
    "printed": printed_gain,
    "gaussian": gaussian_gain,
    "taylor": taylor_gain,
}


def one_way_gain(offset: Floats | float, beamwidth: float, pattern: Pattern = "sinc2") -> Floats:
    """One-way power gain relative to boresight, 1 at offset 0, for one of the two principal planes.

    offset: any shape, from boresight, wrapped to +-pi by the caller [rad]; beamwidth: one-way half-power width [rad] (a
    table brings its own). Raises ValueError for an unknown name, listing the known ones.
    """
    offsets = np.asarray(offset, dtype=np.float64)
    if not isinstance(pattern, str):
        return table_gain(offsets, pattern)
    if pattern not in PATTERNS:
        raise ValueError(f'pattern: "{pattern}" is not one of {", ".join(PATTERNS)}; or give a table of (offset, gain)')
    return PATTERNS[pattern](offsets, beamwidth)


def vertical_pattern(pattern: Pattern) -> str:
    """The pattern in elevation of an antenna: its own by name; sinc2 where a table gives the horizontal only."""
    return pattern if isinstance(pattern, str) else "sinc2"


@cache
def _taylor_source() -> tuple[Floats, float]:
    """Coefficients F_n, n = 0 to nbar - 1, and the u of half power (Taylor 1955)."""
    nbar = TAYLOR_NBAR
    a2 = (np.arccosh(10.0 ** (TAYLOR_SIDELOBE_DB / 20.0)) / np.pi) ** 2
    sigma2 = nbar**2 / (a2 + (nbar - 0.5) ** 2)
    m = np.arange(1, nbar)
    n = np.arange(nbar)
    column = n[:, None]
    zeros = np.prod(1.0 - column**2 / (sigma2 * (a2 + (m - 0.5) ** 2)), axis=1)
    others = np.where(m == column, 1.0, 1.0 - column**2 / m**2).prod(axis=1)
    own = np.where(n == 0, 1.0, 0.5 * (-1.0) ** (n + 1))  # sinc(u) / (1 - u^2 / n^2) as u goes to n
    coefficients: Floats = zeros / others * own
    half_power = brentq(lambda u: float(_taylor_field(np.asarray(u), coefficients)) - np.sqrt(0.5), 0.1, 1.5)
    return coefficients, float(half_power)


def _taylor_field(u: Floats, coefficients: Floats) -> Floats:
    """Voltage pattern as a sum of shifted sincs, which has no removable singularities to step around."""
    field: Floats = np.asarray(coefficients[0] * np.sinc(u))
    for n, weight in enumerate(coefficients[1:], start=1):
        field = field + weight * (np.sinc(u - n) + np.sinc(u + n))
    return field
