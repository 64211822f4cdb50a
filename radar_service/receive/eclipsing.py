"""Eclipsing: what arrives while a one-antenna radar still transmits is not heard.

The echoes nearer than cT/2 are turned into the signal that would be received, and what of it comes before the end of the
radar's own pulse is compressed and handed back, to be taken away. So the peak falls, widens and moves as it does in a radar,
at the cost of a few transforms of two pulse lengths, however many echoes there are.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.receive.gridding import Kernel

Complexes = NDArray[np.complex128]
Floats = NDArray[np.float64]
Profiles = NDArray[np.complex64]
FINER = 3  # the received signal is cut on a grid this much finer: with half the weight on the cut, it errs by -64 dB


@dataclass(frozen=True)
class Eclipsing:
    """The receiver's silence during transmission; lengths in samples.

    before: columns before the first that kernels reach; near: columns, `before` included, that hold all of the echoes
    concerned; size: of the transforms; cut: last sample of the finer grid, counted half, that is not heard.
    """

    before: int
    near: int
    size: int
    cut: int
    bins: int
    received: NDArray[np.complex64]
    compressed: NDArray[np.complex64]

    @property
    def transformed(self) -> int:
        """Samples of all Fourier transforms for one profile."""
        return 2 * self.size * (1 + FINER)

    def lost(self, gridded: Profiles) -> Profiles:
        """Compressed profiles (K, bins) of what is not heard of echoes laid on circular rows (K, whole size)."""
        near = np.concatenate([gridded[:, gridded.shape[1] - self.before :], gridded[:, : self.near - self.before]], axis=1)
        spectrum = scipy.fft.fft(near, self.size, axis=1) * self.received
        half = (self.size + 1) // 2
        fine = np.zeros((len(gridded), self.size * FINER), dtype=np.complex64)
        fine[:, :half], fine[:, half - self.size :] = spectrum[:, :half], spectrum[:, half:]
        signal = scipy.fft.ifft(fine, axis=1, overwrite_x=True)
        signal[:, self.cut] *= 0.5  # a jump on a sample, counted half: the first order of its aliases cancels
        signal[:, self.cut + 1 :] = 0.0
        unheard = scipy.fft.fft(signal, axis=1, overwrite_x=True)
        spectrum[:, :half], spectrum[:, half:] = unheard[:, :half], unheard[:, half - self.size :]
        return np.asarray(scipy.fft.ifft(spectrum * self.compressed, axis=1)[:, : self.bins])


def eclipsing_for(
    pulse: float, fs: float, kernel: Kernel, sent: Callable[[Floats], Complexes], passed: Callable[[Floats], Complexes]
) -> Eclipsing:
    """The blanking of a radar sampling at `fs` [Hz] that sends pulses [s] of spectrum `sent` [s] through a filter `passed`,
    functions of the frequency [Hz] whose product is the spectrum of the compressed pulse; echoes are laid with `kernel`."""
    margin = kernel.width
    length = int(np.ceil(pulse * fs))
    size = int(scipy.fft.next_fast_len(2 * length + 4 * margin))
    cut = FINER * (length + margin)
    begin = pulse / 2.0 - cut / (FINER * fs)  # time of the first sample, from the middle of the transmitted pulse
    frequency = scipy.fft.fftfreq(size, 1.0 / fs)
    gridded = sent(frequency) / kernel.transform(frequency / fs)
    place = (margin - 0.5) / fs  # column 0 stands half a sample from range 0 (DESIGN section 2)
    received = FINER * fs * gridded * np.exp(2j * np.pi * frequency * (begin + place))
    compressed = passed(frequency) / FINER * np.exp(2j * np.pi * frequency * (0.5 / fs - begin))
    return Eclipsing(
        margin, length + 2 * margin, size, cut, length, received.astype(np.complex64), compressed.astype(np.complex64)
    )
