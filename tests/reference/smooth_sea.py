"""Slow reference: the field over a smooth round sea by Fock's contour integral, and by Recommendation ITU-R P.526.

The integral is summed point by point along a path through the complex plane. It has no modes, no roots and no height gains, so it
shares no code and no step with the engine's series. Author: this project, from Fock, Electromagnetic Diffraction and Propagation
Problems (1965), ch. 10. The formulas of the Recommendation are those of P.526-15, 3.1.1 and 3.2.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import airy

Complexes = NDArray[np.complex128]

LIGHT = 299_792_458.0
EARTH = 4.0 / 3.0 * 6_371_000.0  # m, effective radius
STEPS = 1500  # along the path; 3000 change the field by less than 1e-9 of it
LEFT, RIGHT = -8.0, 40.0  # ends of the path


def contour_field(x: float, first: float, second: float, q: complex) -> complex:
    """One-way field over that of the direct ray in free space, exp(+j w t); distance x above 0.5 and heights in natural units."""
    low, high = min(first, second), max(first, second)
    v, step = np.linspace(LEFT, low + min(RIGHT, 70.0 / x), STEPS, retstep=True)
    left, right = np.logaddexp(0.0, -2.0 * v) / 2.0, np.logaddexp(0.0, v - low)
    t = v - left**2 * np.exp(-0.6j) + 0.4j * right
    slope = 1.0 + 2.0 * left / (1.0 + np.exp(2.0 * v)) * np.exp(-0.6j) + 0.4j / (1.0 + np.exp(low - v))
    outgoing, standing = _wave(t - high, 1)[0], _standing(t, low, q)
    total = complex(np.sum(slope * np.exp(1j * x * t) * outgoing * standing)) * step
    field = np.exp(1j * np.pi / 4.0) * np.sqrt(x / np.pi) * total / 2.0
    direct = (second - first) ** 2 / (4.0 * x) + x * (first + second) / 2.0 - x**3 / 12.0
    return complex(np.conj(field * np.exp(-1j * direct)))


def recommended_loss_db(
    distance: float,
    first: float,
    second: float,
    frequency: float,
    permittivity: float,
    conductivity: float,
    polarization: str,
) -> float:
    """Loss [dB] against free space beyond the horizon: P.526-15, 3.1.1, eqs. 14 to 18 and 21 to 23.

    distance, first, second: of both ends and their heights [m]; frequency: [Hz]; conductivity: [S/m].
    """
    wavelength = LIGHT / frequency
    lossy = 60.0 * wavelength * conductivity
    k = (2.0 * np.pi * EARTH / wavelength) ** (-1.0 / 3.0) * ((permittivity - 1.0) ** 2 + lossy**2) ** -0.25
    k *= np.sqrt(permittivity**2 + lossy**2) if polarization == "v" else 1.0
    beta = (1.0 + 1.6 * k**2 + 0.67 * k**4) / (1.0 + 4.5 * k**2 + 1.53 * k**4)
    x = beta * distance * (np.pi / (wavelength * EARTH**2)) ** (1.0 / 3.0)
    along = 11.0 + 10.0 * np.log10(x) - 17.6 * x if x >= 1.6 else -20.0 * np.log10(x) - 5.6488 * x**1.425
    return -float(along + sum(_height_gain_db(h, wavelength, beta, k) for h in (first, second)))


def _height_gain_db(height: float, wavelength: float, beta: float, k: float) -> float:
    b = beta * 2.0 * beta * height * (np.pi**2 / (wavelength**2 * EARTH)) ** (1.0 / 3.0)
    if b > 2.0:
        gain = 17.6 * np.sqrt(b - 1.1) - 5.0 * np.log10(b - 1.1) - 8.0
    else:
        gain = 20.0 * np.log10(b + 0.1 * b**3)
    return float(max(gain, 2.0 + 20.0 * np.log10(k)))


def _standing(t: Complexes, y: float, q: complex) -> Complexes:
    """What the sea makes of an incoming wave at height y: w2(t - y) less w1(t - y) times (w2' - q w2) / (w1' - q w1) at t."""
    (one, one_slope), (two, two_slope) = _wave(t, 1), _wave(t, -1)
    outgoing, incoming = _wave(t - y, 1)[0], _wave(t - y, -1)[0]
    value, value_slope, _, _ = airy(t)
    below = airy(t - y)[0]
    by_waves = incoming - outgoing * (two_slope - q * two) / (one_slope - q * one)
    by_ai = -2j * np.sqrt(np.pi) * (below - outgoing * (value_slope - q * value) / (one_slope - q * one))
    return np.where(t.real > 0.0, by_ai, by_waves)  # each where it does not cancel


def _wave(t: Complexes, way: int) -> tuple[Complexes, Complexes]:
    """w1 = sqrt(pi) (Bi + j Ai) for way 1, w2 = sqrt(pi) (Bi - j Ai) for -1, and its slope."""
    turn, factor = np.exp(2j * np.pi / 3.0 * way), 2.0 * np.sqrt(np.pi) * np.exp(1j * np.pi / 6.0 * way)
    value, slope, _, _ = airy(t * turn)
    return factor * value, factor * turn * slope
