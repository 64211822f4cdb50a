"""Stationary complex Gaussian noise of a given power spectrum, drawn as spectra: filtered white numbers."""

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Floats, Profiles, quantiles

MIN_POWER = 1e-5  # of the maximum; weaker frequencies are not drawn: a third of the draws, 1e-4 of the power


class GaussianSpectrum:
    """Draws spectra of rows of noise."""

    def __init__(self, shape: Floats, power: float) -> None:
        """shape: (size,) power spectrum in FFT order, any scale; power: mean square of a sample of the rows."""
        size = len(shape)
        kept = np.where(shape > MIN_POWER * shape.max(), shape, 0.0)
        weight = np.sqrt(power * size**2 * kept / kept.sum() / 2.0)  # two draws per sample, each with half the power
        signed = np.rint(np.fft.fftfreq(size) * size)[kept > 0.0]
        above, below = int(signed.max(initial=-1.0)) + 1, -int(signed.min(initial=0.0))
        self._size, self._above = size, 2 * above
        self._weight = np.repeat(np.concatenate([weight[:above], weight[size - below :]]), 2).astype(np.float32)

    def draw(self, rows: int, rng: np.random.Generator) -> Profiles:
        """Spectra (rows, size). rng: new, of SFC64, which stays as it is."""
        spectrum = np.empty((rows, self._size), dtype=np.complex64)
        self._write(spectrum, rng, 0)
        return spectrum

    def add(self, spectrum: Profiles, rng: np.random.Generator) -> None:
        """Adds noise spectra to `spectrum` (rows, size)."""
        self._write(spectrum, rng, 1)

    def _write(self, spectrum: Profiles, rng: np.random.Generator, adds: int) -> None:
        """Writes weighted draws, or adds them."""
        rows, count = len(spectrum), len(self._weight)
        state = rng.bit_generator.state["state"]["state"].view(np.int64)
        sizes = rows, self._above, 2 * self._size - count, count - self._above, adds
        KERNELS.weighted_normals(*sizes, state, quantiles(), self._weight, spectrum.view(np.float32))


def integrate(field: Profiles, pulses: int, power: float, rng: np.random.Generator) -> None:
    """Gives profiles (K, bins), in place, the power that the mean over `pulses` pulses with the same echoes has, and the phase
    of their sum.

    field: with noise of power / pulses; power: of the noise of one pulse. The mean of |s + n|^2 is |s + mean n|^2 plus the
    variance of n, which is independent and has a gamma law of pulses - 1 looks; its samples are drawn as uncorrelated.
    """
    variance = rng.standard_gamma(pulses - 1, field.shape, dtype=np.float32) * np.float32(power / pulses)
    field *= np.sqrt(1.0 + variance / np.maximum(field.real**2 + field.imag**2, np.float32(1e-37)))
