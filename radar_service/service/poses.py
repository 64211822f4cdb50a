"""Poses of own ship and bodies that another simulator sends: what they may say, and what they order when they act."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from radar_service.numerics import KNOT
from radar_service.world import CommandError, MotionSegment, Steerable

KEYS = ("position_m", "course_deg", "heading_deg", "speed_kn", "turn_rate_deg_s", "present")  # besides body and time
MAX_EXTRAPOLATION = 5.0  # s between the time of a pose and the first spoke that shows it


@dataclass(frozen=True)
class CommandedPose:
    """The state of own ship (body None) or of a body at `time` [s]; None: at the first spoke that shows it.

    values: as the keys of a command.
    """

    body: str | None
    time: float | None
    values: Mapping[str, Any]

    def values_at(self, time: float) -> Mapping[str, Any]:
        """Returns the values of the command that acts at `time` [s]: the pose, moved on until then.

        Raises CommandError where the pose is too far from that time.
        """
        values = dict(self.values)
        if "heading_deg" in values:
            values.setdefault("course_deg", values["heading_deg"])
        if "course_deg" in values:
            values["at_once"] = True
        if self.time is None:
            return values
        elapsed = time - self.time
        if abs(elapsed) > MAX_EXTRAPOLATION:
            when = "before" if elapsed > 0.0 else "after"
            raise CommandError(
                f"time: {self.time:g} is {abs(elapsed):.3g} s {when} the spoke that is next, at {time:g} s; at most "
                f"{MAX_EXTRAPOLATION:g} s are allowed: send poses sooner, or leave time out"
            )
        return values | _moved(values, elapsed)


class PoseReader:
    """Reads the poses of one sender, in order."""

    def __init__(self) -> None:
        self._latest: dict[str | None, float] = {}

    def read(self, message: object, steerable: Steerable) -> CommandedPose:
        """Returns the pose of a message. Raises CommandError."""
        if not isinstance(message, dict):
            raise CommandError(f"a pose is an object with body, time and {', '.join(KEYS)}")
        values = dict(message)
        body, time = values.pop("body", None), values.pop("time", None)
        unknown = [key for key in values if key not in KEYS]
        if unknown:
            raise CommandError(f"{str(unknown[0])[:100]}: not a key of a pose; allowed are body, time, {', '.join(KEYS)}")
        if not (body is None or isinstance(body, str)):
            raise CommandError(f"body: {str(body)[:100]} is not a name; leave it out for own ship")
        pose = CommandedPose(body, self._checked_time(body, time), steerable.checked(body, values))
        if pose.time is not None:
            self._latest[body] = pose.time
        return pose

    def _checked_time(self, body: str | None, time: object) -> float | None:
        if time is None:
            return None
        if isinstance(time, bool) or not isinstance(time, int | float) or not math.isfinite(time):
            raise CommandError(f"time: {str(time)[:100]} is not a number; give simulated seconds, or leave it out")
        if time <= self._latest.get(body, -math.inf):
            raise CommandError(
                f"time: {time:g} is not after that of the pose before, {self._latest[body]:g}; send poses in order"
            )
        return float(time)


def _moved(values: Mapping[str, Any], elapsed: float) -> dict[str, Any]:
    """The values that change over `elapsed` [s] of motion."""
    rate = values.get("turn_rate_deg_s", 0.0)
    moved = {key: (values[key] + rate * elapsed) % 360.0 for key in ("course_deg", "heading_deg") if key in values}
    if {"position_m", "course_deg", "speed_kn"} <= values.keys():
        position = np.array([*values["position_m"], 0.0])
        segment = MotionSegment(
            0.0, position, math.radians(values["course_deg"]), values["speed_kn"] * KNOT, math.radians(rate)
        )
        east, north, _ = segment.at(elapsed).position.tolist()
        moved["position_m"] = (east, north)
    return moved
