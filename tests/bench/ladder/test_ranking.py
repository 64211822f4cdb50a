"""Rankings: exact p-values, levels that are kept, and trackers that cannot be told apart."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from radar_service.bench.ladder.ranking import EXACT, LEVEL, interval, leaderboard, p_value, seeds_needed, told_apart
from radar_service.numerics.types import Floats


def board(losses: Mapping[str, Floats], reference: str) -> Iterator[list[SimpleNamespace]]:
    """The figures and the pairs of a leaderboard."""
    return ([SimpleNamespace(**row) for row in rows] for rows in leaderboard(losses, reference).values())


@pytest.mark.parametrize("seeds", [3, 6, EXACT])
def test_of_all_choices_of_signs_two_are_as_far_from_zero_as_equal_signs(seeds: int) -> None:
    assert p_value(np.arange(1.0, seeds + 1.0)) == 2.0 / 2**seeds
    assert p_value(-np.arange(1.0, seeds + 1.0)) == 2.0 / 2**seeds


def test_a_published_example() -> None:
    """Darwin's maize (Fisher 1935, The Design of Experiments, section 21): of the 32,768 choices of signs of 15 pairs 863 have a
    sum of 314 or more, and as many one of -314 or less. 20,000 drawn ones have a standard deviation of 0.0016."""
    eighths = np.array([49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48], dtype=float)
    assert eighths.sum() == 314.0
    assert p_value(eighths) == pytest.approx(2 * 863 / 32768, abs=4 * 0.0016)


def test_drawn_signs_give_the_p_of_all_signs() -> None:
    """One more seed than is counted: drawn p against the exact one, within four standard deviations of 20,000 draws."""
    differences = np.random.default_rng(1).normal(0.5, 1.0, EXACT + 1)
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * (EXACT + 1))).reshape(EXACT + 1, -1)
    exact = (abs(differences @ signs) >= abs(differences.sum()) - 1e-9).mean()
    assert p_value(differences) == pytest.approx(exact, abs=4.0 * np.sqrt(exact * (1.0 - exact) / 20_000) + 1.0 / 20_000)


def test_a_tracker_and_itself_cannot_be_told_apart() -> None:
    losses = np.random.default_rng(2).exponential(10.0, 20)
    figures, (pair,) = board({"one": losses, "again": losses.copy()}, "one")
    assert p_value(losses - losses) == 1.0 and pair.better is None and [figure.place for figure in figures] == [1, 1]
    assert pair.sentence == "one and again cannot be told apart"


@pytest.mark.parametrize("seeds", [8, 14])
def test_equal_trackers_are_told_apart_in_five_percent(seeds: int) -> None:
    """400 benches of trackers whose errors are those of one distribution, four standard deviations of the binomial."""
    rng = np.random.default_rng(3)
    benches = 400 if seeds <= EXACT else 60
    wrong = sum(p_value(rng.exponential(1.0, seeds) - rng.exponential(1.0, seeds)) <= LEVEL for _ in range(benches))
    assert wrong / benches <= LEVEL + 4.0 * np.sqrt(LEVEL * (1.0 - LEVEL) / benches)


def test_pairs_show_what_means_hide() -> None:
    """Seeds differ by 100, the trackers by 1 on each: intervals overlap, and the pairs tell them apart."""
    rng = np.random.default_rng(4)
    hard = rng.uniform(0.0, 100.0, 20)
    worse = hard + rng.normal(1.0, 0.3, 20)
    figures, (pair,) = board({"worse": worse, "better": hard}, "worse")
    assert figures[1].low < figures[0].high
    assert [(figure.tracker, figure.place) for figure in figures] == [("better", 1), ("worse", 2)]
    assert pair.better == "better" and pair.difference == pytest.approx(1.0, abs=0.3)
    assert pair.sentence == "better is better than worse"


def test_places_count_the_trackers_that_are_better() -> None:
    seeds = np.random.default_rng(5).normal(0.0, 1.0, (3, 12))
    figures, pairs = board({"bad": seeds[0] + 50.0, "good": seeds[1], "as good": seeds[2]}, "good")
    assert {figure.tracker: figure.place for figure in figures} == {"good": 1, "as good": 1, "bad": 3}
    assert [pair.better for pair in pairs] == ["good", None]
    assert all(before.place <= after.place for before, after in pairwise(figures))


@pytest.mark.parametrize(
    ("p_values", "apart"),
    [([0.01, 0.04, 0.03, 0.005], [True, False, False, True]), ([0.05], [True]), ([0.04, 0.03], [False, False]), ([], [])],
)
def test_holm(p_values: list[float], apart: list[bool]) -> None:
    """The first one: example of Holm's procedure with 0.05 / 4, / 3, / 2, / 1; 0.03 fails 0.05 / 2, and what follows with it."""
    assert told_apart(p_values) == apart


def test_the_interval_of_a_mean_has_its_standard_error() -> None:
    """Of 400 normal numbers: 1.96 standard errors; percentiles of 2000 resamples lie within 4 % of a standard error of it."""
    values = np.random.default_rng(6).normal(5.0, 2.0, 400)
    mean, low, high = interval(values)
    error = values.std() / 20.0
    assert mean == pytest.approx(values.mean())
    assert (low - mean) / error == pytest.approx(-1.96, abs=4 * 0.06) and (high - mean) / error == pytest.approx(
        1.96, abs=4 * 0.06
    )
    assert interval(np.full(3, 7.0)) == (7.0, 7.0, 7.0)


@pytest.mark.parametrize("comparisons", [1, 4, 10])
def test_with_the_seeds_that_are_needed_differences_of_one_sign_tell_apart_and_with_one_less_they_do_not(
    comparisons: int,
) -> None:
    seeds = seeds_needed(comparisons)
    for count, apart in ((seeds, True), (seeds - 1, False)):
        assert told_apart([p_value(np.ones(count))] * comparisons) == [apart] * comparisons


def test_five_trackers_of_14_to_70_m_are_told_apart_from_the_reference_by_eight_seeds() -> None:
    """With seven seeds the pairs say that these are too few, and not that the trackers cannot be told apart."""
    hard = np.linspace(0.0, 3.0, 8)
    losses = {"gnn": 14.0 + hard, "again": 14.0 + hard, "good": 10.0 + hard, "bad": 40.0 + hard, "worst": 70.0 + hard}
    figures, pairs = board(losses, "gnn")
    assert [(pair.first, pair.second, pair.better, pair.needed) for pair in pairs] == [
        ("gnn", "again", None, 0), ("gnn", "good", "good", 0), ("gnn", "bad", "gnn", 0), ("gnn", "worst", "gnn", 0)
    ]  # fmt: skip
    assert [(figure.tracker, figure.place) for figure in figures] == [
        ("good", 1), ("gnn", 2), ("again", 2), ("bad", 4), ("worst", 4)
    ]  # fmt: skip
    few = {tracker: values[:7] for tracker, values in losses.items()}
    _, pairs = board(few, "gnn")
    assert pairs[0].sentence == "too few seeds to tell gnn and again apart: 8 are needed"
