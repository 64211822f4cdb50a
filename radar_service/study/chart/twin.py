"""Reference twin of the signal chain: the compressed pulse in closed form under the exact beam, one echo after another.

It shares no code with the chain: no sampling, no transforms, no kernels, and windows and patterns of its own. What a chirp's
correlation with its windowed self integrates over their overlap are exponentials, so that it is a sum of sincs:
y(tau) = int s(t) conj(w(t - tau) s(t - tau)) dt / int w dt, s(t) = exp(j pi K t^2). Author: this project.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import windows
from scipy.special import ndtr

from radar_service.propagation.radar_equation import Echoes
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.parameters import Radar
from radar_service.radar.patterns import Table, Taylor

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
LIGHT = 299_792_458.0
ECHOES = 128  # at a time
ASIDE = 1e-8  # steps aside from removable singularities: -160 dB
WINDOWS = {  # Harris 1978; Nuttall 1981
    "none": [1.0],
    "hamming": [0.54, 0.46],
    "hann": [0.5, 0.5],
    "blackman": [0.42, 0.5, 0.08],
    "blackman-harris": [0.35875, 0.48829, 0.14128, 0.01168],
    "nuttall": [0.355768, 0.487396, 0.144232, 0.012604],
}


def cosines(window: str) -> list[float]:
    """Coefficients of the window's cosines about its middle; those of Taylor's from scipy's samples of it."""
    if window in WINDOWS:
        return WINDOWS[window]
    count = 256
    samples = windows.taylor(count, nbar=5, sll=35, norm=False)
    turn = (np.arange(count) - (count - 1) / 2.0) / count
    return [float(np.mean(samples * np.cos(2 * np.pi * m * turn))) * (1 if m == 0 else 2) for m in range(5)]


def compressed_pulse(delay: Floats, radar: Radar) -> Complexes:
    """The compressed unit echo at `delay` [s] from its peak, any shape; a chirp's is 0 beyond a pulse length.

    About the middle of the overlap the chirps' product is exp(2 pi j K tau x), and a cosine of the window two exponentials.
    """
    if radar.modulation == "none":
        return plain_pulse(delay, radar)
    slope, pulse, coefficients = radar.bandwidth / radar.pulse, radar.pulse, cosines(radar.window)
    total = np.zeros(delay.shape, dtype=np.complex128)
    heard = np.abs(delay) < pulse
    tau = delay[heard]
    length = pulse - np.abs(tau)
    part = coefficients[0] * length * np.sinc(slope * tau * length) + 0j
    for m, a in enumerate(coefficients[1:], start=1):
        turn = np.exp(1j * np.pi * m / pulse * tau)
        above, below = (np.sinc((slope * tau + side * m / pulse) * length) for side in (1, -1))
        part += 0.5 * a * length * (np.conj(turn) * above + turn * below)
    total[heard] = part / (coefficients[0] * pulse)
    return total


def plain_pulse(delay: Floats, radar: Radar) -> Complexes:
    """A pulse without modulation behind a Gaussian filter of half-power bandwidth B, 1 at its middle: two normal integrals
    with a standard deviation of sqrt(ln 2) / (pi B), the filter's answer to an impulse."""
    half = radar.pulse / 2.0 * np.pi * radar.bandwidth / np.sqrt(np.log(2.0))
    x = 2.0 * half * delay / radar.pulse
    return np.asarray((ndtr(x + half) - ndtr(x - half)) / (2.0 * ndtr(half) - 1.0), dtype=np.complex128)


def beam(offset: Floats, beamwidth: float, pattern: AntennaPattern) -> Floats:
    """One-way power gain relative to boresight at `offset` [rad], any shape. Raises ValueError for an unknown pattern."""
    wrapped = np.angle(np.exp(1j * offset))
    if isinstance(pattern, Table):
        rows = np.array(pattern.rows)
        return np.asarray(np.exp(np.interp(np.abs(wrapped), rows[:, 0], np.log(np.maximum(rows[:, 1], 1e-30)))))
    if pattern.name == "gaussian":
        return np.asarray(0.5 ** ((2.0 * wrapped / beamwidth) ** 2))
    if pattern.name == "printed":
        return np.asarray(np.sinc(2.783 * wrapped / beamwidth) ** 2)
    low, high = 0.3, 1.0  # half power of every aperture here lies between, counted in wavelengths over its length
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if aperture(np.array([middle]), pattern)[0] ** 2 > 0.5 else (low, middle)
    return np.asarray(aperture(2.0 * low * wrapped / beamwidth, pattern) ** 2)


def aperture(u: Floats, pattern: AntennaPattern) -> Floats:
    """Far field of a line source at u = (length / wavelength) sin(offset), 1 at 0. Sources: Balanis 2016; Taylor 1955."""
    if pattern.name == "sinc2":
        return np.asarray(np.sinc(u))
    if pattern.name == "cosine":
        away = u + ASIDE * (np.abs(np.abs(u) - 0.5) < ASIDE)
        return np.asarray(np.cos(np.pi * away) / (1.0 - 4.0 * away**2))
    away = u + 2.0 * ASIDE * (np.abs(u - np.rint(u)) < ASIDE)
    if pattern.name == "cosine2":
        return np.asarray(np.sinc(away) / (1.0 - away**2))
    if not isinstance(pattern, Taylor):
        raise ValueError(
            f'pattern: the reference knows sinc2, printed, gaussian, taylor, cosine, cosine2, not "{pattern.name}"'
        )
    n = np.arange(1, pattern.nbar)
    a = np.arccosh(10.0 ** (pattern.sidelobe_db / 20.0)) / np.pi
    zeros = pattern.nbar * np.sqrt((a**2 + (n - 0.5) ** 2) / (a**2 + (pattern.nbar - 0.5) ** 2))
    field = np.sinc(away)
    for zero, old in zip(zeros, n, strict=True):
        field = field * (1.0 - (away / zero) ** 2) / (1.0 - (away / old) ** 2)
    return np.asarray(field)


def twin_field(echoes: Echoes, radar: Radar, boresight: Floats, places: Floats) -> Complexes:
    """Field (K, N) [sqrt(W)] of echoes (E,) at boresights (K,) [rad], at ranges (N,) [m]."""
    field = np.zeros((len(boresight), len(places)), dtype=np.complex128)
    for i in range(0, len(echoes.range), ECHOES):
        part = slice(i, i + ECHOES)
        delay = 2.0 * (places - echoes.range[part, None]) / LIGHT
        weight = beam(boresight[:, None] - echoes.azimuth[part], radar.beamwidth, radar.pattern) * echoes.amplitude[part]
        field += weight @ compressed_pulse(delay, radar)
    return field


def twin_error_db(radar: Radar) -> float:
    """How far the closed form is at most from its defining integral, relative to its peak [dB], at 41 delays."""
    delay = np.linspace(-0.99, 0.99, 41) * radar.pulse
    integral = _plain_integral if radar.modulation == "none" else _chirp_integral
    found = np.array([integral(float(tau), radar) for tau in delay])
    return float(20.0 * np.log10(np.abs(found - compressed_pulse(delay, radar)).max() + 1e-16))


def _chirp_integral(tau: float, radar: Radar) -> complex:
    """The correlation at `tau` [s] by 32 Gauss-Legendre nodes on each of B T / 2 + 8 pieces, where the integrand turns half
    a cycle a piece at most: the quadrature itself errs at the rounding of 64 bits."""
    edges = np.linspace(max(0.0, tau), min(0.0, tau) + radar.pulse, int(radar.bandwidth * radar.pulse / 2.0) + 9)
    t, weights = _nodes(edges - radar.pulse / 2.0)
    slope, coefficients = radar.bandwidth / radar.pulse, cosines(radar.window)
    window = sum(a * np.cos(2.0 * np.pi * m * (t - tau) / radar.pulse) for m, a in enumerate(coefficients))
    product = window * np.exp(1j * np.pi * slope * (t**2 - (t - tau) ** 2))
    return complex(np.sum(product * weights) / (coefficients[0] * radar.pulse))


def _plain_integral(tau: float, radar: Radar) -> complex:
    """The pulse through the filter's answer exp(-(pi B t)^2 / (2 ln 2)), the transform of exp(-2 ln 2 (f / B)^2), at
    `tau` [s] over that at 0; pieces of the pulse as short as that answer."""

    def heard(at: float) -> float:
        t, weights = _nodes(np.linspace(-0.5, 0.5, int(radar.bandwidth * radar.pulse) + 9) * radar.pulse)
        return float(np.sum(weights * np.exp(-((np.pi * radar.bandwidth * (at - t)) ** 2) / (2.0 * np.log(2.0)))))

    return complex(heard(tau) / heard(0.0))


def _nodes(edges: Floats) -> tuple[Floats, Floats]:
    """32 Gauss-Legendre nodes on each piece between edges, and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    lengths = np.diff(edges)[:, None]
    return edges[:-1, None] + lengths * (nodes + 1.0) / 2.0, weights * lengths / 2.0
