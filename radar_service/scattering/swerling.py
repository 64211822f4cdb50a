"""Fluctuation of declared cross-sections (Swerling 1960)."""

from collections.abc import Sequence

import numpy as np

from radar_service.numerics.random import FLUCTUATION, generator, name_key
from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Floats, Indices, Singles
from radar_service.world.body import Body

DRAWS_PER_BLOCK = 16  # azimuths whose factors are drawn together: setting up a generator costs as much as some 30 draws


def swerling_factor(case: int, rng: np.random.Generator) -> float:
    """A power factor of mean 1 for Swerling cases 0 to 4 (Swerling 1960).

    Exponential for cases 1 and 2, chi-square with four degrees of freedom for 3 and 4, always 1 for case 0 (steady).
    """
    if case == 0:
        return 1.0
    return float(rng.exponential(1.0) if case in (1, 2) else rng.gamma(2.0, 0.5))


def per_azimuth(case: int) -> bool:
    """Whether the cross-section is drawn for each azimuth (cases 2 and 4) rather than for each scan (1 and 3)."""
    return case in (2, 4)


class Fluctuation:
    """The draws of all fluctuating bodies (B,). Safe to call from several threads."""

    def __init__(self, bodies: Sequence[Body], scene: str, azimuths: int, seed: int, radar: str = "") -> None:
        """scene: its name; azimuths: per scan; radar: its id, where a scene has several. Draws depend on the seed and on the
        names of the scene, the body and the radar, so other bodies change none of them."""
        self._case = np.array([body.swerling for body in bodies], dtype=np.int64)
        self._key = [name_key(scene, body.name, radar) for body in bodies]
        self._azimuths, self._seed = azimuths, seed
        self._draws: ResultCache[tuple[int, int], tuple[float, ...]] = ResultCache(16 * max(1, len(bodies)))

    def apply(self, weight: Singles, number: Indices, azimuth: Floats, body: Indices) -> None:
        """Multiplies weights (E, K) by the amplitude factors of their bodies.

        number: (K,) of the azimuths since the start; azimuth: (E,) of the echoes [rad]; body: (E,) of the echoes. Slow cases
        are drawn once per beam crossing. Crossings are counted from the opposite bearing, so that no target changes while
        the beam is on it.
        """
        if not self._case.any():
            return
        for b in np.flatnonzero(np.bincount(body, minlength=len(self._case)) * self._case):
            own = np.flatnonzero(body == b)
            if per_azimuth(int(self._case[b])):
                blocks = (self._block(int(b), int(n) // DRAWS_PER_BLOCK)[int(n) % DRAWS_PER_BLOCK] for n in number)
                weight[own] *= np.array(list(blocks), np.float32)
                continue
            fraction = azimuth[own[0]] % (2.0 * np.pi) / (2.0 * np.pi)
            crossing = np.floor(number / self._azimuths - fraction + 1.5).astype(np.int64)
            first, last = int(crossing[0]), int(crossing[-1])  # mostly the same
            factors = [self._block(int(b), draw)[0] for draw in range(first, last + 1)]
            weight[own] *= np.array(factors, np.float32)[crossing - first]

    def _block(self, body: int, draw: int) -> tuple[float, ...]:
        """Amplitude factors of a crossing, or of DRAWS_PER_BLOCK azimuths."""
        return self._draws.get((body, draw), lambda: self._draw_factors(body, draw))

    def _draw_factors(self, body: int, draw: int) -> tuple[float, ...]:
        rng, case = generator(self._seed, FLUCTUATION, self._key[body], draw), int(self._case[body])
        return tuple(float(np.sqrt(swerling_factor(case, rng))) for _ in range(DRAWS_PER_BLOCK if per_azimuth(case) else 1))
