"""The Kaiser-Bessel kernel with which points are spread on a regular grid: its shape and its Fourier transform."""

import numpy as np

from radar_service.numerics.types import Floats

MIN_OVERSAMPLING = 1.1  # below, the kernel degenerates; the error is then that of the grid itself


def shape_parameter(width: int, oversampling: float) -> float:
    """Beta of a kernel of `width` samples on a grid oversampled `oversampling` times.

    Source: Beatty, Nishimura and Pauly 2005, eq. 5.
    """
    s = max(oversampling, MIN_OVERSAMPLING)
    return float(np.pi * np.sqrt(max((width / s) ** 2 * (s - 0.5) ** 2 - 0.8, 0.1)))


def kernel_transform(frequency: Floats, width: int, beta: float) -> Floats:
    """The Fourier transform [samples] of a kernel of unit peak at `frequency` [cycles per sample] of any shape."""
    root = np.sqrt(np.asarray(beta**2 - (np.pi * width * frequency) ** 2, dtype=np.complex128))
    ratio = np.where(np.abs(root) > 1e-9, np.sinh(root) / np.where(root == 0, 1.0, root), 1.0)
    return np.asarray(width * ratio.real / np.i0(beta), dtype=np.float64)
