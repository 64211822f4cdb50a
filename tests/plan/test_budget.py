"""The error budget in numbers by hand."""

import argparse
import math

import pytest

from radar_service.plan.budget import (
    DEFAULT_DB,
    ERROR_HELP,
    MAX_DB,
    MIN_DB,
    STEPS_DB,
    ErrorBudget,
    error_budget,
    finite_pace,
)


def test_the_default_budget_is_half_a_decibel_and_40_db_of_field() -> None:
    assert (ErrorBudget().target_db, ErrorBudget().field_db) == (0.5, -40.0)


def test_field_errors_are_proportional_to_the_budget() -> None:
    """Ten times the budget is 20 dB; methods keep 14 dB more for weak targets."""
    assert ErrorBudget(5.0).field_db == pytest.approx(-20.0)
    assert ErrorBudget(0.05).field_db == pytest.approx(-60.0)
    assert ErrorBudget(5.0).method_db == pytest.approx(-34.0)


def test_the_share_is_the_power_ratio_less_one() -> None:
    """3.0103 dB is a factor of 2, 10 dB a factor of 10."""
    assert ErrorBudget(3.010299957).share == pytest.approx(1.0, rel=1e-9)
    assert ErrorBudget(10.0).share == pytest.approx(9.0)


@pytest.mark.parametrize("wrong", [0.0, -1.0, 11.0, math.nan, math.inf])
def test_a_budget_beyond_reason_is_refused_with_what_is_allowed(wrong: float) -> None:
    with pytest.raises(ValueError, match=r"error budget: .* dB is not allowed; 0\.01 to 10 dB"):
        ErrorBudget(wrong)


def test_limits_steps_and_default_are_allowed_budgets() -> None:
    for budget in (MIN_DB, MAX_DB, DEFAULT_DB, *STEPS_DB):
        assert ErrorBudget(budget).target_db == budget
    assert list(STEPS_DB) == sorted(STEPS_DB)


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
