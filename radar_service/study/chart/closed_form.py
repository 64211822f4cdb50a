"""The reference of the signal chain: the compressed pulse in closed form under the exact beam, echo by echo.

It shares no code with the chain: it has no samples, transforms or kernels, and its own windows and patterns. The
correlation of a chirp with its windowed copy is an integral of exponentials over their overlap, so it is a sum of sincs:
y(tau) = int s(t) conj(w(t - tau) s(t - tau)) dt / int w dt, s(t) = exp(j pi K t^2). Author: this project.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import windows
from scipy.special import ndtr

from radar_service.propagation.radar_equation import Echoes
from radar_service.scene.world import Pattern, Radar, Taylor

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
LIGHT = 299_792_458.0
ECHOES_PER_BATCH = 128
SINGULARITY_STEP = 1e-8  # distance kept from removable singularities: -160 dB
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


def compressed_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns the compressed unit echo at `delay` [s] from its peak, any shape; a chirp gives 0 beyond a pulse length.

    About the middle of the overlap the product of the chirps is exp(2 pi j K tau x); a cosine is two exponentials.
    """
    if radar.modulation == "none":
        return unmodulated_pulse(delay, radar)
    slope, pulse, coefficients = radar.bandwidth / radar.pulse, radar.pulse, cosine_coefficients(radar.window)
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


def unmodulated_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns an unmodulated pulse after a Gaussian filter of half-power bandwidth B, 1 at its middle.

    It is a difference of two normal integrals with the standard deviation sqrt(ln 2) / (pi B) of the impulse response.
    """
    half = radar.pulse / 2.0 * np.pi * radar.bandwidth / np.sqrt(np.log(2.0))
    x = 2.0 * half * delay / radar.pulse
    return np.asarray((ndtr(x + half) - ndtr(x - half)) / (2.0 * ndtr(half) - 1.0), dtype=np.complex128)


def beam(offset: Floats, beamwidth: float, pattern: Pattern) -> Floats:
    """Returns the one-way power gain relative to boresight at `offset` [rad], any shape.

    Raises ValueError for an unknown pattern.
    """
    wrapped = np.angle(np.exp(1j * offset))
    if not isinstance(pattern, str | Taylor):
        rows = np.array(pattern)
        return np.asarray(np.exp(np.interp(np.abs(wrapped), rows[:, 0], np.log(np.maximum(rows[:, 1], 1e-30)))))
    if pattern == "gaussian":
        return np.asarray(0.5 ** ((2.0 * wrapped / beamwidth) ** 2))
    if pattern == "printed":
        return np.asarray(np.sinc(2.783 * wrapped / beamwidth) ** 2)
    low, high = 0.3, 1.0  # half power of every aperture here lies between, in wavelengths over its length
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if aperture(np.array([middle]), pattern)[0] ** 2 > 0.5 else (low, middle)
    return np.asarray(aperture(2.0 * low * wrapped / beamwidth, pattern) ** 2)


def aperture(u: Floats, pattern: str | Taylor) -> Floats:
    """Returns the far field of a line source at u = (length / wavelength) sin(offset), 1 at 0.

    Raises ValueError for an unknown pattern. Sources: Balanis 2016; Taylor 1955.
    """
    if pattern == "sinc2":
        return np.asarray(np.sinc(u))
    if pattern == "cosine":
        shifted = u + SINGULARITY_STEP * (np.abs(np.abs(u) - 0.5) < SINGULARITY_STEP)
        return np.asarray(np.cos(np.pi * shifted) / (1.0 - 4.0 * shifted**2))
    shifted = u + 2.0 * SINGULARITY_STEP * (np.abs(u - np.rint(u)) < SINGULARITY_STEP)
    if pattern == "cosine2":
        return np.asarray(np.sinc(shifted) / (1.0 - shifted**2))
    if pattern == "taylor":
        pattern = Taylor(30.0, 4)
    if not isinstance(pattern, Taylor):
        raise ValueError(f'pattern: the reference has sinc2, printed, gaussian, taylor, cosine and cosine2, not "{pattern}"')
    n = np.arange(1, pattern.nbar)
    a = np.arccosh(10.0 ** (pattern.sidelobe_db / 20.0)) / np.pi
    zeros = pattern.nbar * np.sqrt((a**2 + (n - 0.5) ** 2) / (a**2 + (pattern.nbar - 0.5) ** 2))
    field = np.sinc(shifted)
    for zero, sinc_zero in zip(zeros, n, strict=True):
        field = field * (1.0 - (shifted / zero) ** 2) / (1.0 - (shifted / sinc_zero) ** 2)
    return np.asarray(field)


def closed_form_field(echoes: Echoes, radar: Radar, boresight: Floats, sample_range: Floats) -> Complexes:
    """Returns the field (K, N) [sqrt(W)] of echoes (E,) at boresights (K,) [rad] and ranges (N,) [m]."""
    field = np.zeros((len(boresight), len(sample_range)), dtype=np.complex128)
    for i in range(0, len(echoes.range), ECHOES_PER_BATCH):
        part = slice(i, i + ECHOES_PER_BATCH)
        delay = 2.0 * (sample_range - echoes.range[part, None]) / LIGHT
        weight = beam(boresight[:, None] - echoes.azimuth[part], radar.beamwidth, radar.pattern) * echoes.amplitude[part]
        field += weight @ compressed_pulse(delay, radar)
    return field


def closed_form_error_db(radar: Radar) -> float:
    """Returns the largest difference of the closed form from its integral at 41 delays [dB of the peak]."""
    delay = np.linspace(-0.99, 0.99, 41) * radar.pulse
    integral = _unmodulated_integral if radar.modulation == "none" else _chirp_integral
    values = np.array([integral(float(tau), radar) for tau in delay])
    return float(20.0 * np.log10(np.abs(values - compressed_pulse(delay, radar)).max() + 1e-16))


def _chirp_integral(tau: float, radar: Radar) -> complex:
    """Returns the correlation at `tau` [s] by 32 Gauss-Legendre nodes on each of B T / 2 + 8 intervals.

    The phase of the integrand changes by at most half a cycle in an interval, so the error is the rounding of 64 bits.
    """
    edges = np.linspace(max(0.0, tau), min(0.0, tau) + radar.pulse, int(radar.bandwidth * radar.pulse / 2.0) + 9)
    t, weights = _nodes(edges - radar.pulse / 2.0)
    slope, coefficients = radar.bandwidth / radar.pulse, cosine_coefficients(radar.window)
    window = sum(a * np.cos(2.0 * np.pi * m * (t - tau) / radar.pulse) for m, a in enumerate(coefficients))
    product = window * np.exp(1j * np.pi * slope * (t**2 - (t - tau) ** 2))
    return complex(np.sum(product * weights) / (coefficients[0] * radar.pulse))


def _unmodulated_integral(tau: float, radar: Radar) -> complex:
    """Returns the pulse convolved with the impulse response exp(-(pi B t)^2 / (2 ln 2)), at `tau` [s] over that at 0.

    The response is the transform of exp(-2 ln 2 (f / B)^2); the intervals are as short as the response.
    """

    def convolved(at: float) -> float:
        t, weights = _nodes(np.linspace(-0.5, 0.5, int(radar.bandwidth * radar.pulse) + 9) * radar.pulse)
        return float(np.sum(weights * np.exp(-((np.pi * radar.bandwidth * (at - t)) ** 2) / (2.0 * np.log(2.0)))))

    return complex(convolved(tau) / convolved(0.0))


def _nodes(edges: Floats) -> tuple[Floats, Floats]:
    """Returns 32 Gauss-Legendre nodes on each interval between edges, and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    lengths = np.diff(edges)[:, None]
    return edges[:-1, None] + lengths * (nodes + 1.0) / 2.0, weights * lengths / 2.0
