"""The documented receiver: every echo is a whole chirp added at its delay, a matched filter compresses the sum, and a Gaussian
spreads its power over azimuth.

Signals are sampled at the complex rate fs. Sample n, received or compressed, has the range n c / (2 fs).
A unit echo compresses to a unit peak.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, ifft, next_fast_len

from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Floats, Indices
from radar_service.radar import window_coefficients

KERNEL_EXTENT = 6.0  # sigmas kept of the Gaussian: exp(-18) = 1.5e-8 of its peak


def chirp(time: Floats, bandwidth: float, pulse: float) -> Complexes:
    """LFM chirp exp(j pi K t^2) with K = B/T, 0 outside -T/2 <= t <= T/2, from -B/2 to B/2 in frequency. Source:
    docs/specification.md eq. 7.

    time: any shape [s]; bandwidth: [Hz]; pulse: [s].
    """
    slope = bandwidth / pulse
    inside = np.abs(time) <= pulse / 2.0 * (1.0 + 1e-12)  # rounding must not drop the samples on the edge
    return np.where(inside, np.exp(1j * np.pi * slope * time**2), 0.0)  # eq. 7


def pulse_times(pulse: float, sample_rate: float) -> Floats:
    """Times (N,) of the samples of the pulse, N = T fs rounded, symmetric about 0 [s]."""
    count = max(1, round(pulse * sample_rate))
    return (np.arange(count, dtype=np.float64) - (count - 1) / 2.0) / sample_rate


def printed_phase(range: Floats | float, wavelength: float) -> Floats:
    """Phase 4 pi R / lambda [rad] of an echo, with the sign as printed (docs/specification.md, errata row 5). range: any
    shape [m]. docs/specification.md eq. 11."""
    return 4.0 * np.pi * np.asarray(range, dtype=np.float64) / wavelength  # eq. 11


def echo(amplitude: float, phase: float, transmitted: Complexes) -> Complexes:
    """One echo (N,) before its delay: A exp(j phi) s_TX(t). Source: docs/specification.md eq. 13."""
    delayed: Complexes = amplitude * np.exp(1j * phase) * transmitted  # eq. 13
    return delayed


def sample_delay(range: Floats, sample_rate: float) -> Indices:
    """Two-way delay of each range [m] in whole samples, rounded (docs/specification.md, errata row 6)."""
    return np.rint(2.0 * np.asarray(range) / SPEED_OF_LIGHT * sample_rate).astype(np.int64)


def chirp_sum(delay: Indices, amplitude: Floats, phase: Floats, transmitted: Complexes, bins: int) -> Complexes:
    """Received signal (bins + N - 1,): chirp after chirp added at its delay. Source: docs/specification.md eq. 14.

    delay (H,) in samples, those outside 0 to bins - 1 are not received; amplitude (H,); phase (H,) [rad]; transmitted (N,).
    """
    received = np.zeros(bins + transmitted.size - 1, dtype=np.complex128)
    for k in np.flatnonzero((delay >= 0) & (delay < bins)):
        start = int(delay[k])
        received[start : start + transmitted.size] += echo(float(amplitude[k]), float(phase[k]), transmitted)  # eq. 14
    return received


def impulse_sum(delay: Indices, amplitude: Floats, phase: Floats, transmitted: Complexes, bins: int) -> Complexes:
    """`chirp_sum` by the convolution theorem: impulses at the delays, then one chirp over all of them. Same arguments."""
    received = (delay >= 0) & (delay < bins)
    impulses = np.zeros(bins, dtype=np.complex128)
    np.add.at(impulses, delay[received], amplitude[received] * np.exp(1j * phase[received]))
    size = next_fast_len(bins + transmitted.size - 1)
    convolved: Complexes = ifft(fft(impulses, size) * fft(transmitted, size))
    return convolved[: bins + transmitted.size - 1]


def exact_chirp_sum(
    range: Floats, amplitude: Floats, phase: Floats, bandwidth: float, pulse: float, sample_rate: float, bins: int
) -> Complexes:
    """`chirp_sum` with every delay exact: the chirp is evaluated at t - 2R/c for each echo (corrects
    docs/specification.md, errata row 6).

    range (H,) [m], amplitude (H,), phase (H,) [rad]. The slow reference of the corrected engine.
    """
    first = pulse_times(pulse, sample_rate)
    time = first[0] + np.arange(bins + first.size - 1) / sample_rate
    received = np.zeros(time.size, dtype=np.complex128)
    for r, a, p in zip(range, amplitude, phase, strict=True):
        if 0.0 <= 2.0 * r / SPEED_OF_LIGHT * sample_rate <= bins - 1:
            received += echo(float(a), float(p), chirp(time - 2.0 * r / SPEED_OF_LIGHT, bandwidth, pulse))
    return received


def window(name: str, count: int) -> Floats:
    """Window (count,) of that name over the reference, in the n / (N - 1) form of docs/specification.md eq. 17; ValueError
    lists them."""
    if name == "hamming":
        return 0.54 - 0.46 * np.cos(2.0 * np.pi * np.arange(count) / max(count - 1, 1))  # eq. 17
    time = np.arange(count) / max(count - 1, 1) - 0.5
    total = np.zeros(count)
    for m, coefficient in enumerate(window_coefficients(name)):
        total += coefficient * np.cos(2.0 * np.pi * m * time)
    return total


def compress(received: Complexes, transmitted: Complexes, weights: Floats, bins: int) -> Complexes:
    """Matched filter (bins,) by FFT: correlation with the windowed chirp, a unit echo to a unit peak. Source:
    docs/specification.md eq. 15.

    received (bins + N - 1,); transmitted (N,); weights (N,), the window on the reference.
    """
    size = next_fast_len(received.size)
    reference = fft(weights * transmitted, size)
    compressed: Complexes = ifft(fft(received, size) * np.conj(reference))  # eq. 15
    return compressed[:bins] / np.sum(weights)


def detect(field: NDArray[np.complexfloating[Any, Any]]) -> Floats:
    """Power of the compressed field, any shape. Source: docs/specification.md eq. 18."""
    return field.real.astype(np.float64) ** 2 + field.imag.astype(np.float64) ** 2  # eq. 18


def spread_sigma(beamwidth: float) -> float:
    """Standard deviation [rad] of the Gaussian of half-power width `beamwidth` [rad]. Source: docs/specification.md eq. 19,
    text."""
    return beamwidth / 2.355


def beam_spread(power: Floats, beamwidth: float, azimuth_step: float) -> Floats:
    """Power (A, N) convolved along azimuth, circularly, with the Gaussian of the beam. Source: docs/specification.md eq. 19.

    beamwidth, azimuth_step: [rad]. The kernel sums to 1, so it keeps the energy of a scan; its peak is below 1. As the
    rays are weighted by the beam already, this applies the beam a second time (docs/specification.md, errata row 7).
    """
    from scipy.ndimage import convolve1d  # here: `documented` alone uses it, and it would slow every start

    sigma = spread_sigma(beamwidth) / azimuth_step
    extent = int(np.ceil(KERNEL_EXTENT * sigma))
    kernel = np.exp(-0.5 * (np.arange(-extent, extent + 1) / sigma) ** 2)
    return convolve1d(power, kernel / kernel.sum(), axis=0, mode="wrap")  # eq. 19
