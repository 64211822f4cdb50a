"""Verdicts on limits, against the numbers of Clopper and Pearson."""

import numpy as np
import pytest
from scipy.stats import binom

from radar_service.bench.scenario import Limit
from radar_service.bench.scores.verdicts import (
    LOOKS,
    MISSES,
    RUNS,
    SHARE,
    boundaries,
    chance_to_pass,
    failure_bounds,
    is_gross,
    verdict,
)

AT_MOST = Limit(metric="m", maximum=10.0, source="this test")
AT_LEAST = Limit(metric="m", minimum=0.9, source="this test")


@pytest.mark.parametrize(
    ("failures", "runs", "word"),
    [(0, 59, "undecided"), (0, 999, "undecided"), (38, 999, "undecided"), (39, 999, "fail"), (38, 1000, "pass"),
     (39, 1000, "fail"), (3, 3, "fail"), (1, 1, "undecided"), (2, 59, "undecided"), (12, 100, "fail"), (83, 2000, "pass"),
     (84, 2000, "fail")],
)  # fmt: skip
def test_a_thousand_runs_decide_and_fewer_can_only_fail(failures: int, runs: int, word: str) -> None:
    result = verdict(AT_MOST, [11.0] * failures + [9.0] * (runs - failures))
    assert (result.word, result.failures, result.runs) == (word, failures, runs)


def test_the_number_of_misses_is_the_largest_that_shows_95_percent() -> None:
    """With a share of 5 %, 38 misses or fewer of 1000 come in less than 5 % of benches, 39 in more."""
    assert binom.cdf(MISSES, RUNS, SHARE) <= 0.05 < binom.cdf(MISSES + 1, RUNS, SHARE)


def test_looks_pass_and_fail_as_often_as_they_say() -> None:
    """Exact chances against 4,000 drawn benches a share; a verdict stands whatever comes later."""
    assert (
        chance_to_pass(LOOKS, SHARE) <= 0.05 and chance_to_pass(LOOKS, 0.02) > 0.999 and chance_to_pass(LOOKS, 0.025) > 0.989
    )
    assert boundaries((RUNS,)) == ((RUNS, MISSES, MISSES + 1),)
    rng = np.random.default_rng(1)
    for share in (0.025, 0.03, SHARE):
        misses = (rng.random((4000, RUNS), dtype=np.float32) < share).cumsum(axis=1)
        runs, most, least = np.array(boundaries(LOOKS)).T
        counts = misses[:, runs - 1]
        first = np.argmax((counts <= most) | (counts >= least), axis=1)
        passed = np.take_along_axis(counts <= most, first[:, None], 1).mean()
        assert passed == pytest.approx(chance_to_pass(LOOKS, share), abs=0.02)
    words = [
        verdict(AT_MOST, [9.0] * 150 + [11.0] * 30, looks=LOOKS),
        verdict(AT_MOST, [11.0] * 6 + [9.0] * 200, looks=LOOKS),
    ]
    assert [each.word for each in words] == ["pass", "fail"]
    assert [verdict(AT_MOST, [9.0] * runs, looks=LOOKS).word for runs in (149, 150)] == ["undecided", "pass"]


def test_a_tracker_that_misses_in_two_percent_passes() -> None:
    """In 99.99 % of benches; with 0 misses of 59 it failed in 70 %."""
    assert binom.cdf(MISSES, RUNS, 0.02) > 0.9999 and 1.0 - binom.cdf(0, 59, 0.02) == pytest.approx(0.70, abs=0.005)


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
    assert verdict(AT_LEAST, [0.95] * RUNS).word == "pass" and verdict(AT_LEAST, [0.8]).failures == 1
    assert verdict(AT_LEAST, [0.0, *[1.0] * 99]).value_95 == pytest.approx(1.0)
    assert verdict(AT_MOST, [float(k) for k in range(101)]).value_95 == pytest.approx(95.0)


@pytest.mark.parametrize(
    ("limit", "value", "gross"),
    [(AT_MOST, 19.9, False), (AT_MOST, 20.1, True), (AT_LEAST, 0.81, False), (AT_LEAST, 0.79, True), (AT_MOST, None, True),
     (AT_MOST, float("nan"), True), (Limit(metric="m", maximum=0.0, source="s"), 1.0, True)],
)  # fmt: skip
def test_a_gross_miss_is_twice_as_far_off_or_no_value(limit: Limit, value: float | None, gross: bool) -> None:
    assert is_gross(limit, value) is gross


@pytest.mark.parametrize(
    ("values", "word"),
    [([9.0, 11.0, 9.0], "no gross miss"), ([11.0] * 3, "fail"), ([9.0, 21.0, 9.0], "fail"), ([11.0], "no gross miss")],
)
def test_smoke_fails_for_gross_misses_alone(values: list[float], word: str) -> None:
    assert verdict(AT_MOST, values, smoke=True).word == word
