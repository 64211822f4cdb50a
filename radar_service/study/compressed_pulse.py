"""The compressed chirp in closed form: the reference of both studies. It shares no code with the engine.

The correlation of a chirp with its windowed copy is a sum of sincs (author: this project):
y(tau) = int s(t) conj(w(t - tau) s(t - tau)) dt / int w dt, s(t) = exp(j pi K t^2). That of a nonlinear chirp has no closed form,
and is a sum over fine samples.
"""

from functools import lru_cache

import numpy as np
import scipy.fft
from scipy.interpolate import BSpline, make_interp_spline
from scipy.signal import windows

from radar_service.numerics import Complexes, Floats

FINE = 64  # samples of a nonlinear chirp per 1/B: the sum over them errs by less than -100 dB
WINDOWS = {  # Harris 1978; Nuttall 1981
    "none": [1.0],
    "hamming": [0.54, 0.46],
    "hann": [0.5, 0.5],
    "blackman": [0.42, 0.5, 0.08],
    "blackman-harris": [0.35875, 0.48829, 0.14128, 0.01168],
    "nuttall": [0.355768, 0.487396, 0.144232, 0.012604],
}


def cosine_coefficients(window: str) -> list[float]:
    """Returns the coefficients of the window's cosine series about its middle; Taylor's come from scipy's samples."""
    if window in WINDOWS:
        return WINDOWS[window]
    count = 256
    samples = windows.taylor(count, nbar=5, sll=35, norm=False)
    x = (np.arange(count) - (count - 1) / 2.0) / count
    return [float(np.mean(samples * np.cos(2 * np.pi * m * x))) * (1 if m == 0 else 2) for m in range(5)]


def compressed_chirp(delay: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Returns the compressed unit echo at `delay` [s] from its peak, any shape; 0 beyond a pulse length.

    bandwidth [Hz]; pulse: length [s]; window: its name in a scene file. About the middle of the overlap the product of the
    chirps is exp(2 pi j K tau x); a cosine is two exponentials.
    """
    slope, coefficients = bandwidth / pulse, cosine_coefficients(window)
    total = np.zeros(delay.shape, dtype=np.complex128)
    overlaps = np.abs(delay) < pulse
    tau = delay[overlaps]
    length = pulse - np.abs(tau)
    part = coefficients[0] * length * np.sinc(slope * tau * length) + 0j
    for m, a in enumerate(coefficients[1:], start=1):
        rotation = np.exp(1j * np.pi * m / pulse * tau)
        above, below = (np.sinc((slope * tau + side * m / pulse) * length) for side in (1, -1))
        part += 0.5 * a * length * (np.conj(rotation) * above + rotation * below)
    total[overlaps] = part / (coefficients[0] * pulse)
    return total


def tapered_pulse(delay: Floats, bandwidth: float, window: str) -> Complexes:
    """Returns the pulse whose spectrum is the window over the band, 1 at its middle: what the inverse filter leaves.

    delay: [s], any shape; bandwidth [Hz]; window: its name in a scene file. A cosine over the band is two sincs.
    """
    coefficients, cells = cosine_coefficients(window), bandwidth * delay
    total = np.zeros(delay.shape, dtype=np.complex128)
    for m, a in enumerate(coefficients):
        total += 0.5 * a / coefficients[0] * (np.sinc(cells + m) + np.sinc(cells - m))
    return total


def nonlinear_chirp_samples(bandwidth: float, pulse: float, window: str) -> tuple[Floats, Complexes]:
    """Returns times (N,) [s] from the middle of a nonlinear chirp, and its samples (N,): the phase is a sum over its frequency.

    The frequency rises through each part of the band for as long as the window weighs it.
    """
    coefficients, count = cosine_coefficients(window), int(np.ceil(FINE * bandwidth * pulse))
    share = np.linspace(-0.5, 0.5, 16 * FINE * FINE + 1)
    passed = share.copy()
    for m, a in enumerate(coefficients[1:], start=1):
        passed += a / coefficients[0] * np.sin(2.0 * np.pi * m * share) / (2.0 * np.pi * m)
    edge = np.interp(np.linspace(-0.5, 0.5, 2 * count + 1), passed, share) * bandwidth  # at the edges and middles of samples
    cycles = (edge[:-2:2] + 4.0 * edge[1:-1:2] + edge[2::2]) / 6.0 * pulse / count  # Simpson's rule, of each sample
    half = (5.0 * edge[:-2:2] + 8.0 * edge[1:-1:2] - edge[2::2]) / 24.0 * pulse / count  # of the same parabola
    phase = 2.0 * np.pi * (np.cumsum(cycles) - cycles + half)
    return ((np.arange(count) + 0.5) / count - 0.5) * pulse, np.exp(1j * phase)


def compressed_nonlinear_chirp(delay: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Returns the correlation of a nonlinear chirp with itself at `delay` [s] from its peak, any shape; 0 beyond a pulse length.

    bandwidth [Hz]; pulse: length [s]; window: the power spectrum of the chirp by the principle of stationary phase.
    """
    inside = np.abs(delay) < pulse
    total = np.zeros(delay.shape, dtype=np.complex128)
    total[inside] = _correlation(float(bandwidth * pulse), window)(delay[inside] / pulse)
    return total


@lru_cache(maxsize=4)
def _correlation(product: float, window: str) -> BSpline:
    """Returns the correlation of a chirp with itself as a function of the delay over the length of the pulse."""
    _, wave = nonlinear_chirp_samples(product, 1.0, window)
    count = len(wave)
    size = int(scipy.fft.next_fast_len(2 * count))
    correlation = scipy.fft.ifft(np.abs(scipy.fft.fft(wave, size)) ** 2)
    lags = np.arange(-count, count + 1)
    return make_interp_spline(lags / count, correlation[lags % size] / count, k=5)
