"""What is told of a plan and of warnings, with the truth and without."""

import pytest

import radar_service as rs
from radar_service.service.blind import told_fields, told_plan, told_warnings
from tests.scenes import TWO_RADARS


def test_without_the_truth_a_plan_has_its_methods_and_no_body() -> None:
    plan = rs.Simulator(rs.load_scene(TWO_RADARS).for_radar(None), "fast").plan.as_dict()
    told = told_plan(plan, False)
    about = [choice["what"] for choice in plan["choices"]]
    assert (
        [choice["what"] for choice in told["choices"]] == [what for what in about if not what.startswith("body ")] != about
    )
    assert told["settings"] == plan["settings"] and told["caveats"] == [] and told["counts"] is None
    assert told_plan(plan, True) == plan


@pytest.mark.parametrize(("knows", "told"), [(True, ["body[0]: odd"]), (False, [])])
def test_warnings_name_bodies(knows: bool, told: list[str]) -> None:
    assert told_warnings(("body[0]: odd",), knows) == told


def test_a_program_under_test_learns_neither_the_seed_nor_how_many_bodies_there_are() -> None:
    fields = {"seed": 7, "scene": {"name": "n", "bodies": 3}, "rpm": 24.0}
    assert told_fields(fields, True) == {"seed": 0, "scene": {"name": "n", "bodies": 0}, "rpm": 24.0}
    assert told_fields(fields, False) == fields
