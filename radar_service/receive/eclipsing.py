"""Eclipsing: a one-antenna radar receives nothing while it transmits.

Echoes nearer than cT/2 are transformed to the received signal. Its part before the end of the own pulse is compressed and
returned, and the receiver subtracts it. So the peak falls, widens and moves as in a real radar. The cost is a few transforms of
two pulse lengths, for any number of echoes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.fft

from radar_service.numerics.types import Complexes, Floats, Profiles
from radar_service.receive.gridding import Kernel

OVERSAMPLING = 3  # of the grid on which the signal is cut: with half the weight on the cut, it errs by -64 dB


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
    return Eclipsing(
        margin,
        length + 2 * margin,
        size,
        cut,
        reach * length,
        received.astype(np.complex64),
        compressed.astype(np.complex64),
    )
