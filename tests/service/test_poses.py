"""Poses of another simulator: what is refused, and how they are moved on until they act."""

import math
from typing import Any

import pytest

from radar_service.numerics.constants import KNOT
from radar_service.service.poses import MAX_EXTRAPOLATION, PoseReader
from radar_service.world.commands import CommandError
from tests.service.fake import steerable_scene

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
