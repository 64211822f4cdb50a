"""Fluctuating cross-sections as single azimuths meet them."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from radar_service.random import FLUCTUATION, generator
from radar_service.scattering.swerling import per_azimuth, swerling_factor
from radar_service.scene.world import Body

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
BLOCK = 16  # azimuths drawn together


class Fluctuation:
    """The draws of all fluctuating bodies (B,); key: (B,) index of each in the scene."""

    def __init__(self, bodies: Sequence[Body], key: Indices, azimuths: int, seed: int) -> None:
        self._case = np.array([body.swerling for body in bodies], dtype=np.int64)
        self._key, self._azimuths, self._seed = key, azimuths, seed
        self._draw = lru_cache(maxsize=16 * max(1, len(bodies)))(self._drawn)

    def apply(self, weight: NDArray[np.float32], number: Indices, azimuth: Floats, body: Indices) -> None:
        """Multiplies weights (E, K) of echoes at `azimuth` (E,) [rad] on `body` (E,) by their amplitude factors at azimuths
        numbered from the start (K,).

        Slow cases are drawn once per crossing of the beam, which is counted from where the beam looks the other way, so that
        no target changes under it.
        """
        if not self._case.any():
            return
        for b in np.flatnonzero(np.bincount(body, minlength=len(self._case)) * self._case):
            mine = np.flatnonzero(body == b)
            if per_azimuth(int(self._case[b])):
                weight[mine] *= np.array([self._draw(int(b), int(n) // BLOCK)[int(n) % BLOCK] for n in number], np.float32)
                continue
            fraction = azimuth[mine[0]] % (2.0 * np.pi) / (2.0 * np.pi)
            crossing = np.floor(number / self._azimuths - fraction + 1.5).astype(np.int64)
            weight[mine] *= np.array([self._draw(int(b), int(draw))[0] for draw in crossing], np.float32)

    def _drawn(self, body: int, draw: int) -> tuple[float, ...]:
        """Amplitude factors of a crossing, or of BLOCK azimuths: making a generator costs as much as some 30 draws."""
        rng, case = generator(self._seed, FLUCTUATION, int(self._key[body]), draw), int(self._case[body])
        return tuple(float(np.sqrt(swerling_factor(case, rng))) for _ in range(BLOCK if per_azimuth(case) else 1))
