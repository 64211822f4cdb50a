"""The documented sampler: rays thrown at random into a box of 1.5 beamwidths each side of boresight."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
REACH = 1.5  # beamwidths each side of boresight, seed eqs. 4, 5


def azimuth_offsets(generator: np.random.Generator, count: int, beamwidth: float) -> Floats:
    """Offsets (count,) of the rays from boresight in azimuth [rad], uniform in +-1.5 beamwidths. Source: seed eq. 4."""
    return generator.uniform(-REACH * beamwidth, REACH * beamwidth, count)  # eq. 4


def elevation_offsets(generator: np.random.Generator, count: int, beamwidth_el: float) -> Floats:
    """Offsets (count,) of the rays from the horizontal [rad], uniform in +-1.5 beamwidths. Source: seed eq. 5."""
    return generator.uniform(-REACH * beamwidth_el, REACH * beamwidth_el, count)  # eq. 5


def printed_direction(azimuth: Floats, elevation: Floats) -> Floats:
    """Unit vectors (M, 3) exactly as printed: the azimuth [rad] counts from x counter-clockwise. Source: seed eq. 6.

    With eqs. 21 and 22, which count from y clockwise, it mirrors the picture about the line of 45 degrees (DESIGN row 8);
    so the documented chain itself sends its rays along `frames.direction`.
    """
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)  # eq. 6
