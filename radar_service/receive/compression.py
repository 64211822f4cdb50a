"""From gridded echoes to compressed profiles: one spectrum along range applies filter, window and kernel correction.

Eclipsing: a one-antenna radar receives nothing while it transmits. What echoes nearer than cT/2 have before the end of the own
pulse is compressed and subtracted, for any number of echoes at once. So the peak falls, widens and moves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.fft

from radar_service.numerics import Complexes, Floats, Profiles, Singles
from radar_service.radar import Radar
from radar_service.receive.gridding import Kernel, Tables, spread_moving
from radar_service.receive.noise import GaussianSpectrum
from radar_service.receive.plain_pulse import (
    PulseKernel,
    plain_filter,
    plain_filter_power,
    plain_noise_power,
    plain_spectrum,
    pulse_kernel,
)

OVERSAMPLING = 3  # of the grid on which the signal is cut: with half the weight on the cut, it errs by -64 dB
Spectrum = Callable[[Floats], Complexes]  # of the frequency [Hz]
FILTER_REACH = {"matched": 1, "inverse": 2}  # pulse lengths: beyond, an inverse filter adds less than -57 dB of an echo
MAX_PULSE_KERNEL = 64  # samples of a plain pulse that is its own kernel; longer pulses fill little of the band


@dataclass(frozen=True)
class Eclipsing:
    """The filter of eclipsed echoes; lengths in samples.

    before: columns before column 0 that kernels cover.
    near: columns, with those before, that contain all eclipsed echoes.
    size: length of the transforms.
    cut: last eclipsed sample of the oversampled grid; it has half weight.
    bins: of the result.
    received: (size,) multiplier from gridded echoes to the received signal.
    compressed: (size,) multiplier from the eclipsed signal to compressed profiles.
    """

    before: int
    near: int
    size: int
    cut: int
    bins: int
    received: Profiles
    compressed: Profiles

    @property
    def transformed(self) -> int:
        """Samples of all Fourier transforms for one profile."""
        return 2 * self.size * (1 + OVERSAMPLING)

    def lost(self, gridded: Profiles) -> Profiles:
        """Compressed profiles (K, bins) of the eclipsed part of echoes gridded on circular rows (K, size of the compression)."""
        near = np.concatenate([gridded[:, gridded.shape[1] - self.before :], gridded[:, : self.near - self.before]], axis=1)
        spectrum = scipy.fft.fft(near, self.size, axis=1) * self.received
        half = (self.size + 1) // 2
        fine = np.zeros((len(gridded), self.size * OVERSAMPLING), dtype=np.complex64)
        fine[:, :half], fine[:, half - self.size :] = spectrum[:, :half], spectrum[:, half:]
        signal = scipy.fft.ifft(fine, axis=1, overwrite_x=True)
        signal[:, self.cut] *= 0.5  # a jump on a sample has half weight: the first order of its aliases cancels
        signal[:, self.cut + 1 :] = 0.0
        eclipsed = scipy.fft.fft(signal, axis=1, overwrite_x=True)
        spectrum[:, :half], spectrum[:, half:] = eclipsed[:, :half], eclipsed[:, half - self.size :]
        return np.asarray(scipy.fft.ifft(spectrum * self.compressed, axis=1)[:, : self.bins])


def eclipsing_for(
    pulse: float,
    fs: float,
    kernel: Kernel,
    transmitted: Callable[[Floats], Complexes],
    filtered: Callable[[Floats], Complexes],
    reach: int = 1,
) -> Eclipsing:
    """The eclipsing filter of a radar.

    pulse: its length [s]; fs: sample rate [Hz]; kernel: with which echoes are spread along range; transmitted: spectrum of the
    pulse [s]; filtered: transfer function of the receiver. Both are functions of frequency [Hz]; their product is the spectrum
    of the compressed pulse. reach: pulse lengths after which the filter's response is over.
    """
    margin = kernel.width
    length = int(np.ceil(pulse * fs))
    size = int(scipy.fft.next_fast_len(2 * reach * length + 4 * margin))
    cut = OVERSAMPLING * (length + margin)
    begin = pulse / 2.0 - cut / (OVERSAMPLING * fs)  # time of the first sample, from the middle of the transmitted pulse
    frequency = scipy.fft.fftfreq(size, 1.0 / fs)
    gridded = transmitted(frequency) / kernel.transform(frequency / fs)
    position = (margin - 0.5) / fs  # column 0 is half a sample from range 0 (docs/conventions.md)
    received = OVERSAMPLING * fs * gridded * np.exp(2j * np.pi * frequency * (begin + position))
    compressed = filtered(frequency) / OVERSAMPLING * np.exp(2j * np.pi * frequency * (0.5 / fs - begin))
    filters = received.astype(np.complex64), compressed.astype(np.complex64)
    return Eclipsing(margin, length + 2 * margin, size, cut, reach * length, *filters)


@dataclass(frozen=True)
class Compression:
    """The processing along range of one radar.

    bins: of a profile.
    size: length of the transforms, with room for the sidelobes (cT/2 each side) of all echoes, so that nothing wraps.
    kernel: with which echoes are spread along range.
    tables: of the kernel.
    echo_filter: (size,) spectrum of the compressed pulse over that of the kernel.
    noise: receiver noise behind the filter, of the sum of the pulses of a spoke where these are integrated.
    eclipsing_filter: removes what a one-antenna radar does not receive of a chirp; None without eclipsing.
    """

    bins: int
    size: int
    kernel: Kernel
    tables: Tables
    echo_filter: Profiles
    noise: GaussianSpectrum
    eclipsing_filter: Eclipsing | None = None

    @property
    def peak_gain(self) -> float:
        """The maximum magnitude of a sample of a profile over the root of the energy of its row, by Cauchy and Schwarz.

        What eclipsing takes away is the profile of a part of the row.
        """
        gain = float(np.sqrt(np.mean(np.abs(self.echo_filter) ** 2)))
        return gain if self.eclipsing_filter is None else 2.0 * gain

    def profiles(self, gridded: Profiles) -> Profiles:
        """Compressed profiles (K, bins) of echoes spread on rows (K, size)."""
        return self.from_spectrum(self.spectrum(gridded))

    def spectrum(self, gridded: Profiles) -> Profiles:
        """Spectra (K, size) of the compressed echoes spread on rows (K, size)."""
        received: Profiles = scipy.fft.fft(gridded, axis=1)
        received *= self.echo_filter
        if self.eclipsing_filter is not None:
            received -= scipy.fft.fft(self.eclipsing_filter.lost(gridded), self.size, axis=1)
        return received

    def joined_spectrum(self, gridded: Profiles | None, other: Profiles | None) -> Profiles | None:
        """Spectra (K, size) of the compressed echoes on rows (K, size) and on others, whose spectra before compression are
        `other` (K, size), which are used up; None without any."""
        if other is None:
            return None if gridded is None else self.spectrum(gridded)
        if self.eclipsing_filter is not None:  # it needs the rows themselves
            rows: Profiles = scipy.fft.ifft(other, axis=1, overwrite_x=True)
            return self.spectrum(rows if gridded is None else rows + gridded)
        other *= self.echo_filter
        if gridded is not None:
            other += self.spectrum(gridded)
        return other

    def transformed(self, gridded: bool, noise: bool) -> int:
        """Samples of all Fourier transforms of one profile; gridded: whether its row has echoes; noise: whether it has noise."""
        forward = self.size if gridded else 0
        if gridded and self.eclipsing_filter is not None:
            forward += self.size + self.eclipsing_filter.transformed
        return forward + (self.size if gridded or noise else 0)

    def spread(self, rows: Profiles, column: Floats, range_migration: Singles, amplitude: Profiles) -> None:
        """Spreads echoes on rows (K, size), contiguous, which are 0 before.

        column: (E,) positions [samples]; range_migration: (E, K) from there [samples]; amplitude: (E, K).
        """
        clipped = np.zeros(len(column), dtype=np.bool_)
        if isinstance(self.kernel, PulseKernel):
            clipped = self.kernel.clips(column + range_migration.min(axis=1, initial=0.0))
        if not clipped.any():
            spread_moving(rows, column, range_migration, amplitude, self.tables)
            return
        spread_moving(rows, column[~clipped], range_migration[~clipped], amplitude[~clipped], self.tables)
        position, number = column[clipped, None] + range_migration[clipped], np.arange(len(rows))
        first, weight = self.kernel.weights(position.ravel())
        cells = (first[:, None] + np.arange(self.kernel.width)) % self.size
        row = np.tile(number, clipped.sum())[:, None]
        np.add.at(rows, (row, cells), amplitude[clipped].reshape(-1, 1) * weight)

    def from_spectrum(self, spectrum: Profiles) -> Profiles:
        """Profiles (K, bins) of spectra (K, size), which are used up."""
        return np.ascontiguousarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)[:, : self.bins])


def receiver_noise_power(radar: Radar) -> float:
    """Power [W] of receiver noise in a sample of the profile, where an echo of unit amplitude peaks at 1."""
    if radar.modulation == "none":
        return plain_noise_power(radar.pulse, radar.bandwidth, radar.noise_factor)
    return radar.chirp.noise_power(radar.noise_factor)


def compression_for(radar: Radar, kernel_width: int) -> Compression:
    """The compression of a radar, with a range kernel of `kernel_width` bins (a short plain pulse is its own kernel)."""
    fs = radar.sample_rate
    kernel = range_kernel(radar, kernel_width)
    pulse_length = int(np.ceil(radar.pulse * fs))
    size = int(scipy.fft.next_fast_len(radar.bins + 2 * pulse_length + kernel.width))
    frequency = scipy.fft.fftfreq(size, 1.0 / fs)
    noise = GaussianSpectrum(noise_spectrum(radar, frequency), receiver_noise_power(radar) / radar.pulses_integrated)
    transmitted, filtered = waveform_spectra(radar)
    own_kernel = isinstance(kernel, PulseKernel)
    pulse = np.ones(size) if own_kernel else fs * transmitted(frequency) * filtered(frequency)
    echo = pulse / kernel.transform(frequency / fs)
    eclipsing_filter = None
    if radar.eclipsing and not own_kernel:
        eclipsing_filter = eclipsing_for(radar.pulse, fs, kernel, transmitted, filtered, FILTER_REACH[radar.compression])
    return Compression(radar.bins, size, kernel, kernel.tables(), echo.astype(np.complex64), noise, eclipsing_filter)


def range_kernel(radar: Radar, width: int) -> Kernel:
    """The kernel with which echoes are spread along range; a short plain pulse is its own kernel."""
    if radar.modulation != "none":
        return Kernel(width, radar.sample_rate / radar.bandwidth)
    own_kernel = pulse_kernel(radar)
    if own_kernel.width <= MAX_PULSE_KERNEL:
        return own_kernel
    # A Gaussian filter is down 60 dB at 2.2 bandwidths from the middle: up to there the kernel must be accurate
    return Kernel(width, max(1.5, radar.sample_rate / (4.4 * radar.bandwidth)))


def waveform_spectra(radar: Radar) -> tuple[Spectrum, Spectrum]:
    """The spectrum of the transmitted pulse [s] and the filter that compresses it to a unit peak, functions of frequency [Hz]."""
    if radar.modulation == "none":
        filtered = partial(plain_filter, pulse=radar.pulse, bandwidth=radar.bandwidth)
        return partial(plain_spectrum, pulse=radar.pulse), filtered
    return radar.chirp.transmitted, radar.chirp.filter


def noise_spectrum(radar: Radar, frequency: Floats) -> Floats:
    """Power spectrum of the sampled noise, any scale. Noise of a plain pulse is sampled behind the filter, so it folds."""
    if radar.modulation != "none":
        return np.asarray(np.abs(radar.chirp.filter(frequency)) ** 2)
    folds = radar.sample_rate * np.arange(-4, 5)
    return np.asarray(plain_filter_power(frequency[:, None] + folds, radar.bandwidth).sum(axis=1))
