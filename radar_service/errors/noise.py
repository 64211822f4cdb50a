"""Noise of a sensor as a function of time, so that it is the same wherever a run begins.

Correlated noise is that of a first-order Gauss-Markov process: its correlation is exp(-|t| / correlation time), its mean 0.
It is a sum of sinusoids of equal amplitudes and random phases whose frequencies follow the spectrum of that process, a Cauchy
distribution (Shinozuka and Deodatis 1991, spectral representation). The kurtosis of M sinusoids is 3 - 3 / (2 M).
"""

import numpy as np

from radar_service.numerics.random import SENSOR, generator
from radar_service.numerics.types import Floats, Indices

SINUSOIDS = 64  # kurtosis 2.977
BLOCK = 256  # spokes whose independent numbers come from one generator


class SensorNoise:
    """Normal noise of standard deviation 1.

    correlation_time: [s]; 0 for numbers that are independent from spoke to spoke. seed, key: of the random generators.
    """

    def __init__(self, correlation_time: float, seed: int, *key: int) -> None:
        self._seed, self._key = seed, (SENSOR, *key)
        self._frequency = self._phase = np.empty(0)
        if correlation_time > 0.0:
            rng = generator(seed, *self._key)
            share = (np.arange(SINUSOIDS) + rng.random(SINUSOIDS)) / SINUSOIDS  # one in each of as many equal shares
            self._frequency = np.tan(np.pi * (share - 0.5)) / correlation_time  # rad/s
            self._phase = 2.0 * np.pi * rng.random(SINUSOIDS)

    def at(self, number: Indices, time: Floats) -> Floats:
        """Returns the noise (K,) at spokes of these numbers (K,) and times (K,) [s]."""
        if len(self._phase):
            angle = self._frequency * time[:, None] + self._phase
            return np.asarray(np.sqrt(2.0 / SINUSOIDS) * np.cos(angle).sum(axis=1))
        return draws(number, 1, self._seed, *self._key, normal=True)[:, 0]


def draws(number: Indices, columns: int, seed: int, *key: int, normal: bool = False) -> Floats:
    """Returns random numbers (K, columns) for spokes of these numbers (K,): uniform from 0 to 1, or normal."""
    result = np.empty((len(number), columns))
    block = number // BLOCK
    for which in np.unique(block).tolist():
        rng = generator(seed, *key, which)
        table = (rng.standard_normal if normal else rng.random)((BLOCK, columns))
        rows = block == which
        result[rows] = table[number[rows] % BLOCK]
    return result
