"""Time as the budget: what is chosen, and what is said where it cannot be had."""

import json
from dataclasses import replace

import numpy as np
import pytest

import radar_service as rs
from radar_service.plan import plan as plans
from radar_service.plan.budget import STEPS_DB, ErrorBudget
from radar_service.plan.plan import Plan, estimated_factor, plan_in_time
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import Fidelity
from tests.plan.scenes import HOUSE, WAY, made
from tests.scenes import point


def under_way() -> rs.Scene:
    return made([HOUSE, point("t", 0, 800)], own_ship=WAY, environment={"multipath": True})


def planned(fidelity: Fidelity) -> Plan:
    """The plan of `under_way` at a fidelity, with measured costs."""
    return rs.Simulator(under_way(), fidelity).plan


def test_with_all_the_time_in_the_world_the_finest_is_chosen_and_can_be_pinned() -> None:
    plan = plan_in_time(under_way(), 1e-6, planned)
    assert plan.settings["error_db"] == STEPS_DB[0] == 0.25
    assert plan.caveats[-1].endswith("--error-db 0.25 gives the same bytes on any")
    pinned = fidelity_for(under_way(), ErrorBudget(0.25))
    assert Fidelity(**plan.settings) == pinned


def test_a_pace_out_of_reach_is_stated_with_the_pace_that_is_possible() -> None:
    plan = plan_in_time(under_way(), 1e9, planned)
    assert plan.settings["error_db"] == STEPS_DB[-1]
    assert f"is not possible on this machine: {plan.realtime_factor:.3g}" in " ".join(plan.caveats)


def test_estimates_that_promise_too_much_are_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plans, "estimated_factor", lambda *_: np.inf)
    scene = made([point("t", 0, 800)], own_ship=WAY)
    plan = plan_in_time(scene, 1e9, lambda fidelity: rs.Simulator(scene, fidelity).plan)
    assert plan.settings["error_db"] == STEPS_DB[-1]


def test_a_budget_that_is_not_kept_is_stated() -> None:
    kept = plan_in_time(under_way(), 1e-6, planned, ErrorBudget(1.0))
    assert kept.settings["error_db"] == 1.0 and "real time" not in " ".join(kept.caveats)
    both = plan_in_time(under_way(), 1e9, planned, ErrorBudget(1.0))
    assert both.settings["error_db"] == STEPS_DB[-1]
    assert "an error budget of 1 dB cannot run at 1e+09 x real time" in " ".join(both.caveats)


def test_estimates_rise_with_the_budget_and_are_the_plan_s_own_at_its_own() -> None:
    plan = rs.Simulator(under_way()).plan
    estimates = [estimated_factor(under_way(), plan, step) for step in STEPS_DB]
    assert estimates == sorted(estimates) and estimates[0] < 0.9 * estimates[-1]
    assert estimated_factor(under_way(), plan, 0.5) == pytest.approx(plan.realtime_factor)


def test_a_fidelity_that_was_planned_gives_the_same_bytes_by_itself_and_with_threads() -> None:
    sim = rs.Simulator(under_way(), seed=4)
    again = rs.Simulator(under_way(), Fidelity(**sim.plan.settings), seed=4, threads=2)
    np.testing.assert_array_equal(sim.scan().field, again.scan().field)


def test_plain_data_is_json_and_says_what_is_left_out() -> None:
    scene = made([point("t", 0, 800), point("gone", 0, 90_000)], own_ship=WAY)
    endless = rs.Simulator(scene, replace(fidelity_for(scene, ErrorBudget()), beam_extent=np.inf)).plan
    plain = json.loads(json.dumps(endless.as_dict(), allow_nan=False))
    assert plain["settings"]["beam_extent"] is None and plain["counts"]["moving_echoes"] == 1
    gone = plain["choices"][-1]
    assert (gone["what"], gone["modelled"], gone["power_db"]) == ("body gone", False, 0.0)
