"""Spectra of the transmitted pulse and of the compressed one, without sampling, so that delays are exact.

Convention (docs/conventions.md): chirp on t in [-T/2, T/2], window on the reference, unit echo compresses to a unit peak.

A nonlinear chirp stays at each frequency for as long as a taper of the band asks, so its power spectrum is that taper (Cook and
Bernfeld 1967, chapter 3): W(f) = sum a_m cos(2 pi m f / B) for |f| <= B/2. It costs no signal to noise.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import scipy.fft
from scipy.special import fresnel

from radar_service.numerics import BOLTZMANN, REFERENCE_TEMPERATURE, Complexes, Floats

COSINE_SUMS = {
    "none": (1.0,),
    "hamming": (0.54, 0.46),
    "hann": (0.5, 0.5),
    "blackman": (0.42, 0.5, 0.08),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),  # four terms, -92 dB (Harris 1978)
    "nuttall": (0.355768, 0.487396, 0.144232, 0.012604),  # four terms, -93 dB, continuous slope (Nuttall 1981)
}
TAYLOR_SIDELOBE_DB, TAYLOR_NBAR = 35.0, 5  # the usual choice; -35.19 dB peak sidelobe as a plain window


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


def window_coefficients(name: str) -> Floats:
    """Coefficients a_m of w(t) = sum a_m cos(2 pi m t / T), |t| <= T/2, peak at t = 0.

    name: one of COSINE_SUMS or taylor (Taylor 1955, sidelobes -35 dB, nbar 5). Raises ValueError for any other name.
    """
    if name == "taylor":
        return taylor_coefficients(TAYLOR_SIDELOBE_DB, TAYLOR_NBAR)
    if name not in COSINE_SUMS:
        raise ValueError(f'window: "{name}" is not one of {", ".join(COSINE_SUMS)}, taylor')
    return np.array(COSINE_SUMS[name])


def taylor_coefficients(sidelobe_db: float, nbar: int) -> Floats:
    """Cosine coefficients of the Taylor window with `nbar` - 1 equal sidelobes `sidelobe_db` below the peak.

    Source: T. T. Taylor 1955; Carrara, Goodman and Majewski 1995, appendix D.
    """
    a = np.arccosh(10.0 ** (sidelobe_db / 20.0)) / np.pi
    scale = nbar**2 / (a**2 + (nbar - 0.5) ** 2)
    m = np.arange(1, nbar)
    terms = []
    for k in m:
        numerator = (-1.0) ** (k + 1) * np.prod(1.0 - k**2 / (scale * (a**2 + (m - 0.5) ** 2)))
        denominator = 2.0 * np.prod(1.0 - k**2 / m[m != k] ** 2)
        terms.append(2.0 * numerator / denominator)
    return np.array([1.0, *terms])


def chirp_spectrum(frequency: Floats, bandwidth: float, pulse: float) -> Complexes:
    """Fourier transform [s] of exp(j pi K t^2), |t| <= T/2, K = B/T (docs/specification.md eq. 7), at `frequency` [Hz] of
    any shape.

    The exact Fresnel-integral form (Klauder, Price, Darlington and Albersheim 1960).
    """
    slope = bandwidth / pulse
    root = np.sqrt(2.0 * slope)
    upper_s, upper_c = fresnel(root * (pulse / 2.0 - frequency / slope))
    lower_s, lower_c = fresnel(root * (-pulse / 2.0 - frequency / slope))
    integral = (upper_c - lower_c) + 1j * (upper_s - lower_s)
    spectrum: Complexes = np.exp(-1j * np.pi * frequency**2 / slope) * integral / root
    return spectrum


def reference_spectrum(frequency: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Fourier transform [s] of the windowed chirp: each cosine of the window shifts the chirp by +-m/T."""
    total = np.zeros(np.shape(frequency), dtype=np.complex128)
    for m, a in enumerate(window_coefficients(window)):
        for sign in (-1.0, 1.0):
            total += 0.5 * a * chirp_spectrum(frequency + sign * m / pulse, bandwidth, pulse)
    return total


def matched_filter(frequency: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Transfer function [1] of the compression filter (docs/specification.md eq. 15), scaled so that a unit echo has a unit
    peak."""
    gain = pulse * window_coefficients(window)[0]  # integral of the window over the pulse
    filtered: Complexes = np.conj(reference_spectrum(frequency, bandwidth, pulse, window)) / gain
    return filtered


def tapered_spectrum(frequency: Floats, bandwidth: float, window: str) -> Complexes:
    """Fourier transform [s] of a pulse of unit peak that has the window as its spectrum: sum a_m cos(2 pi m f / B) / (a_0 B) for
    |f| <= B/2 [Hz], and nothing beyond."""
    a, share = window_coefficients(window), np.asarray(frequency) / bandwidth
    total = np.zeros(share.shape, dtype=np.complex128)
    for m, coefficient in enumerate(a):
        total += coefficient * np.cos(2.0 * np.pi * m * share)
    return np.asarray(np.where(np.abs(share) <= 0.5, total, 0.0) / (a[0] * bandwidth))


@dataclass(frozen=True)
class Chirp:
    """A chirp and the filter that compresses it.

    bandwidth: [Hz].
    pulse: its length [s].
    window: on the reference of a linear chirp; the power spectrum of a nonlinear one; the spectrum that "inverse" leaves.
    modulation: "lfm", a linear chirp, or "nlfm", a nonlinear one.
    compression: "matched", or "inverse": the filter W(f) / S(f) within the band, for a pulse of spectrum S and a window W.
    """

    bandwidth: float
    pulse: float
    window: str
    modulation: str = "lfm"
    compression: str = "matched"

    def transmitted(self, frequency: Floats) -> Complexes:
        """Fourier transform [s] of the transmitted pulse at `frequency` [Hz] of any shape."""
        if self.modulation == "lfm":
            return chirp_spectrum(frequency, self.bandwidth, self.pulse)
        return nonlinear_chirp_spectrum(frequency, self.bandwidth, self.pulse, window_coefficients(self.window))

    def filter(self, frequency: Floats) -> Complexes:
        """Transfer function [1] of the compression filter at `frequency` [Hz], scaled so that a unit echo has a unit peak."""
        if self.compression == "inverse":
            return np.asarray(tapered_spectrum(frequency, self.bandwidth, self.window) / self.transmitted(frequency))
        if self.modulation == "lfm":
            return matched_filter(frequency, self.bandwidth, self.pulse, self.window)
        return np.asarray(np.conj(self.transmitted(frequency)) / self.pulse)

    def compressed(self, frequency: Floats) -> Complexes:
        """Fourier transform [s] of the compressed pulse of a unit echo at delay 0, at `frequency` [Hz] of any shape."""
        if self.compression == "inverse":
            return tapered_spectrum(frequency, self.bandwidth, self.window)
        return np.asarray(self.transmitted(frequency) * self.filter(frequency))

    @property
    def doppler_coupling(self) -> float:
        """Shift of an echo in cells c / 2B for a Doppler shift of one cycle over the pulse."""
        return 1.0 if self.modulation == "lfm" else range_doppler_coupling(window_coefficients(self.window))

    def noise_power(self, noise_factor: float) -> float:
        """Power [W] of compressed white receiver noise in a sample: k T0 F times the integral of |filter|^2."""
        if self.compression == "inverse":
            return BOLTZMANN * REFERENCE_TEMPERATURE * noise_factor * _noise_bandwidth(self)
        return noise_power(self.pulse, self.window if self.modulation == "lfm" else "none", noise_factor)


@lru_cache(maxsize=64)
def _noise_bandwidth(chirp: Chirp) -> float:
    """Integral [Hz] of |filter|^2 over the band, by midpoints: 16 and more to a ripple of the pulse's spectrum."""
    count = max(4096, int(np.ceil(16.0 * chirp.bandwidth * chirp.pulse)))
    frequency = ((np.arange(count) + 0.5) / count - 0.5) * chirp.bandwidth
    return float(np.mean(np.abs(chirp.filter(frequency)) ** 2) * chirp.bandwidth)


def noise_power(pulse: float, window: str, noise_factor: float) -> float:
    """Power [W] of compressed white receiver noise in a sample: k T0 F (mean w^2 / (mean w)^2) / T (docs/conventions.md)."""
    a = window_coefficients(window)
    mean_square = a[0] ** 2 + np.sum(a[1:] ** 2) / 2.0
    return float(BOLTZMANN * REFERENCE_TEMPERATURE * noise_factor * mean_square / a[0] ** 2 / pulse)


def pulse_doppler_shift(speed: float, pulse: float, wavelength: float, coupling: float = 1.0) -> float:
    """Returns the range-Doppler shift of a chirp's echo in range cells c / 2B: f_d T = 2 v T / lambda (Skolnik 2001).

    speed: closing speed [m/s]. pulse: length [s]. wavelength [m]. coupling: `Chirp.doppler_coupling`.
    """
    return coupling * 2.0 * speed * pulse / wavelength
