"""From laid echoes to compressed profiles: one spectrum along range does filter, window and kernel correction."""

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.receive.grid import Kernel
from radar_service.receive.waveform import compressed_spectrum, matched_filter, noise_power
from radar_service.scene.world import Radar

Floats = NDArray[np.float64]
Profiles = NDArray[np.complex64]
NOISE_FLOOR = (
    1e-5  # noise 50 dB below the filter's middle is not drawn: a third of the draws for a ten-thousandth of the power
)


@dataclass(frozen=True)
class Compression:
    """Everything along range that a radar fixes, made once.

    size: length of the transforms; room is left for the sidelobes (cT/2 each side) of every echo that reaches a bin, so
    that nothing wraps round. echo_multiplier: (size,) for laid echoes; noise_multiplier: for white unit noise, on the
    frequencies `noise_band` that the filter lets through.
    """

    bins: int
    size: int
    kernel: Kernel
    echo_multiplier: NDArray[np.complex64]
    noise_band: NDArray[np.int64]
    noise_multiplier: NDArray[np.float32]

    def profiles(self, laid: Profiles) -> Profiles:
        """Compressed profiles (K, bins) of echoes laid on rows (K, size)."""
        return self.from_spectrum(self.spectrum(laid))

    def spectrum(self, laid: Profiles) -> Profiles:
        """Spectra (K, size) of the compressed echoes laid on rows (K, size)."""
        return np.asarray(scipy.fft.fft(laid, axis=1) * self.echo_multiplier)

    def noise_spectrum(self, rows: int, rng: np.random.Generator) -> Profiles:
        """Spectra (rows, size) of compressed receiver noise: white noise only passes the matched filter."""
        spectrum = np.zeros((rows, self.size), dtype=np.complex64)
        draws = rng.standard_normal((rows, len(self.noise_band), 2), dtype=np.float32).view(np.complex64)[..., 0]
        spectrum[:, self.noise_band] = draws * self.noise_multiplier
        return spectrum

    def from_spectrum(self, spectrum: Profiles) -> Profiles:
        """Profiles (K, bins) of spectra (K, size)."""
        return np.ascontiguousarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)[:, : self.bins])


def compression_for(radar: Radar, kernel_width: int) -> Compression:
    """The compression of a radar, with a range kernel of `kernel_width` bins."""
    fs = radar.sample_rate
    reach = int(np.ceil(radar.pulse * fs))
    size = int(scipy.fft.next_fast_len(radar.bins + 2 * reach + kernel_width))
    frequency = scipy.fft.fftfreq(size, 1.0 / fs)
    kernel = Kernel(kernel_width, fs / radar.bandwidth)
    pulse = compressed_spectrum(frequency, radar.bandwidth, radar.pulse, radar.window)
    echo = fs * pulse / kernel.transform(frequency / fs)
    shape = np.abs(matched_filter(frequency, radar.bandwidth, radar.pulse, radar.window)) ** 2
    band = np.flatnonzero(shape > NOISE_FLOOR * shape.max())
    level = noise_power(radar.pulse, radar.window, radar.noise_factor)
    noise = np.sqrt(level * size**2 * shape[band] / shape[band].sum() / 2.0)  # two draws a sample, each half the power
    return Compression(radar.bins, size, kernel, echo.astype(np.complex64), band, noise.astype(np.float32))
