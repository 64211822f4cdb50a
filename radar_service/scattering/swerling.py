"""Fluctuation of declared cross-sections (Swerling 1960)."""

from collections.abc import Sequence

import numpy as np

from radar_service.numerics import FLUCTUATION, Flags, Floats, Indices, ResultCache, Singles, generator, name_key
from radar_service.world import Body

DRAWS_PER_BLOCK = 16  # azimuths whose factors are drawn together: setting up a generator costs as much as some 30 draws
KEPT_DRAWS = 16  # crossings, or blocks of azimuths, whose factors are kept: threads are some blocks apart


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
        self._fast: Flags = np.array([per_azimuth(body.swerling) for body in bodies], dtype=np.bool_)
        self._key = [name_key(scene, body.name, radar) for body in bodies]
        self._azimuths, self._seed = azimuths, seed
        self._draws: ResultCache[int, Singles] = ResultCache(KEPT_DRAWS)

    def apply(self, weight: Singles, number: Indices, azimuth: Floats, body: Indices) -> None:
        """Multiplies weights (E, K) by the amplitude factors of their bodies.

        number: (K,) of the azimuths since the start; azimuth: (E,) of the echoes [rad]; body: (E,) of the echoes. Slow cases
        are drawn once per beam crossing. Crossings are counted from the opposite bearing, so that no target changes while
        the beam is on it.
        """
        own = np.flatnonzero(self._case[body])
        if len(own):
            bodies, first, place = np.unique(body[own], return_index=True, return_inverse=True)
            weight[own] *= self._factors(bodies, number, azimuth[own[first]])[place]

    def _factors(self, bodies: Indices, number: Indices, azimuth: Floats) -> Singles:
        """Amplitude factors (N, K) of bodies (N,) at azimuths (N,) [rad]; number: (K,) of the azimuths since the start."""
        fraction, fast = azimuth % (2.0 * np.pi) / (2.0 * np.pi), self._fast[bodies]
        draw = np.floor(number / self._azimuths - fraction[:, None] + 1.5).astype(np.int64)
        draw[fast] = number // DRAWS_PER_BLOCK
        column = np.where(fast[:, None], number % DRAWS_PER_BLOCK, 0)
        factors = np.empty(draw.shape, np.float32)
        for each in np.unique(draw).tolist():
            row, k = np.nonzero(draw == each)
            factors[row, k] = self._drawn(each, bodies[row], column[row, k])
        return factors

    def _drawn(self, draw: int, body: Indices, column: Indices) -> Singles:
        """Factors (M,) of bodies (M,) in one crossing, or at azimuths `column` (M,) of DRAWS_PER_BLOCK."""
        columns = DRAWS_PER_BLOCK if self._fast.any() else 1
        kept = self._draws.get(draw, lambda: np.full((len(self._key), columns), np.nan, np.float32))
        missing = np.bincount(body[np.isnan(kept[body, column])])  # another thread may draw the same meanwhile
        for b in np.flatnonzero(missing).tolist():
            rng, case = generator(self._seed, FLUCTUATION, self._key[b], draw), int(self._case[b])
            count = DRAWS_PER_BLOCK if self._fast[b] else 1
            kept[b, :count] = [float(np.sqrt(swerling_factor(case, rng))) for _ in range(count)]
        return np.asarray(kept[body, column])
