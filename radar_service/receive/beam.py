"""The beam along azimuth for resting echoes: one circular filter over the full circle, applied once to the complex field."""

import numpy as np
import scipy.fft

from radar_service.numerics import Floats, Gain, Profiles
from radar_service.radar import azimuth_oversampling
from radar_service.receive.gridding import Kernel

PATTERN_SAMPLES = 16  # per grid row: aliases of the narrowest beam are below -100 dB
COLUMNS = 256  # grid columns transformed at a time, so that a tile stays in cache


def azimuth_kernel(beamwidth: float, rows: int, width: int) -> Kernel:
    """The kernel of `width` rows for gridding along azimuth; beamwidth: `aperture_beamwidth` of the pattern [rad]."""
    return Kernel(width, azimuth_oversampling(beamwidth, rows))


def beam_spectrum(gain: Gain, rows: int) -> Floats:
    """Multipliers (rows,) that filter the transform of points along azimuth with the beam.

    They are `rows` times the Fourier coefficients of the pattern around the full circle, in FFT order.
    """
    count = rows * PATTERN_SAMPLES
    angle = 2.0 * np.pi * np.arange(count) / count
    offset = (angle + np.pi) % (2.0 * np.pi) - np.pi
    coefficients = scipy.fft.fft(gain(offset)).real / count
    order = np.rint(scipy.fft.fftfreq(rows) * rows).astype(np.int64)
    return coefficients[order % count] * rows


def beam_filter(grid: Profiles, gain: Gain, kernel: Kernel, azimuths: int) -> Profiles:
    """The field (azimuths, columns) in the beam at each azimuth, of points spread on `grid` (rows, columns).

    Rows divide the full circle evenly; their number is a multiple of `azimuths`. Row 0 points along azimuth 0.
    """
    rows, columns = grid.shape
    frequency = scipy.fft.fftfreq(rows)
    multiplier = (beam_spectrum(gain, rows) / kernel.transform(frequency)).astype(np.float32)
    filtered = np.empty((azimuths, columns), dtype=np.complex64)
    for start in range(0, columns, COLUMNS):
        tile = np.ascontiguousarray(grid[:, start : start + COLUMNS].T)
        spectrum = scipy.fft.fft(tile, axis=1, overwrite_x=True) * multiplier
        fields = scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)
        filtered[:, start : start + COLUMNS] = fields[:, :: rows // azimuths].T
    return filtered
