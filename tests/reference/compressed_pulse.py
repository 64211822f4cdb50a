"""Slow reference: the field of point targets by closed form, sharing no code with the engine.

The matched-filter output of an LFM chirp with a cosine-sum window is an integral of exponentials over the overlap of the
pulse with its shifted reference, so it has a closed form (sums of sinc terms); no sampling and no FFT. Author: this project,
derived from the definition y(tau) = int s(t) conj(w(t - tau) s(t - tau)) dt / int w dt with s(t) = exp(j pi K t^2).
"""

import numpy as np
from numpy.typing import NDArray

LIGHT = 299_792_458.0


def compressed_pulse(
    delay: NDArray[np.float64],
    bandwidth: float,
    pulse: float,
    window: tuple[float, ...],
    received_from: NDArray[np.float64] | float = -np.inf,
) -> NDArray[np.complex128]:
    """The compressed unit echo at `delay` [s] from its peak; window: cosine coefficients a_m about the centre.

    received_from: time within the echo, from its middle, before which it is not received [s]: then the overlap begins there.
    """
    result = np.zeros(delay.shape, dtype=np.complex128)
    near = np.abs(delay) < pulse  # beyond, nothing overlaps
    delay, begins = delay[near], np.broadcast_to(received_from, delay.shape)[near]
    slope = bandwidth / pulse
    low = np.maximum(np.maximum(-pulse / 2, -pulse / 2 - delay), begins - delay)
    high = np.minimum(pulse / 2, pulse / 2 - delay)
    length = np.maximum(high - low, 0.0)
    total = np.zeros(delay.shape, dtype=np.complex128)
    for m, a in enumerate(window):
        for sign in (1, -1) if m else (1,):
            tone = slope * delay + sign * m / pulse
            total += (a / 2 if m else a) * length * np.sinc(tone * length) * np.exp(1j * np.pi * tone * (high + low))
    result[near] = np.exp(1j * np.pi * slope * delay**2) * total / (window[0] * pulse)
    return result


def sinc2_beam(offset: NDArray[np.float64], beamwidth: float) -> NDArray[np.float64]:
    """One-way power gain of a sinc^2 beam whose half-power width is `beamwidth`, offset wrapped to +-pi."""
    wrapped = np.angle(np.exp(1j * offset))
    x = 2.783114752 * wrapped / beamwidth / np.pi  # sinc^2 falls to half at pi x = 1.391557376 (offset = beamwidth / 2)
    return np.sinc(x) ** 2


def rows_of(value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (A,) as they are, or the first (1,) for all of them where they are equal."""
    return value[:1] if np.all(value == value[0]) else value


def point_field(
    ranges: NDArray[np.float64],
    boresights: NDArray[np.float64],
    target_range: NDArray[np.float64],
    target_azimuth: NDArray[np.float64],
    amplitude: NDArray[np.float64],
    wavelength: float,
    bandwidth: float,
    pulse: float,
    window: tuple[float, ...],
    beamwidth: float,
) -> NDArray[np.complex128]:
    """Field (A, N) of targets whose range, azimuth and amplitude at each boresight are given as (A, T)."""
    field = np.zeros((len(boresights), len(ranges)), dtype=np.complex128)
    for t in range(target_range.shape[1]):
        r = target_range[:, t]
        delay = 2.0 * (ranges[None, :] - rows_of(r)[:, None]) / LIGHT
        profile = compressed_pulse(delay, bandwidth, pulse, window)
        weight = amplitude[:, t] * sinc2_beam(boresights - target_azimuth[:, t], beamwidth)
        field += (weight * np.exp(-4j * np.pi * r / wavelength))[:, None] * profile
    return field


def in_bins(at: NDArray[np.float64], amplitudes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Sums (B,) of amplitudes (M,) by bin: each is shared linearly by the two bins beside its place `at` (M,) [bins]."""
    low = at.astype(np.int64)
    count = int(low.max()) + 2
    total = np.zeros(count, dtype=np.complex128)
    for index, share in ((low, 1.0 - (at - low)), (low + 1, at - low)):
        weighted = amplitudes * share
        total += np.bincount(index, weighted.real, count) + 1j * np.bincount(index, weighted.imag, count)
    return total
