"""The compressed chirp in closed form: the reference of both studies. It shares no code with the engine.

The correlation of a chirp with its windowed copy is an integral of exponentials over their overlap, so it is a sum of sincs:
y(tau) = int s(t) conj(w(t - tau) s(t - tau)) dt / int w dt, s(t) = exp(j pi K t^2). It needs neither samples nor transforms, and
its error is that of rounding. Author: this project.
"""

import numpy as np
from scipy.signal import windows

from radar_service.types import Complexes, Floats

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
