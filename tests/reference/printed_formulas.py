"""Formulas of the specification as printed that no stage of the engine has: directions, compressed pulse, point spread."""

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.receive.documented_receiver import spread_sigma


def printed_direction(azimuth: Floats, elevation: Floats) -> Floats:
    """Unit vectors (M, 3) exactly as printed: the azimuth [rad] counts from x counter-clockwise. Source:
    docs/specification.md eq. 6.

    With eqs. 21 and 22, which count from y clockwise, it reflects the picture about the line of 45 degrees
    (docs/specification.md, errata row 8); so the documented chain itself sends its rays along `frames.direction`.
    """
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)  # eq. 6


def printed_response(delay: Floats, bandwidth: float) -> Floats:
    """Predicted |compressed| of an unweighted chirp, |sinc(B tau)|, 1 at delay 0 [s]; holds for B T >> 1.
    docs/specification.md eq. 16."""
    return np.abs(np.sinc(bandwidth * np.asarray(delay)))  # eq. 16


def predicted_psf(range_offset: Floats, azimuth_offset: Floats, range_resolution: float, beamwidth: float) -> Floats:
    """Predicted power of a point around its position, 1 at the point: sinc^2 in range, Gaussian in azimuth. Source:
    docs/specification.md eq. 20.

    range_offset, azimuth_offset: broadcastable [m], [rad]; range_resolution: c / (2B) [m]; beamwidth: [rad]. It is a prediction,
    not a stage. It fits an unweighted chirp; a Hamming reference is 1.47 times as wide (row 11).
    """
    along = np.sinc(np.asarray(range_offset) / range_resolution) ** 2
    across = np.exp(-(np.asarray(azimuth_offset) ** 2) / (2.0 * spread_sigma(beamwidth) ** 2))
    return along * across  # eq. 20
