"""Options of the plan: what is accepted, and what is refused with the remedy."""

import argparse

import pytest

from radar_service.plan.arguments import ERROR_HELP, error_budget, finite_pace
from radar_service.plan.budget import ErrorBudget


def test_an_error_budget_is_read_in_decibels() -> None:
    assert error_budget("0.25") == ErrorBudget(0.25)
    assert error_budget("1e1") == ErrorBudget(10.0)


@pytest.mark.parametrize("text", ["", "half", "0", "-1", "10.1", "nan", "inf"])
def test_other_error_budgets_are_refused_with_the_limits(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=f'"{text}" is not an error budget; give 0.01 to 10 dB'):
        error_budget(text)


def test_a_pace_is_any_finite_number_above_0() -> None:
    assert [finite_pace(text) for text in ("1", "0.01", "1e12")] == [1.0, 0.01, 1e12]


@pytest.mark.parametrize("text", ["", "fast", "0", "-2", "nan", "inf"])
def test_other_paces_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=f'"{text}" is not a pace; give a number above 0'):
        finite_pace(text)


def test_the_help_has_the_limits_and_the_default() -> None:
    assert "0.01 to 10 dB" in ERROR_HELP and "auto: 0.5" in ERROR_HELP
