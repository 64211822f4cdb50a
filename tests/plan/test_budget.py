"""The error budget in numbers by hand."""

import math

import pytest

from radar_service.plan.budget import DEFAULT_DB, MAX_DB, MIN_DB, STEPS_DB, ErrorBudget


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
