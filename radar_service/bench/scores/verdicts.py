"""Whether a limit holds for 95 % of runs, with 95 % confidence, by a number of runs that is fixed before the first one.

The number is fixed, as a verdict after each run, with more runs where none is reached, would pass too many trackers. It is large,
as the best possible tracker misses some limits in 2 % of runs: with 0 misses of 59 it would fail in two benches of three.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from scipy.stats import beta

from radar_service.bench.scenario import Limit

SHARE = 0.05  # of runs that may miss a limit: standards state 95 % figures
CONFIDENCE = 0.95  # one-sided
ROUNDING = 1e-9  # one failure of one run has a lower bound of 5 %
RUNS = 1000  # that decide; SHARE and CONFIDENCE allow MISSES of them
MISSES = 38
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

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def failure_bounds(failures: int, runs: int) -> tuple[float, float]:
    """Returns the one-sided 95 % lower and upper bounds of the share of failures (Clopper and Pearson 1934)."""
    lower = float(beta.ppf(1.0 - CONFIDENCE, failures, runs - failures + 1)) if failures else 0.0
    upper = float(beta.ppf(CONFIDENCE, failures + 1, runs - failures)) if failures < runs else 1.0
    return lower, upper


def verdict(limit: Limit, values: Sequence[float | None], smoke: bool = False) -> Verdict:
    """Returns the verdict on a limit from the metric's value in each run. smoke: fails for a gross miss alone."""
    failures = sum(not limit.is_met(value) for value in values)
    lower, upper = failure_bounds(failures, len(values))
    numbers = [value for value in values if value is not None]
    share = 100.0 * (1.0 - SHARE if limit.maximum is not None else SHARE)
    value = float(np.percentile(numbers, share)) if len(numbers) == len(values) and numbers else None
    word = _smoke_word(limit, values, failures) if smoke else _word(failures, len(values), lower, upper)
    return Verdict(
        limit.metric, limit.minimum, limit.maximum, limit.source, limit.decides, len(values), failures, value, lower, upper,
        word if limit.decides else "shown",
    )  # fmt: skip


def _word(failures: int, runs: int, lower: float, upper: float) -> Word:
    if runs >= RUNS:
        return "pass" if upper <= SHARE else "fail"
    return "fail" if failures > MISSES or lower > SHARE + ROUNDING else "undecided"


def _smoke_word(limit: Limit, values: Sequence[float | None], failures: int) -> Word:
    """A limit that all runs miss is missed grossly too."""
    gross = any(is_gross(limit, value) for value in values) or failures == len(values)
    return "fail" if gross else "no gross miss"


def is_gross(limit: Limit, value: float | None) -> bool:
    """Returns whether a value is missing, above GROSS times the maximum, or GROSS times as far below 1 as the minimum is."""
    if value is None or np.isnan(value):
        return True
    over = limit.maximum is not None and value > GROSS * limit.maximum
    return over or (limit.minimum is not None and value < limit.minimum - (GROSS - 1.0) * abs(1.0 - limit.minimum))
