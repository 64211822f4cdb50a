"""The beam along azimuth for echoes at rest: one circular filter over the whole turn, applied to the complex field once."""

from collections.abc import Callable

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.radar.antenna import azimuth_oversampling
from radar_service.receive.gridding import Kernel

Floats = NDArray[np.float64]
Pattern = Callable[[Floats], Floats]  # offset from boresight [rad] to gain relative to it
FINE = 16  # samples of the pattern per grid row: what lies beyond the band of the finest beam is below -100 dB
COLUMNS = 256  # grid columns transformed at a time, so that a tile stays in cache


def azimuth_kernel(beamwidth: float, rows: int, width: int) -> Kernel:
    """The kernel of `width` rows with which echoes are laid along azimuth on such a grid."""
    return Kernel(width, azimuth_oversampling(beamwidth, rows))


def beam_spectrum(pattern: Pattern, rows: int) -> Floats:
    """Multipliers (rows,) that turn the transform of points along azimuth into that of the beam sweeping over them.

    They are `rows` times the Fourier coefficients of the pattern around the full circle, in FFT order.
    """
    count = rows * FINE
    angle = 2.0 * np.pi * np.arange(count) / count
    offset = (angle + np.pi) % (2.0 * np.pi) - np.pi
    coefficients = scipy.fft.fft(pattern(offset)).real / count
    order = np.rint(scipy.fft.fftfreq(rows) * rows).astype(np.int64)
    return coefficients[order % count] * rows


def sweep(grid: NDArray[np.complex64], pattern: Pattern, kernel: Kernel, azimuths: int) -> NDArray[np.complex64]:
    """The field (azimuths, columns) that the beam sees of points laid on `grid` (rows, columns).

    Rows divide the turn evenly, a whole multiple of `azimuths` of them; row 0 looks along azimuth 0.
    """
    rows, columns = grid.shape
    frequency = scipy.fft.fftfreq(rows)
    multiplier = (beam_spectrum(pattern, rows) / kernel.transform(frequency)).astype(np.float32)
    swept = np.empty((azimuths, columns), dtype=np.complex64)
    for start in range(0, columns, COLUMNS):
        tile = np.ascontiguousarray(grid[:, start : start + COLUMNS].T)
        spectrum = scipy.fft.fft(tile, axis=1, overwrite_x=True) * multiplier
        turned = scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)
        swept[:, start : start + COLUMNS] = turned[:, :: rows // azimuths].T
    return swept
