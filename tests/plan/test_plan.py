"""A plan as text and as plain data, and the requirements that it cannot meet."""

import json
import math
from dataclasses import asdict

import pytest

from radar_service.numerics.arithmetic import arithmetic
from radar_service.plan.body_errors import aspects_db
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.plan import plan_for
from radar_service.plan.settings_search import fidelity_for, moving_db, multipath_db, resting_db
from radar_service.plan.statistics import Costs, Counts, EngineStatistics
from radar_service.records.fidelity import PRESETS
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


def test_errors_of_changing_aspects_are_predicted() -> None:
    """Of metal that moves, or that a moving ship observes."""
    plate = {"name": "p", "shape": "plate", "width_m": 2, "height_m": 1, "position_m": [0, 500, 9], "scattering": "optics"}
    aspects = "of aspects, moving"
    assert aspects not in plan_for(scene([plate]), PRESETS["balanced"]).field_db
    for made in (scene([plate], own_ship={"speed_kn": 9}), scene([plate | {"course_deg": 20, "speed_kn": 4}])):
        assert plan_for(made, PRESETS["balanced"]).field_db[aspects] == aspects_db(made)


def test_the_documented_engine_predicts_no_errors() -> None:
    assert plan_for(moving_scene(multipath=True), PRESETS["documented"]).field_db == {}


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
