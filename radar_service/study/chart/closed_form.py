"""The reference of the signal chain: the compressed pulse in closed form under the exact beam, echo by echo.

It shares no code with the chain: it has no samples, transforms or kernels, and its own windows and patterns.
"""

import numpy as np
from scipy.special import ndtr

from radar_service.echo.echoes import Echoes
from radar_service.numerics.types import Complexes, Floats
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.parameters import Radar
from radar_service.radar.patterns import Cosine, Cosine2, Gaussian, Printed, Sinc2, Taylor
from radar_service.study.compressed_pulse import (
    compressed_chirp,
    compressed_nonlinear_chirp,
    tapered_pulse,
)

LIGHT = 299_792_458.0
ECHOES_PER_BATCH = 128
SINGULARITY_STEP = 1e-8  # distance kept from removable singularities: -160 dB
LineSource = Sinc2 | Cosine | Cosine2 | Taylor


def compressed_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns the compressed unit echo at `delay` [s] from its peak, any shape; a chirp gives 0 beyond a pulse length."""
    if radar.modulation == "none":
        return unmodulated_pulse(delay, radar)
    if radar.compression == "inverse":
        return tapered_pulse(delay, radar.bandwidth, radar.window)
    if radar.modulation == "nlfm":
        return compressed_nonlinear_chirp(delay, radar.bandwidth, radar.pulse, radar.window)
    return compressed_chirp(delay, radar.bandwidth, radar.pulse, radar.window)


def unmodulated_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns an unmodulated pulse after a Gaussian filter of half-power bandwidth B, 1 at its middle.

    It is a difference of two normal integrals with the standard deviation sqrt(ln 2) / (pi B) of the impulse response.
    """
    half = radar.pulse / 2.0 * np.pi * radar.bandwidth / np.sqrt(np.log(2.0))
    x = 2.0 * half * delay / radar.pulse
    return np.asarray((ndtr(x + half) - ndtr(x - half)) / (2.0 * ndtr(half) - 1.0), dtype=np.complex128)


def beam(offset: Floats, beamwidth: float, pattern: AntennaPattern) -> Floats:
    """Returns the one-way power gain relative to boresight at `offset` [rad], any shape.

    A pattern without a formula here, such as a table, uses its own gain.
    """
    wrapped = np.angle(np.exp(1j * offset))
    match pattern:
        case Gaussian():
            return np.asarray(0.5 ** ((2.0 * wrapped / beamwidth) ** 2))
        case Printed():
            return np.asarray(np.sinc(2.783 * wrapped / beamwidth) ** 2)
        case Sinc2() | Cosine() | Cosine2() | Taylor():
            return np.asarray(aperture(2.0 * _half_power(pattern) * wrapped / beamwidth, pattern) ** 2)
    return pattern.gain(wrapped, beamwidth)


def _half_power(pattern: LineSource) -> float:
    """Returns the u at which the power of a line source is half of its peak, by bisection."""
    low, high = 0.3, 1.0  # half power of every aperture here lies between, in wavelengths over its length
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if aperture(np.array([middle]), pattern)[0] ** 2 > 0.5 else (low, middle)
    return low


def aperture(u: Floats, pattern: LineSource) -> Floats:
    """Returns the far field of a line source at u = (length / wavelength) sin(offset), 1 at 0.

    Sources: Balanis 2016; Taylor 1955.
    """
    shifted = u + 2.0 * SINGULARITY_STEP * (np.abs(u - np.rint(u)) < SINGULARITY_STEP)
    match pattern:
        case Sinc2():
            return np.asarray(np.sinc(u))
        case Cosine():
            halves = u + SINGULARITY_STEP * (np.abs(np.abs(u) - 0.5) < SINGULARITY_STEP)
            return np.asarray(np.cos(np.pi * halves) / (1.0 - 4.0 * halves**2))
        case Cosine2():
            return np.asarray(np.sinc(shifted) / (1.0 - shifted**2))
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
