"""Which of several trackers is better, and which cannot be told apart: each seed gives all of them the same plots, so differences
are paired by seed.

Intervals are those of the bootstrap (Efron 1979). Two trackers are compared by the paired randomisation test (Fisher 1935): were
they equal, the difference of each seed would have either sign with the same chance. Holm (1979) keeps the level of all pairs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from radar_service.numerics.types import Floats

LEVEL = 0.05  # chance that equal trackers are told apart anywhere in one table
CONFIDENCE = 0.95  # of intervals
EXACT = 12  # seeds up to which all choices of signs are counted
DRAWS = 20_000  # choices of signs that are drawn beyond
RESAMPLES = 2_000  # of the bootstrap
ROUNDING = 1e-9  # relative, of sums that are equal
APART = "cannot be told apart"


@dataclass(frozen=True)
class Figure:
    """A mean over seeds, and its interval. place: 1 and the number of trackers that are better."""

    tracker: str
    place: int
    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Pair:
    """Two trackers. difference: mean of the first one less that of the second. better: the name of one, or None."""

    first: str
    second: str
    difference: float
    p: float
    better: str | None

    @property
    def sentence(self) -> str:
        """What is known of them."""
        other = self.first if self.better == self.second else self.second
        return f"{self.better} is better than {other}" if self.better else f"{self.first} and {self.second} {APART}"


def leaderboard(losses: Mapping[str, Floats]) -> tuple[list[Figure], list[Pair]]:
    """Returns trackers, the best first, and all pairs of them. losses: of each tracker by seed (N,), smaller is better."""
    pairs = _pairs(losses)
    beaten = {tracker: sum(pair.better not in (None, tracker) for pair in pairs if tracker in (pair.first, pair.second))
              for tracker in losses}  # fmt: skip
    figures = [Figure(tracker, 1 + beaten[tracker], *interval(values)) for tracker, values in losses.items()]
    return sorted(figures, key=lambda figure: (figure.place, figure.mean)), pairs


def _pairs(losses: Mapping[str, Floats]) -> list[Pair]:
    differences = {(a, b): losses[a] - losses[b] for a, b in combinations(losses, 2)}
    p_values = [p_value(each) for each in differences.values()]
    pairs = zip(differences.items(), p_values, told_apart(p_values), strict=True)
    return [
        Pair(a, b, float(each.mean()), p, (a if each.mean() < 0.0 else b) if is_apart else None)
        for ((a, b), each), p, is_apart in pairs
    ]


def interval(losses: Floats) -> tuple[float, float, float]:
    """Returns the mean of losses (N,), and its interval of CONFIDENCE by the bootstrap over seeds."""
    rows = np.random.default_rng(0).integers(len(losses), size=(RESAMPLES, len(losses)))
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(losses[rows].mean(axis=1), [tail, 100.0 - tail]).tolist()
    return float(losses.mean()), low, high


def p_value(differences: Floats) -> float:
    """Returns the chance of so large a mean of paired differences (N,), of either sign, were the trackers equal.

    It is exact up to EXACT seeds. Beyond, signs are drawn, and the given ones are one of the draws (Phipson and Smyth 2010).
    """
    count = len(differences)
    limit = abs(differences.sum()) - ROUNDING * abs(differences).sum()
    if count <= EXACT:
        signs = np.array(list(product((-1.0, 1.0), repeat=count)))
        return float((abs(signs @ differences) >= limit).mean())
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (DRAWS, count))
    return float((1 + (abs(signs @ differences) >= limit).sum()) / (1 + DRAWS))


def told_apart(p_values: Sequence[float]) -> list[bool]:
    """Returns which of several comparisons are significant, at LEVEL for all of them together (Holm 1979)."""
    apart, left = [False] * len(p_values), len(p_values)
    for number in np.argsort(p_values, kind="stable").tolist():
        if p_values[number] > LEVEL / left:
            break
        apart[number], left = True, left - 1
    return apart
