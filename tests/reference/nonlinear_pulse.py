"""Slow reference: nonlinear chirps and filters over fine samples, sharing no code with the engine.

The chirp is built from its definition: it stays at each frequency for as long as the taper weighs it, and its phase is the sum of
its frequency over time. Filters work on the transform of these samples. Author: this project, from Cook and Bernfeld 1967.
"""

from functools import lru_cache

import numpy as np
import scipy.signal
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
FINE = 64  # samples per 1/B


def taper(share: Floats, window: tuple[float, ...]) -> Floats:
    """Weight of a frequency, as a share of the band from -1/2 to 1/2; window: cosine coefficients."""
    return np.sum([a * np.cos(2 * np.pi * m * share) for m, a in enumerate(window)], axis=0)


def chirp_samples(bandwidth: float, pulse: float, window: tuple[float, ...], modulation: str) -> tuple[Floats, Complexes]:
    """Times (N,) [s] from the middle of the pulse, each the middle of a step, and the transmitted pulse there."""
    count = int(np.ceil(FINE * bandwidth * pulse)) | 1  # odd, so that one is the middle
    time = ((np.arange(count) + 0.5) / count - 0.5) * pulse
    if modulation == "lfm":
        return time, np.exp(1j * np.pi * bandwidth / pulse * time**2)
    share = np.linspace(-0.5, 0.5, 2**17 + 1)
    passed = cumulative_simpson(taper(share, window), x=share, initial=0.0)
    frequency = np.interp((time / pulse + 0.5) * passed[-1], passed, share) * bandwidth
    phase = 2 * np.pi * cumulative_simpson(frequency, x=time, initial=0.0)
    return time, np.exp(1j * (phase - phase[count // 2]))


@lru_cache(maxsize=8)
def correlation(bandwidth: float, pulse: float, window: tuple[float, ...]) -> CubicSpline:
    """The nonlinear chirp correlated with itself, 1 at delay 0, as a function of the delay [s] up to a pulse length."""
    time, wave = chirp_samples(bandwidth, pulse, window, "nlfm")
    whole = scipy.signal.correlate(wave, wave, method="fft")
    lags = np.arange(1 - len(wave), len(wave)) * (time[1] - time[0])
    return CubicSpline(lags, whole / len(wave))


def tapered_pulse(delay: Floats, bandwidth: float, window: tuple[float, ...]) -> Complexes:
    """The transform of the taper over the band at `delay` [s] of any shape, 1 at 0."""
    cells = np.abs(delay) * bandwidth
    return np.asarray(_tapered(256 * (1 + int(cells.max()) // 256), window)(cells), dtype=np.complex128)


@lru_cache(maxsize=8)
def _tapered(reach: int, window: tuple[float, ...]) -> CubicSpline:
    """The same as a function of the delay in 1/B up to `reach`: a sum over 8 frequencies to a cycle, as the taper ends at zero,
    joined by splines through 16 delays to a cell."""
    count = 8 * reach
    weight = taper(np.arange(-count // 2, count // 2) / count, window)
    cells = np.arange(16 * reach + 1) / 16
    from_edge = np.fft.fft(weight, 16 * count)[: len(cells)]  # with frequencies counted from the edge of the band
    return CubicSpline(cells, (from_edge * np.exp(1j * np.pi * cells)).real / weight.sum())


def eclipsed_echo(
    bandwidth: float, pulse: float, window: tuple[float, ...], modulation: str, compression: str, share: float
) -> tuple[Floats, Complexes]:
    """Delays (N,) [s] from the middle of an echo and its compressed field, where its first 1 - share is not received.

    The filter is conj(S) / T or W / S, on the transform S of the samples, zero-padded to eight pulse lengths.
    """
    time, wave = chirp_samples(bandwidth, pulse, window, modulation)
    step, size = time[1] - time[0], 8 * len(wave)
    received = np.where(time < pulse / 2 - share * pulse, 0.0, wave)
    spectrum, cut = (np.fft.fft(np.pad(each, (0, size - len(each)))) * step for each in (wave, received))
    frequency = np.fft.fftfreq(size, step)
    if compression == "inverse":
        weight = np.where(np.abs(frequency) <= bandwidth / 2, taper(frequency / bandwidth, window), 0.0)
        response = weight / (window[0] * bandwidth) / spectrum
    else:
        response = np.conj(spectrum) / pulse
    return np.fft.fftfreq(size, 1.0 / (size * step)), np.fft.ifft(cut * response) / step
