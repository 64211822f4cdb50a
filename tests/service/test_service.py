"""The short modules of service, each under its name."""

import math

import pytest

import radar_service as rs
from radar_service.service.access import told_fields, told_plan, told_warnings
from radar_service.service.feed_request import FeedRequest, View
from radar_service.service.scene_request import ProcessSimulator, cell_layout
from radar_service.service.settings import Pace
from radar_service.service.token_bucket import TokenBucket
from tests.scenes import TWO_RADARS, averaging
from tests.service.fake import BINS, STEP, FakeEngine, scene


# blind: what is told of a plan and of warnings, with the truth and without.
def test_without_the_truth_a_plan_has_its_methods_and_no_body() -> None:
    plan = rs.Simulator(rs.load_scene(TWO_RADARS).for_radar(None), "fast").plan.as_dict()
    told = told_plan(plan, False)
    about = [choice["what"] for choice in plan["choices"]]
    assert (
        [choice["what"] for choice in told["choices"]] == [what for what in about if not what.startswith("body ")] != about
    )
    assert told["settings"] == plan["settings"] and told["caveats"] == [] and told["counts"] is None
    assert "moving" in plan["field_db"] and told["field_db"] == {} and told["costs"] is None
    assert told_plan(plan, True) == plan


@pytest.mark.parametrize(("knows", "told"), [(True, ["body[0]: odd"]), (False, [])])
def test_warnings_name_bodies(knows: bool, told: list[str]) -> None:
    assert told_warnings(("body[0]: odd",), knows) == told


def test_a_program_under_test_learns_neither_the_seed_nor_how_many_bodies_there_are() -> None:
    fields = {"seed": 7, "scene": {"name": "n", "bodies": 3}, "rpm": 24.0}
    assert told_fields(fields, True) == {"seed": 0, "scene": {"name": "", "bodies": 0}, "rpm": 24.0}
    assert told_fields(fields, False) == fields


# feed_request: views: equal ones share their bytes.
def test_views_are_equal_by_all_that_changes_their_bytes() -> None:
    views = [View("u8"), View("f32"), View("u8", 5), View("u8", sector=(0, 9)), View("u8", spokes=2),
             View("u8", compression="zstd"), View("u8", codec="other")]  # fmt: skip
    assert len(set(views)) == len(views) and View("u8") in set(views)


def test_plain_data_holds_what_a_view_filters() -> None:
    assert View("u8", 5, (350, 10), 4, "zstd").as_dict() == {"sector_deg": [350, 10], "spokes": 4, "compression": "zstd"}
    assert FeedRequest().view.as_dict() == {"sector_deg": None, "spokes": 1, "compression": ""}


def test_a_view_is_whole_where_each_spoke_is_a_row() -> None:
    assert View("u8").is_whole and View("f32", 5, compression="zstd", labels=True, powers="all").is_whole
    assert not View("u8", sector=(0, 360)).is_whole and not View("u8", spokes=2).is_whole


# scene_request: what the stream needs of a simulator, and what it makes of its range cells.
def test_tests_have_what_computes_in_the_process_of_a_world() -> None:
    source: ProcessSimulator = FakeEngine(scene())
    assert {name for name in dir(ProcessSimulator) if not name.startswith("_")} <= set(dir(source))


def test_cells_become_bins_out_to_a_range() -> None:
    to = cell_layout(FakeEngine(scene()).info, 5, 100.0)
    assert (to.samples, to.bins) == (10, 5) and to.range == pytest.approx(100.0) and to.step == pytest.approx(2 * STEP)
    assert cell_layout(FakeEngine(scene()).info, None, None).bins == BINS
    averaged = FakeEngine(scene(**averaging({"azimuths": 60, "rpm": 60}, 5)))
    assert cell_layout(averaged.info, None, None).pulses == 5 and to.pulses == 1


# settings: the settings of a radar.
@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan])
def test_a_factor_that_is_not_positive_is_refused(factor: float) -> None:
    with pytest.raises(ValueError, match="pace.factor"):
        Pace("run", factor)


def test_a_pace_is_plain_data() -> None:
    assert Pace("pause", math.inf).as_dict() == {"state": "pause", "factor": "max"}
    assert Pace().as_dict() == {"state": "run", "factor": 1.0}


# token_bucket: A token bucket allows its rate on average and its burst at once.
def test_a_burst_and_then_the_rate() -> None:
    now = [0.0]
    bucket = TokenBucket(10.0, 5.0, lambda: now[0])
    assert bucket.take(5) and not bucket.take(1)
    now[0] = 0.25
    assert not bucket.take(3) and bucket.take(2) and not bucket.take(1)
    now[0] = 1000.0
    assert not bucket.take(6) and bucket.take(5)
