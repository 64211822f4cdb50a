"""A plan as text and as plain data, and the requirements that it cannot meet."""

import argparse
import json
import math
import re
from dataclasses import asdict
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.believed.verdicts import chosen_rows
from radar_service.numerics.arithmetic_name import arithmetic
from radar_service.plan import plan as plans
from radar_service.plan.body_errors import aspects_db
from radar_service.plan.budget import ERROR_HELP, STEPS_DB, ErrorBudget, error_budget, finite_pace
from radar_service.plan.cost_model import Costs, Counts, EngineStatistics, PerBody, realtime_factor
from radar_service.plan.culling import CulledBody
from radar_service.plan.plan import NEVER_VISIBLE, Plan, bodies, estimated_factor, held, plan_for, plan_in_time
from radar_service.plan.settings_search import fidelity_for, moving_db, multipath_db, resting_db
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.records.plan_item import PlanItem
from tests.plan.scenes import HOUSE, WAY
from tests.plan.scenes import made as small
from tests.scenes import point, scene

COUNTS = Counts(
    resting_echoes=7, moving_echoes=5, shadowed_echoes=3, scatterers=40, set_up_rays=90, look_rays=11,
    looks_per_scan=3.6, transform_samples=8064,
)  # fmt: skip
COSTS = Costs(looks=1.0, moving=9.96, receiver=24.2, profiles=2.84, effects={"clutter": 0.25})


def moving_scene(**environment: object) -> object:
    return scene([point("t", 0, 500, speed_kn=12, course_deg=180)], environment=environment)


def test_the_text_has_errors_counts_costs_and_a_line_for_each_choice() -> None:
    made = moving_scene()
    plan = plan_for(made, PRESETS["balanced"], EngineStatistics(counts=COUNTS, costs=COSTS))
    lines = str(plan).splitlines()
    assert lines[0] == "fidelity balanced"
    assert lines[1] == f"arithmetic: {arithmetic()}"
    assert lines[2] == (
        f"predicted field error: {resting_db(made.radar, PRESETS['balanced']):.0f} dB at rest, "
        f"{moving_db(made.radar, PRESETS['balanced']):.0f} dB moving"
    )
    assert lines[3] == (
        "40 scatterers; once 7 echoes and 90 rays; 3.6 visibility updates per scan, the first 5 echoes and 11 rays, "
        "3 in shadow; 8064 FFT samples per profile"
    )
    factor = made.radar.spoke_period / 38.25e-6
    assert lines[4] == (
        "cost: 38.2 us per azimuth (visibility 1, moving 9.96, receiver 24.2, profiles 2.84), "
        f"{factor:.3g} x real time on one thread here"
    )
    assert lines[5 + len(plan.choices) :] == [f"= {line}" for line in plan.believed]
    assert all(line.startswith("+ " if c.modelled else "- ") for line, c in zip(lines[5:], plan.choices, strict=False))


def test_the_budget_is_in_the_head_of_a_planned_fidelity() -> None:
    made = moving_scene()
    assert str(plan_for(made, fidelity_for(made, ErrorBudget(1.0)))).startswith(
        "fidelity auto (error budget 1 dB, field -34 dB)"
    )


def test_plain_data_has_the_public_keys_and_no_infinity() -> None:
    plan = plan_for(moving_scene(), PRESETS["reference"], EngineStatistics(counts=COUNTS, costs=COSTS))
    plain = plan.as_dict()
    assert list(plain) == [
        "fidelity", "arithmetic", "choices", "settings", "field_db", "counts", "costs", "realtime_factor", "caveats",
        "believed",
    ]  # fmt: skip
    assert math.isinf(plan.settings["beam_extent"]) and plain["settings"]["beam_extent"] is None
    assert plain["counts"] == asdict(COUNTS) and json.loads(json.dumps(plain, allow_nan=False)) == plain


def test_a_budget_that_no_setting_keeps_is_a_caveat_with_advice() -> None:
    """At 1 x bandwidth a chirp of 100 cycles errs by -51 dB, where -54 dB are allowed. Each remedy helps."""
    radar = {"sample_rate_hz": 50e6, "pulse_s": 2e-6}
    coarse = scene([point("t", 500, 500)], radar=radar, own_ship={"speed_kn": 10})
    widest = plan_for(coarse, fidelity_for(coarse, ErrorBudget()))
    advice = "raise sample_rate_hz to 5.5e+07, or lengthen pulse_s to 4e-06, or allow a larger error"
    assert len(widest.caveats) == 2 and all("-54 dB" in caveat and advice in caveat for caveat in widest.caveats)
    for changed in ({"sample_rate_hz": 55e6}, {"pulse_s": 4e-6}):
        better = scene([point("t", 500, 500)], radar=radar | changed, own_ship={"speed_kn": 10})
        assert not plan_for(better, fidelity_for(better, ErrorBudget())).caveats
    assert not plan_for(coarse, PRESETS["fast"]).caveats  # a preset promises no budget


def test_errors_of_multipath_are_predicted() -> None:
    made, balanced = moving_scene(multipath=True), PRESETS["balanced"]
    sea = "of sea reflection, moving"
    errors = plan_for(made, balanced).field_db
    assert list(errors) == ["at rest", "moving", sea] and errors[sea] == multipath_db(made, balanced)
    assert plan_for(made, PRESETS["documented"]).field_db == {}


def test_errors_of_changing_aspects_are_predicted() -> None:
    """Of metal that moves, or that a moving ship observes."""
    plate = {"name": "p", "shape": "plate", "width_m": 2, "height_m": 1, "position_m": [0, 500, 9], "scattering": "optics"}
    aspects = "of aspects, moving"
    assert aspects not in plan_for(scene([plate]), PRESETS["balanced"]).field_db
    for made in (scene([plate], own_ship={"speed_kn": 9}), scene([plate | {"course_deg": 20, "speed_kn": 4}])):
        assert plan_for(made, PRESETS["balanced"]).field_db[aspects] == aspects_db(made)


def test_bodies_that_exceed_the_budget_late_in_a_run_are_caveats() -> None:
    """A house that own ship passes keeps the scatterers of the start. At rest it keeps the budget."""
    house = {"name": "house", "shape": "box", "length_m": 100, "width_m": 100, "height_m": 9, "position_m": [100, 1500, 0],
             "material": "concrete", "scattering": "diffuse"}  # fmt: skip
    passed, still = scene([house], own_ship={"speed_kn": 12, "course_deg": 0}), scene([house])
    (caveat,) = plan_for(passed, fidelity_for(passed, ErrorBudget())).caveats
    assert "over the run the mean power of body house errs by more than the error budget" in caveat
    assert plan_for(still, fidelity_for(still, ErrorBudget())).caveats == ()
    assert plan_for(passed, PRESETS["balanced"]).caveats == ()  # a preset promises no budget


def test_metal_that_turns_too_fast_is_a_caveat() -> None:
    plate = {"name": "p", "shape": "plate", "width_m": 5, "height_m": 1, "scattering": "optics", "heading_deg": 0}
    fast = scene([plate | {"position_m": [-60, 60, 9], "speed_kn": 40, "course_deg": 90}])
    plan = plan_for(fast, fidelity_for(fast, ErrorBudget()))
    over = plan.field_db["of aspects, moving"] > -40.0
    assert any("metal that turns fast" in caveat for caveat in plan.caveats) == over
    slow = scene([plate | {"position_m": [-60, 900, 9], "speed_kn": 3, "course_deg": 90}])
    assert plan_for(slow, fidelity_for(slow, ErrorBudget())).caveats == ()


@pytest.mark.parametrize(
    "speed_kn, step", [(12, "steps of 1.4 m of way, which errs by 0.1 dB at most"), (30, "steps of 3.4 m of way")]
)
def test_land_under_way_tells_its_border_and_the_step_and_error_of_its_visibility(speed_kn: float, step: str) -> None:
    """64 of 720 azimuths at 24 rpm are 0.222 s: 1.4 m at 12 kn. The error is measured up to 2 m. Land is computed once a passage,
    metal at each azimuth."""
    house = {"name": "house", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 5, "position_m": [0, 500, 0]}
    metal = house | {"name": "metal", "position_m": [0, 600, 0], "material": "steel", "scattering": "optics"}
    made = scene(
        [house | {"material": "building"}, metal], radar={"azimuths": 720, "rpm": 24}, own_ship={"speed_kn": speed_kn}
    )
    items = {item.what: item for item in plan_for(made, PRESETS["balanced"], EngineStatistics(land_border=152.3)).choices}
    land = items["land under way"]
    assert "from 152 m on" in land.how and land.how.endswith(step) and land.field_db == -50.0
    assert "computed once a passage" in items["body house"].how and "computed at each azimuth" in items["body metal"].how
    items = {item.what: item for item in plan_for(made, PRESETS["balanced"]).choices}
    assert "land under way" not in items and "computed at each azimuth" in items["body house"].how


# statistics: sums of costs, and the pace that they allow.
STAGE_COSTS = Costs(1.0, 2.0, 4.0, 32.0, effects={"clutter": 8.0, "interference": 16.0})


def test_the_total_has_every_stage_once() -> None:
    """Powers of two: a stage that is missing or counted twice changes the sum."""
    assert STAGE_COSTS.total == 63.0


def test_the_pace_is_the_spoke_period_over_the_cost_of_an_azimuth() -> None:
    """24 rpm and 720 azimuths: 3.4722 ms per spoke; 63 us of it are used."""
    made = scene(radar={"rpm": 24, "azimuths": 720})
    assert realtime_factor(made, STAGE_COSTS) == pytest.approx(2.5 / 720 / 63e-6)
    assert realtime_factor(made, Costs(0.0, 0.0, 0.0, 0.0, 0.0)) == math.inf


# plan: lines on what was held against published figures: the table agrees with the page, and lines follow the scene.
PAGE = Path(__file__).parents[2] / "docs/believed.md"
HULL = {"shape": "hull", "length_m": 20, "beam_m": 5, "height_m": 4, "scattering": "optics"}


def test_the_table_has_each_counted_row_and_those_outside_of_the_page() -> None:
    counted = {row.id for row in chosen_rows([]) if not row.uncounted}
    assert set(chain(*held()["rows"].values(), held()["elsewhere"])) == counted
    outside = PAGE.read_text(encoding="utf-8").split("## Outside")[1].split("## Inside")[0]
    assert sorted(held()["outside"]) == sorted(re.findall(r"^\| ([A-Z]\d\d) \|", outside, flags=re.M))


def believed(bodies: list[dict[str, object]], **tables: dict[str, object]) -> str:
    return "\n".join(plan_for(scene(bodies, **tables), PRESETS["balanced"]).believed)


def test_lines_name_what_is_modelled_alone() -> None:
    calm = believed([])
    assert "sea clutter" not in calm and "set that is sold" not in calm
    rough = believed([], environment={"sea_state": 3, "noise": True}, radar={"set": "furuno-1824c"})
    assert "sea clutter: 7 of 12 published figures inside, outside C03" in rough and "set that is sold: 4 of 4" in rough


def test_bodies_stand_under_their_kinds_and_what_nobody_has_measured_at_the_end() -> None:
    bodies = [
        HULL | {"name": "a", "material": "steel", "position_m": [500, 0, 0]},
        HULL | {"name": "b", "material": "fibreglass", "position_m": [0, 500, 0]},
        {"name": "c", "shape": "reflector", "reflector": "octahedral", "edge_m": 0.3, "position_m": [700, 0, 4]},
        {"name": "d", "shape": "point", "rcs_dbsm": 10, "position_m": [0, 900, 4]},
    ]
    lines = believed(bodies).splitlines()
    assert [line.split(":")[0] for line in lines[-4:]] == [
        "metal ships", "boats", "radar reflectors", "held against nothing published",
    ]  # fmt: skip
    assert "cross-sections as declared" in lines[-1]


# plan: the lines about bodies, from statistics made by hand.
BOX = {"name": "box", "shape": "box", "length_m": 40, "width_m": 12, "height_m": 9, "position_m": [300, 700, 0],
       "material": "concrete", "scattering": "diffuse"}  # fmt: skip


def items(scatterers: list[int], echoes: list[int]) -> list[PlanItem]:
    """The lines about a box at rest, a moving point, a moving box and a point at rest with so many scatterers and echoes."""
    return lines_of(EngineStatistics(costs=COSTS, bodies=PerBody(np.array(scatterers), np.array(echoes))))


def lines_of(statistics: EngineStatistics, name: str = "balanced") -> list[PlanItem]:
    way = {"speed_kn": 5, "course_deg": 0}
    made = scene([BOX, point("mover", 0, 500, **way), BOX | {"name": "ship"} | way, point("buoy", 0, 900)])
    return bodies(made, PRESETS[name], statistics)


def test_moving_bodies_share_the_cost_of_moving_echoes_by_their_echoes() -> None:
    """9.96 us for 1 + 5 echoes; bodies at rest cost nothing."""
    costs = [item.microseconds for item in items([100, 1, 50, 1], [40, 1, 5, 1])]
    assert costs == pytest.approx([0.0, 1.66, 8.3, 0.0])


def test_scatterers_and_echoes_are_stated() -> None:
    box, mover, _, buoy = items([100, 1, 50, 1], [40, 0, 5, 1])
    assert box.how.endswith("; 100 points, 40 echoes") and "computed once" in box.how
    assert mover.how.endswith("; a point, not visible now") and "computed at each azimuth" in mover.how
    assert buoy.how.endswith("; a point") and (box.what, buoy.what) == ("body box", "body buoy")


def test_a_resting_body_without_echoes_is_never_visible_a_moving_one_may_be_later() -> None:
    box, _, ship, _ = items([100, 1, 50, 1], [0, 1, 0, 1])
    assert (box.modelled, box.how, box.power_db) == (False, NEVER_VISIBLE, 0.0)
    assert ship.modelled


def test_a_culled_body_has_its_reason_its_error_and_its_shadow() -> None:
    culled = {0: CulledBody("too weak", 0.1, occludes=True), 3: CulledBody("too far", 0.0, occludes=False)}
    box, mover, _, buoy = lines_of(EngineStatistics(culled))
    assert (box.modelled, box.how, box.power_db) == (False, "too weak; still occludes what is behind it", 0.1)
    assert (buoy.modelled, buoy.how, buoy.power_db) == (False, "too far", 0.0)
    assert mover.modelled and mover.microseconds is None


def test_the_documented_engine_counts_triangles() -> None:
    lines = [item.how for item in lines_of(EngineStatistics(), "documented")]
    mesh = scene([BOX]).bodies[0].mesh
    assert mesh is not None and lines == [f"rays against {len(mesh.faces)} triangles", "one hit per azimuth"] * 2


# plan: time as the budget: what is chosen, and what is said where it cannot be had.
def under_way() -> rs.Scene:
    return small([HOUSE, point("t", 0, 800)], own_ship=WAY, environment={"multipath": True})


def planned(fidelity: Fidelity) -> Plan:
    """The plan of `under_way` at a fidelity, with measured costs."""
    return rs.Simulator(under_way(), fidelity).plan


def test_with_all_the_time_in_the_world_the_finest_is_chosen_and_can_be_pinned() -> None:
    plan = plan_in_time(under_way(), 1e-6, planned)
    assert plan.settings["error_db"] == STEPS_DB[0] == 0.25
    assert plan.caveats[-1].endswith("--error-db 0.25 gives the same bytes on any")
    assert Fidelity(**plan.settings) == fidelity_for(under_way(), ErrorBudget(0.25))


def test_a_pace_out_of_reach_is_stated_with_the_pace_that_is_possible(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where estimates promise too much: what was measured counts."""
    for estimate in (estimated_factor, lambda *_: np.inf):
        monkeypatch.setattr(plans, "estimated_factor", estimate)
        plan = plan_in_time(under_way(), 1e9, planned)
        assert plan.settings["error_db"] == STEPS_DB[-1]
        assert f"is not possible on this machine: {plan.realtime_factor:.3g}" in " ".join(plan.caveats)


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


# budget: the error budget in numbers by hand.
def test_field_errors_are_proportional_to_the_budget() -> None:
    """Ten times the budget is 20 dB; methods keep 14 dB more for weak targets. 3.0103 dB is a factor of 2, 10 dB one of 10."""
    assert (ErrorBudget().target_db, ErrorBudget().field_db) == (0.5, -40.0)
    assert [ErrorBudget(budget).field_db for budget in (5.0, 0.05)] == pytest.approx([-20.0, -60.0])
    assert ErrorBudget(5.0).method_db == pytest.approx(-34.0)
    assert [ErrorBudget(budget).share for budget in (3.010299957, 10.0)] == pytest.approx([1.0, 9.0])


def test_budgets_and_paces_are_read_within_their_limits() -> None:
    assert [error_budget(text).target_db for text in ("0.01", "0.25", "1e1")] == [0.01, 0.25, 10.0]
    assert [finite_pace(text) for text in ("1", "0.01", "1e12")] == [1.0, 0.01, 1e12]
    assert "0.01 to 10 dB" in ERROR_HELP and "auto: 0.5" in ERROR_HELP
    assert [ErrorBudget(step).target_db for step in STEPS_DB] == sorted(STEPS_DB)
    for wrong in (0.0, -1.0, 11.0, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"error budget: .* dB is not allowed; 0\.01 to 10 dB"):
            ErrorBudget(wrong)


@pytest.mark.parametrize("text", ["", "half", "0", "-1", "nan", "inf"])
def test_other_budgets_and_paces_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=f'"{text}" is not an error budget; give 0.01 to 10 dB'):
        error_budget(text)
    with pytest.raises(argparse.ArgumentTypeError, match=f'"{text}" is not a pace; give a number above 0'):
        finite_pace(text)
