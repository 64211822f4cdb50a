"""A nonlinear chirp of constant amplitude, whose power spectrum is a taper by the principle of stationary phase.

The chirp stays at each frequency for as long as the taper asks, so the group delay is the running integral of the taper. It costs
no signal to noise, where a window on a linear chirp does. Source: Cook and Bernfeld 1967, chapter 3.

The taper over the band is a cosine sum, W(f) = sum a_m cos(2 pi m f / B) for |f| <= B/2.
"""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import scipy.fft

from radar_service.numerics.types import Complexes, Floats

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

TABLE = 2**16  # frequencies of the table of delays: the phase is stationary in them, so it errs by less than 1e-6 rad
OVERSAMPLING = 16  # samples of the pulse per 1/B: sums over them, with their ends corrected, err by less than -110 dB
PADDING = 4  # of its transform: splines of fifth order between frequencies err by less than -90 dB


def group_delay(frequency: Floats, bandwidth: float, pulse: float, taper: Floats) -> Floats:
    """Time [s] from the middle of the pulse at which the chirp passes `frequency` [Hz], any shape, |frequency| <= B/2.

    taper: (M,) coefficients a_m. Source: Cook and Bernfeld 1967, eq. 3.41.
    """
    share = frequency / bandwidth
    order = np.arange(1, len(taper))
    terms = (a / (2.0 * np.pi * m) * np.sin(2.0 * np.pi * m * share) for m, a in zip(order, taper[1:], strict=True))
    return np.asarray(pulse * (share + sum(terms, np.zeros_like(share)) / taper[0]))


def nonlinear_chirp(time: Floats, bandwidth: float, pulse: float, taper: Floats) -> Complexes:
    """The chirp exp(j phi(t)) at times [s] of any shape, |time| <= T/2, with phi(0) = 0.

    The phase is 2 pi (f t - integral of the group delay from 0 to f) at the frequency f of that time (Legendre transform).
    """
    half = 0.5 * bandwidth * np.sin(np.linspace(-0.5, 0.5, TABLE) * np.pi)  # dense at the edges, which pass quickly
    frequency = np.interp(time, group_delay(half, bandwidth, pulse, taper), half)
    integral = frequency**2 / (2.0 * bandwidth)
    for m, a in enumerate(taper[1:], start=1):
        turn = 2.0 * np.pi * m / bandwidth
        integral += a / taper[0] * (1.0 - np.cos(turn * frequency)) / (turn * 2.0 * np.pi * m)
    wave: Complexes = np.exp(2j * np.pi * (frequency * time - pulse * integral))
    return wave


def nonlinear_chirp_spectrum(frequency: Floats, bandwidth: float, pulse: float, taper: Floats) -> Complexes:
    """Fourier transform [s] of the chirp at `frequency` [Hz] of any shape.

    A sum over samples of the pulse, interpolated between frequencies. What the sum errs by at the ends of the pulse is corrected:
    there the chirp is a tone of +-B/2. Beyond the band of the samples, these ends are all there is.
    """
    product = float(bandwidth * pulse)
    scaled = np.asarray(frequency, dtype=np.float64) / bandwidth
    inside = np.abs(scaled) < OVERSAMPLING / 4.0
    spectrum = np.zeros(scaled.shape, dtype=np.complex128)
    step = product / _samples(product)
    for sign in (-1.0, 1.0):
        spectrum += sign * _end(scaled, sign, product, tuple(taper.tolist()), np.where(inside, step, 0.0))
    spectrum[inside] += _sum_spline(product, tuple(taper.tolist()))(scaled[inside])
    return np.asarray(spectrum / bandwidth)


def range_doppler_coupling(taper: Floats) -> float:
    """Shift of the compressed echo in cells c / 2B for a Doppler shift of one cycle over the pulse: 1 for a linear chirp.

    It is the slope of the group delay that fits best under the taper, over T / B.
    """
    frequency = (np.arange(TABLE) + 0.5) / TABLE - 0.5
    weight = frequency * sum(a * np.cos(2.0 * np.pi * m * frequency) for m, a in enumerate(taper))
    return float(np.sum(weight * group_delay(frequency, 1.0, 1.0, taper)) / np.sum(weight * frequency))


def _samples(product: float) -> int:
    """Samples of a chirp of this bandwidth x pulse."""
    return int(np.ceil(OVERSAMPLING * product))


def _end(frequency: Floats, sign: float, product: float, taper: tuple[float, ...], step: Floats) -> Complexes:
    """What an end of the pulse adds to the integral over it, less what it adds to a sum in steps [1/B], at frequencies [B]."""
    end = sign * product / 2.0
    value = nonlinear_chirp(np.array([end]), 1.0, product, np.array(taper))[0] * np.exp(-2j * np.pi * frequency * end)
    turn = np.pi * (0.5 * sign - frequency)  # half the phase per unit of time
    turn = np.where(np.abs(turn) < 1e-6, 1e-6, turn)  # both terms are equal there to 1e-6
    with np.errstate(divide="ignore", invalid="ignore"):
        summed = np.where(step > 0.0, step / np.sin(turn * np.where(step > 0.0, step, 1.0)), 0.0)
    return np.asarray(value * (1.0 / turn - summed) / 2j)


@lru_cache(maxsize=16)
def _sum_spline(product: float, taper: tuple[float, ...]) -> "BSpline":
    """The sum over the samples of a chirp, times their step [1/B], as a function of frequency [B]."""
    count = _samples(product)
    step = product / count
    size = int(scipy.fft.next_fast_len(PADDING * count))
    time = np.asarray((np.arange(count) + 0.5) * step - product / 2.0, dtype=np.float64)
    wave = nonlinear_chirp(time, 1.0, product, np.array(taper))
    frequency = scipy.fft.fftshift(scipy.fft.fftfreq(size, step))
    spectrum = scipy.fft.fftshift(scipy.fft.fft(wave, size)) * step * np.exp(-2j * np.pi * frequency * time[0])
    near = np.abs(frequency) <= OVERSAMPLING / 4.0 + 0.1
    from scipy.interpolate import make_interp_spline  # here: it takes 0.2 s, which other scenes need not wait for

    return make_interp_spline(frequency[near], spectrum[near], k=5)
