"""Blocks of spokes without an engine: each number tells its spoke."""

import numpy as np

from radar_service.records.spokes import SpokeBlock


def block_of(first: int, count: int, azimuths: int) -> SpokeBlock:
    """Spokes of one scan, one a second, of 3 cells; power and field are the number of the spoke."""
    number = np.arange(first, first + count, dtype=np.float64)
    azimuth = (number % azimuths) * (2.0 * np.pi / azimuths)
    power = np.repeat(number[:, None], 3, axis=1).astype(np.float32)
    zeros = np.zeros(count)
    return SpokeBlock(
        first, first // azimuths, first % azimuths, number, azimuth, zeros, np.stack([zeros, zeros], axis=1), zeros, zeros,
        np.arange(3.0), 1.0, power.astype(np.complex64), power,
    )  # fmt: skip
