"""Detection and beam spreading of the specification, and the square law of the engine."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats, Profiles, Singles

KERNEL_EXTENT = 6.0  # sigmas kept of the Gaussian: exp(-18) = 1.5e-8 of its peak


def detect(field: NDArray[np.complexfloating[Any, Any]]) -> Floats:
    """Power of the compressed field, any shape. Source: docs/specification.md eq. 18."""
    return field.real.astype(np.float64) ** 2 + field.imag.astype(np.float64) ** 2  # eq. 18


def square_law(field: Profiles) -> Singles:
    """Power [W] of profiles [sqrt(W)] of any shape, in single precision."""
    return np.asarray(field.real**2 + field.imag**2)


def spread_sigma(beamwidth: float) -> float:
    """Standard deviation [rad] of the Gaussian of half-power width `beamwidth` [rad]. Source: docs/specification.md eq. 19,
    text."""
    return beamwidth / 2.355


def beam_spread(power: Floats, beamwidth: float, azimuth_step: float) -> Floats:
    """Power (A, N) convolved along azimuth, circularly, with the Gaussian of the beam. Source: docs/specification.md eq. 19.

    beamwidth, azimuth_step: [rad]. The kernel sums to 1, so it keeps the energy of a scan; its peak is below 1. As the
    rays are weighted by the beam already, this applies the beam a second time (docs/specification.md, errata row 7).
    """
    from scipy.ndimage import convolve1d  # here: `documented` alone uses it, and it would slow every start

    sigma = spread_sigma(beamwidth) / azimuth_step
    extent = int(np.ceil(KERNEL_EXTENT * sigma))
    kernel = np.exp(-0.5 * (np.arange(-extent, extent + 1) / sigma) ** 2)
    return convolve1d(power, kernel / kernel.sum(), axis=0, mode="wrap")  # eq. 19
