"""From laid echoes to compressed profiles: one spectrum along range does filter, window and kernel correction."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.radar.parameters import Radar
from radar_service.radar.waveform import chirp_spectrum, matched_filter, noise_power
from radar_service.receive.eclipsing import Eclipsing, eclipsing_for
from radar_service.receive.gridding import Kernel, Tables, spread_moving
from radar_service.receive.noise import GaussianSpectrum
from radar_service.receive.plain_pulse import (
    PulseKernel,
    plain_filter,
    plain_filter_power,
    plain_noise_power,
    plain_sent,
    pulse_kernel,
)

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Profiles = NDArray[np.complex64]
Spectrum = Callable[[Floats], Complexes]  # of the frequency [Hz]
LONGEST_LAID = 64  # samples of a plain pulse that is laid as itself; longer ones leave the band empty enough for a kernel


@dataclass(frozen=True)
class Compression:
    """Everything along range that a radar fixes, made once.

    size: length of the transforms; room is left for the sidelobes (cT/2 each side) of every echo that reaches a bin, so
    that nothing wraps round. echo_multiplier: (size,) for laid echoes; noise: the receiver's, behind the filter; blanking:
    what a one-antenna radar does not hear of a chirp.
    """

    bins: int
    size: int
    kernel: Kernel
    tables: Tables
    echo_multiplier: NDArray[np.complex64]
    noise: GaussianSpectrum
    eclipsing_filter: Eclipsing | None = None

    @property
    def row_bytes(self) -> int:
        """Size of one row of the grid in memory."""
        return self.size * np.dtype(np.complex64).itemsize

    def profiles(self, gridded: Profiles) -> Profiles:
        """Compressed profiles (K, bins) of echoes laid on rows (K, size)."""
        return self.from_spectrum(self.spectrum(gridded))

    def spectrum(self, gridded: Profiles) -> Profiles:
        """Spectra (K, size) of the compressed echoes laid on rows (K, size)."""
        heard = np.asarray(scipy.fft.fft(gridded, axis=1) * self.echo_multiplier)
        if self.eclipsing_filter is not None:
            heard -= scipy.fft.fft(self.eclipsing_filter.lost(gridded), self.size, axis=1)
        return heard

    def transformed(self, gridded: bool, noise: bool) -> int:
        """Samples of all Fourier transforms for one profile with echoes laid on its row, with noise."""
        one_way = (
            0
            if not gridded
            else self.size
            if self.eclipsing_filter is None
            else 2 * self.size + self.eclipsing_filter.transformed
        )
        return one_way + (self.size if gridded or noise else 0)

    def spread(self, rows: Profiles, column: Floats, range_migration: NDArray[np.float32], amplitude: Profiles) -> None:
        """Lays echoes at places `column` (E,) [samples] that drift (E, K) from row to row, of amplitude (E, K), on rows
        (K, size), contiguous, which hold 0 before."""
        clipped = np.zeros(len(column), dtype=np.bool_)
        if isinstance(self.kernel, PulseKernel):
            clipped = self.kernel.clips(column + range_migration.min(axis=1, initial=0.0))
        if not clipped.any():
            spread_moving(rows, column, range_migration, amplitude, self.tables)
            return
        spread_moving(rows, column[~clipped], range_migration[~clipped], amplitude[~clipped], self.tables)
        place, number = column[clipped, None] + range_migration[clipped], np.arange(len(rows))
        first, weight = self.kernel.weights(place.ravel())
        cells = (first[:, None] + np.arange(self.kernel.width)) % self.size
        row = np.tile(number, clipped.sum())[:, None]
        np.add.at(rows, (row, cells), amplitude[clipped].reshape(-1, 1) * weight)

    def from_spectrum(self, spectrum: Profiles) -> Profiles:
        """Profiles (K, bins) of spectra (K, size)."""
        return np.ascontiguousarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)[:, : self.bins])


def receiver_noise_power(radar: Radar) -> float:
    """Power [W] of the receiver's noise in a sample of the profile, where an echo of unit amplitude peaks at 1."""
    if radar.modulation == "none":
        return plain_noise_power(radar.pulse, radar.bandwidth, radar.noise_factor)
    return noise_power(radar.pulse, radar.window, radar.noise_factor)


def compression_for(radar: Radar, kernel_width: int) -> Compression:
    """The compression of a radar, with a range kernel of `kernel_width` bins (a short plain pulse is its own kernel)."""
    fs = radar.sample_rate
    kernel = range_kernel(radar, kernel_width)
    reach = int(np.ceil(radar.pulse * fs))
    size = int(scipy.fft.next_fast_len(radar.bins + 2 * reach + kernel.width))
    frequency = scipy.fft.fftfreq(size, 1.0 / fs)
    noise = GaussianSpectrum(_noise_shape(radar, frequency), receiver_noise_power(radar))
    sent, passed = waveform_spectra(radar)
    itself = isinstance(kernel, PulseKernel)
    pulse = np.ones(size) if itself else fs * sent(frequency) * passed(frequency)
    echo = pulse / kernel.transform(frequency / fs)
    eclipsing_filter = eclipsing_for(radar.pulse, fs, kernel, sent, passed) if radar.eclipsing and not itself else None
    return Compression(radar.bins, size, kernel, kernel.tables(), echo.astype(np.complex64), noise, eclipsing_filter)


def range_kernel(radar: Radar, width: int) -> Kernel:
    """The shape with which echoes are laid along range."""
    if radar.modulation == "lfm":
        return Kernel(width, radar.sample_rate / radar.bandwidth)
    itself = pulse_kernel(radar)
    # A Gaussian filter is down 60 dB at 2.2 bandwidths from the middle: so far the kernel must be right
    return itself if itself.width <= LONGEST_LAID else Kernel(width, max(1.5, radar.sample_rate / (4.4 * radar.bandwidth)))


def waveform_spectra(radar: Radar) -> tuple[Spectrum, Spectrum]:
    """Of the frequency [Hz]: the spectrum of the pulse sent [s], and the filter that compresses it to a unit peak."""
    pulse, bandwidth, window = radar.pulse, radar.bandwidth, radar.window
    if radar.modulation == "none":
        return partial(plain_sent, pulse=pulse), partial(plain_filter, pulse=pulse, bandwidth=bandwidth)
    sent = partial(chirp_spectrum, bandwidth=bandwidth, pulse=pulse)
    return sent, partial(matched_filter, bandwidth=bandwidth, pulse=pulse, window=window)


def _noise_shape(radar: Radar, frequency: Floats) -> Floats:
    """Power spectrum of the sampled noise, any scale; that of a plain pulse's filter folds, as it is sampled behind it."""
    if radar.modulation == "lfm":
        return np.asarray(np.abs(matched_filter(frequency, radar.bandwidth, radar.pulse, radar.window)) ** 2)
    folds = radar.sample_rate * np.arange(-4, 5)
    return np.asarray(plain_filter_power(frequency[:, None] + folds, radar.bandwidth).sum(axis=1))
