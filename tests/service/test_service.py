"""The short modules of service, each under its name."""

import dataclasses
import hmac
import math
from itertools import product
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.display.video import Controls, display_video
from radar_service.numerics.constants import KNOT
from radar_service.service import access as access_module
from radar_service.service.access import (
    MAX_TICKETS,
    TICKET_SECONDS,
    Access,
    Tickets,
    checked_token,
    is_loopback,
    told_fields,
    told_plan,
)
from radar_service.service.codecs.native.messages import scene_fields
from radar_service.service.feed_request import FeedRequest, View
from radar_service.service.poses import MAX_EXTRAPOLATION, PoseReader
from radar_service.service.scene_request import ProcessSimulator, cell_layout
from radar_service.service.settings import Pace
from radar_service.service.spokes import Epoch, SpokeBatch, new_epoch_name
from radar_service.service.token_bucket import TokenBucket
from radar_service.world.commands import CommandError
from radar_service.world.scene import outline_of
from tests.scenes import TWO_RADARS, averaging
from tests.service.fake import BINS, STEP, FakeEngine, scene, steerable_scene


# access: what is told of a plan and of warnings, with the truth and without.
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
    outline = dataclasses.replace(outline_of(scene()), warnings=("body[0]: odd",))
    assert scene_fields(outline, knows)["warnings"] == told


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


# spokes: the records between a radar and its sinks.


def test_the_cells_of_an_epoch_end_at_its_range() -> None:
    assert Epoch("e", FakeEngine(scene()), 100.0).layout(None).bins == 10


@pytest.mark.parametrize("controls", [Controls(), Controls(60, 30, 20, False, False, 1.5, True, True)])
def test_the_video_of_a_view_is_that_of_the_display(controls: Controls) -> None:
    """To the byte, in as many bins as a view asks for: the highest byte of a bin is that of its highest level."""
    engine = FakeEngine(scene())
    draw = np.random.default_rng(5)
    levels = [(10.0 ** draw.uniform(-17, -9, (4, 20))).astype(np.float32) for _ in range(2)]
    block = dataclasses.replace(engine.block(3, 4), power=levels[0])
    for display_range, bins in product((None, 130.0), (None, 20, 11, 7, 3, 1)):
        epoch = Epoch("e", engine, display_range)
        batch = SpokeBatch(epoch, 0, block, controls, levels[1][0], levels[1])
        to = epoch.layout(bins)
        expected = display_video(levels[0], to, controls, engine.noise_power, levels[1][0], levels[1])
        assert expected.any() and expected.shape == (4, to.bins)
        for _ in range(2):
            np.testing.assert_array_equal(batch.video_bytes(to), expected)


def test_no_two_epochs_have_the_same_name() -> None:
    assert len({new_epoch_name() for _ in range(100)}) == 100


# access: tokens, tickets and host names.
COMMAND, READ = "command-" * 3, "reading-" * 3


def test_a_ticket_lasts_only_so_long_and_their_number_is_bounded() -> None:
    now = 0.0
    tickets = Tickets(lambda: now)
    kept, late = tickets.issue("command"), tickets.issue("read")
    now = TICKET_SECONDS
    assert tickets.redeem(kept) == "command" and tickets.redeem(kept) is None
    now += 0.1
    assert tickets.redeem(late) is None
    first = tickets.issue("read")
    for _ in range(MAX_TICKETS):
        tickets.issue("read")
    assert tickets.redeem(first) is None and len(tickets) == MAX_TICKETS
    now *= 3
    tickets.issue(None)
    assert len(tickets) == 1


def test_every_secret_is_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bytes] = []
    true_compare = hmac.compare_digest

    def compare(a: bytes, b: bytes) -> bool:
        seen.append(b)
        return true_compare(a, b)

    monkeypatch.setattr(access_module.hmac, "compare_digest", compare)
    for given in (COMMAND, READ, "neither"):
        seen.clear()
        Access(COMMAND, READ).role(f"Bearer {given}")
        assert sorted(seen) == sorted([COMMAND.encode(), READ.encode()])


@pytest.mark.parametrize("bad", ["", "short", "x" * 15, "x" * 513, "with space " * 3, "tab\t" * 8, "ünïcödé" * 4])
def test_a_weak_token_is_refused_without_repeating_it(bad: str) -> None:
    with pytest.raises(ValueError, match="^token: ") as caught:
        checked_token(bad)
    assert not bad or bad not in str(caught.value)
    assert checked_token("x" * 16) == "x" * 16


@pytest.mark.parametrize(
    ("host", "only_here"),
    [("127.0.0.1", True), ("127.8.9.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("::", False),
     ("192.168.1.5", False), ("radar.lan", False), ("", False)],
)  # fmt: skip
def test_loopback_is_known(host: str, only_here: bool) -> None:
    assert is_loopback(host) is only_here


# poses: poses of another simulator: what is refused, and how they are moved on until they act.
STEERABLE = steerable_scene().steerable


def values_at(at: float, **message: Any) -> dict[str, Any]:
    return dict(PoseReader().read(message, STEERABLE).values_at(at))


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ([], "a pose is an object with body, time and position_m"),
        ({"body": "buoy", "speed": 1}, "speed: not a key of a pose; allowed are body, time, position_m"),
        ({"body": 3, "speed_kn": 1}, "body: 3 is not a name"),
        ({"body": "boy", "speed_kn": 1}, 'the scene has no "boy"'),
        ({"body": "the rock/1", "speed_kn": 1}, "is not steerable"),
        ({"body": "buoy"}, "a command without a value"),
        ({"body": "buoy", "position_m": [math.nan, 0]}, "position_m[0]: nan is not a number"),
        ({"body": "buoy", "speed_kn": 21}, "speed_kn: 21 is not allowed; 0 to 20"),
        ({"body": "buoy", "speed_kn": 1, "time": math.nan}, "time: nan is not a number"),
        ({"body": "buoy", "speed_kn": 1, "time": "now"}, "time: now is not a number"),
        ({"present": False}, "own ship is always present"),
    ],
)
def test_messages_that_are_refused(message: Any, words: str) -> None:
    with pytest.raises(CommandError) as refused:
        PoseReader().read(message, STEERABLE)
    assert words in str(refused.value)


def test_poses_of_a_body_come_in_order() -> None:
    poses = PoseReader()
    for message in ({"time": 5.0}, {"body": "buoy", "time": 3.0}, {"body": "buoy", "time": 3.1}, {}):
        poses.read({"speed_kn": 1} | message, STEERABLE)
    with pytest.raises(CommandError, match="time: 3.1 is not after that of the pose before, 3.1; send poses in order"):
        poses.read({"speed_kn": 1, "body": "buoy", "time": 3.1}, STEERABLE)


def test_a_pose_without_time_holds_when_it_acts() -> None:
    assert values_at(77.0, position_m=[1, 2], course_deg=90, speed_kn=3) == {
        "position_m": (1.0, 2.0), "course_deg": 90.0, "speed_kn": 3.0, "at_once": True
    }  # fmt: skip
    assert values_at(77.0, heading_deg=30) == {"heading_deg": 30.0, "course_deg": 30.0, "at_once": True}
    assert values_at(77.0, body="buoy", present=False) == {"present": False}


@pytest.mark.parametrize("elapsed", [2.0, -1.0])
def test_a_pose_is_moved_on_until_it_acts(elapsed: float) -> None:
    pose = {"position_m": [1, 2], "course_deg": 90, "heading_deg": 95, "speed_kn": 3, "time": 10.0}
    moved = values_at(10.0 + elapsed, **pose)
    assert moved["position_m"] == pytest.approx((1 + 3 * KNOT * elapsed, 2.0), abs=1e-12)
    assert (moved["course_deg"], moved["heading_deg"]) == (90.0, 95.0)
    turned = values_at(10.0 + elapsed, turn_rate_deg_s=5, **pose)
    assert (turned["course_deg"], turned["heading_deg"]) == (90.0 + 5 * elapsed, 95.0 + 5 * elapsed)
    radius, angle = 3 * KNOT / math.radians(5), math.radians(5 * elapsed)
    arc = (1 + radius * math.sin(angle), 2 - radius * (1 - math.cos(angle)))
    assert turned["position_m"] == pytest.approx(arc, abs=1e-9)


def test_a_pose_from_the_past_or_the_future_is_refused() -> None:
    far = MAX_EXTRAPOLATION + 0.5
    with pytest.raises(CommandError, match="time: 10 is 5.5 s before the spoke that is next, at 15.5 s; at most 5 s"):
        values_at(10.0 + far, time=10.0, speed_kn=3)
    with pytest.raises(CommandError, match="time: 10 is 5.5 s after the spoke"):
        values_at(10.0 - far, time=10.0, speed_kn=3)
