"""Verdicts on limits, against the numbers of Clopper and Pearson."""

import pytest
from scipy.stats import binom

from radar_service.bench.scenario import Limit
from radar_service.bench.scores.verdicts import failure_bounds, verdict

AT_MOST = Limit(metric="m", maximum=10.0, source="this test")


@pytest.mark.parametrize(
    ("failures", "runs", "word"),
    [(0, 59, "pass"), (0, 58, "undecided, more seeds"), (4, 200, "pass"), (5, 200, "undecided, more seeds"), (3, 3, "fail"),
     (1, 1, "undecided, more seeds"),
     (2, 59, "undecided, more seeds"), (12, 100, "fail")],
)  # fmt: skip
def test_words_follow_the_bounds(failures: int, runs: int, word: str) -> None:
    """0 of 59 and 4 of 200 show 95 % with 95 % confidence."""
    result = verdict(AT_MOST, [11.0] * failures + [9.0] * (runs - failures))
    assert (result.word, result.failures, result.runs) == (word, failures, runs)


@pytest.mark.parametrize(("failures", "runs"), [(1, 20), (4, 200), (10, 30)])
def test_bounds_are_where_the_binomial_tails_are_five_percent(failures: int, runs: int) -> None:
    lower, upper = failure_bounds(failures, runs)
    assert binom.cdf(failures, runs, upper) == pytest.approx(0.05) and binom.sf(failures - 1, runs, lower) == pytest.approx(
        0.05
    )


def test_no_value_misses_and_sources_without_proof_decide_nothing() -> None:
    assert verdict(AT_MOST, [None]).failures == 1 and verdict(AT_MOST, [None, 3.0]).value_95 is None
    shown = Limit(metric="m", maximum=10.0, source="recalled", decides=False)
    assert verdict(shown, [99.0] * 60).word == "shown"
    low = Limit(metric="m", minimum=0.9, source="this test")
    assert verdict(low, [0.95] * 59).word == "pass" and verdict(low, [0.8]).failures == 1
    assert verdict(low, [0.0, *[1.0] * 99]).value_95 == pytest.approx(1.0)
    assert verdict(AT_MOST, [float(k) for k in range(101)]).value_95 == pytest.approx(95.0)
