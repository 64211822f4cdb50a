"""Whether a limit holds for 95 % of runs, with 95 % confidence, by numbers of runs that are fixed before the first one.

A verdict after each run, with more runs where none is reached, would pass too many trackers. The last number is large, as the
best possible tracker misses some limits in 2 % of runs: with 0 misses of 59 it would fail in two benches of three.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from scipy.stats import beta, binom

from radar_service.bench.scenario import Limit
from radar_service.numerics import Floats

SHARE = 0.05  # of runs that may miss a limit: standards state 95 % figures
CONFIDENCE = 0.95  # one-sided
ROUNDING = 1e-9  # one failure of one run has a lower bound of 5 %
RUNS = 1000  # that decide; SHARE and CONFIDENCE allow MISSES of them
MISSES = 38
LOOKS = (25, 50, 100, 150, 200, 250, 300, 400, 500, 600, 800, RUNS)  # numbers of runs after which one may stop
GOOD, FALSE_FAILS = 0.022, 1e-3  # a share of misses, and how often a tracker with it may fail at any look but the last
SMOKE_RUNS = 3
GROSS = 2.0  # times its limit: a value beyond is a gross miss

Word = Literal["pass", "fail", "undecided", "shown", "no gross miss"]


@dataclass(frozen=True)
class Verdict:
    """What the runs of a scenario say about one limit.

    metric, minimum, maximum, source, decides: as in Limit.
    runs, failures: numbers.
    value_95: 95th percentile of the metric, or the 5th for a minimum; None where any run has no value.
    lower, upper: one-sided 95 % bounds of the share that fails.
    word: the verdict.
    """

    metric: str
    minimum: float | None
    maximum: float | None
    source: str
    decides: bool
    runs: int
    failures: int
    value_95: float | None
    lower: float
    upper: float
    word: Word


def failure_bounds(failures: int, runs: int) -> tuple[float, float]:
    """Returns the one-sided 95 % lower and upper bounds of the share of failures (Clopper and Pearson 1934)."""
    lower = float(beta.ppf(1.0 - CONFIDENCE, failures, runs - failures + 1)) if failures else 0.0
    upper = float(beta.ppf(CONFIDENCE, failures + 1, runs - failures)) if failures < runs else 1.0
    return lower, upper


def _after(chances: Floats, runs: int, share: float) -> Floats:
    """Chances (K,) of each number of misses after some more runs, of which a share misses."""
    return np.convolve(chances, binom.pmf(np.arange(runs + 1), runs, share))


@cache
def boundaries(looks: tuple[int, ...]) -> tuple[tuple[int, int, int], ...]:
    """Returns of each look its number of runs, the misses with which a limit passes at most, and those from which it fails.

    Chances to pass with SHARE (1 - CONFIDENCE) and FALSE_FAILS are spent in proportion to the runs (Lan and DeMets 1983).
    """
    result, done, passed, failed = list[tuple[int, int, int]](), 0, 0.0, 0.0
    bad = good = np.ones(1)
    for runs in looks:
        bad, good, spent = _after(bad, runs - done, SHARE), _after(good, runs - done, GOOD), runs / looks[-1]
        most = int(np.searchsorted(np.cumsum(bad), (1.0 - CONFIDENCE) * spent - passed, side="right")) - 1
        beyond = np.append(np.cumsum(good[::-1])[::-1], 0.0)
        least = max(most + 1, int(np.argmax(beyond <= FALSE_FAILS * spent - failed))) if runs < looks[-1] else most + 1
        passed, failed = passed + bad[: most + 1].sum(), failed + good[least:].sum()
        for chances in (bad, good):
            chances[: most + 1] = chances[least:] = 0.0
        result.append((runs, most, least))
        done = runs
    return tuple(result)


def chance_to_pass(looks: tuple[int, ...], share: float) -> float:
    """Returns how often a tracker passes a limit that it misses in a share of runs."""
    chances, done, passed = np.ones(1), 0, 0.0
    for runs, most, least in boundaries(looks):
        chances, done = _after(chances, runs - done, share), runs
        passed += float(chances[: most + 1].sum())
        chances[: most + 1] = chances[least:] = 0.0
    return passed


def verdict(limit: Limit, values: Sequence[float | None], smoke: bool = False, looks: tuple[int, ...] = ()) -> Verdict:
    """Returns the verdict on a limit from the metric's value in each run.

    smoke: fails for a gross miss alone; looks: numbers of runs after which one may stop; none where all runs are made first.
    """
    failures = sum(not limit.is_met(value) for value in values)
    lower, upper = failure_bounds(failures, len(values))
    numbers = [value for value in values if value is not None]
    share = 100.0 * (1.0 - SHARE if limit.maximum is not None else SHARE)
    value = float(np.percentile(numbers, share)) if len(numbers) == len(values) and numbers else None
    if smoke:
        word = _smoke_word(limit, values, failures)
    else:
        word = _word_of_looks(limit, values, looks) if looks else _word(failures, len(values), lower, upper)
    return Verdict(
        limit.metric, limit.minimum, limit.maximum, limit.source, limit.decides, len(values), failures, value, lower, upper,
        word if limit.decides else "shown",
    )  # fmt: skip


def _word_of_looks(limit: Limit, values: Sequence[float | None], looks: tuple[int, ...]) -> Word:
    """The verdict of the first look that has one."""
    for runs, most, least in boundaries(looks):
        failures = sum(not limit.is_met(value) for value in values[:runs])
        if len(values) >= runs and not most < failures < least:
            return "pass" if failures <= most else "fail"
    return "undecided"


def _word(failures: int, runs: int, lower: float, upper: float) -> Word:
    if runs >= RUNS:
        return "pass" if upper <= SHARE else "fail"
    return "fail" if failures > MISSES or lower > SHARE + ROUNDING else "undecided"


def _smoke_word(limit: Limit, values: Sequence[float | None], failures: int) -> Word:
    """A limit that all of several runs miss is missed grossly too."""
    gross = any(is_gross(limit, value) for value in values) or failures == len(values) > 1
    return "fail" if gross else "no gross miss"


def is_gross(limit: Limit, value: float | None) -> bool:
    """Returns whether a value is missing, above GROSS times the maximum, or GROSS times as far below 1 as the minimum is."""
    if value is None or np.isnan(value):
        return True
    over = limit.maximum is not None and value > GROSS * limit.maximum
    return over or (limit.minimum is not None and value < limit.minimum - (GROSS - 1.0) * abs(1.0 - limit.minimum))
