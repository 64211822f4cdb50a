"""Which of several trackers is better, and which cannot be told apart: differences are paired by seed.

Intervals: bootstrap (Efron 1979). Pairs: randomisation test (Fisher 1935), the reference with each other tracker; Holm (1979)
keeps the level of all pairs.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from math import ceil, log2
from typing import Any

import numpy as np

from radar_service.numerics import Floats

LEVEL = 0.05  # chance that equal trackers are told apart anywhere in one table
CONFIDENCE = 0.95  # of intervals
EXACT = 12  # seeds up to which all choices of signs are counted
DRAWS = 20_000  # choices of signs that are drawn beyond
RESAMPLES = 2_000  # of the bootstrap
ROUNDING = 1e-9  # relative, of sums that are equal
APART = "cannot be told apart"


def seeds_needed(comparisons: int) -> int:
    """Returns the seeds with which the least p of `p_value`, that of differences of one sign, tells apart among so many."""
    return 1 + ceil(log2(max(comparisons, 1) / LEVEL))


def leaderboard(losses: Mapping[str, Floats], reference: str) -> dict[str, list[dict[str, Any]]]:
    """Returns `leaderboard`, trackers with place, mean and interval, the best first, and `pairs` of the reference with each
    other one, as plain data.

    losses: of each tracker by seed (N,), smaller is better. A place is 1 and the number of better trackers: those than the
    reference before it and those that are not told apart from it, and these before worse ones. `needed`: seeds with which
    a pair could be told apart; 0 where there are enough."""
    differences = {name: losses[reference] - losses[name] for name in losses if name != reference}
    p_values = [p_value(each) for each in differences.values()]
    needed, rank, pairs = seeds_needed(len(p_values)), dict.fromkeys(losses, 0), []
    for (name, each), p, is_apart in zip(differences.items(), p_values, told_apart(p_values), strict=True):
        mean = float(each.mean())
        better, worse = (reference, name) if mean < 0.0 else (name, reference)
        if len(each) < needed:
            sentence = f"too few seeds to tell {reference} and {name} apart: {needed} are needed"
        else:
            sentence = f"{better} is better than {worse}" if is_apart else f"{reference} and {name} {APART}"
        if is_apart:
            rank[name] = 1 if better == reference else -1
        pairs.append({
            "first": reference, "second": name, "difference": mean, "p": p, "better": better if is_apart else None,
            "needed": needed * (len(each) < needed), "sentence": sentence,
        })  # fmt: skip
    figures = []
    for name, values in losses.items():
        mean, low, high = interval(values)
        place = 1 + sum(other < rank[name] for other in rank.values())
        figures.append({"tracker": name, "place": place, "mean": mean, "low": low, "high": high})
    return {"leaderboard": sorted(figures, key=lambda figure: (figure["place"], figure["mean"])), "pairs": pairs}


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
