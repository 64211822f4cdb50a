"""Motion that changes course and speed at given times, or turns at a constant rate."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats
from radar_service.world.motion import Motion
from radar_service.world.waypoint_arcs import move_along_arc


class Manoeuvre(NamedTuple):
    """A change at `time` [s]; None: as before.

    course: to which the body turns [rad]; None with a turn rate: it turns until the next manoeuvre.
    speed: from then on [m/s].
    turn_rate: to starboard [rad/s]; towards a course its size alone counts; None: the course changes at once.
    """

    time: float
    course: float | None
    speed: float | None
    turn_rate: float | None


class Knot(NamedTuple):
    """A body at `time` [s]: position (3,) [m], and course [rad], speed [m/s] and turn rate [rad/s] from then on."""

    time: float
    position: Floats
    course: float
    speed: float
    turn_rate: float

    def later(self, time: float) -> "Knot":
        """Returns the body at a later time [s]."""
        elapsed = time - self.time
        course = self.course + self.turn_rate * elapsed
        way = self.speed * elapsed * np.array([math.sin(self.course), math.cos(self.course), 0.0])
        if self.turn_rate:
            begin, speed, rate, duration = (
                np.array([value]) for value in (self.course, self.speed, self.turn_rate, elapsed)
            )
            way = move_along_arc(begin, speed, rate, duration)[0][0]
        return Knot(time, self.position + way, course, self.speed, self.turn_rate)


def motion_with_manoeuvres(start: Knot, manoeuvres: Sequence[Manoeuvre]) -> Motion:
    """Returns the motion from a start through manoeuvres of rising times; the heading follows the course.

    Turns to a course take the shorter way, to starboard where both are equal. A new course or rate ends a turn that is under
    way; a new speed does not.
    """
    knots = [start]
    for manoeuvre in manoeuvres:
        knots = _with_manoeuvre(knots, manoeuvre)
    for k in range(1, len(knots)):
        knots[k] = knots[k]._replace(position=knots[k - 1].later(knots[k].time).position)
    arcs = np.array([[knot.course, knot.speed, knot.turn_rate] for knot in knots])
    last = knots[-1]
    velocity = last.speed * np.array([math.sin(last.course), math.cos(last.course), 0.0])
    time, position = np.array([knot.time for knot in knots]), np.array([knot.position for knot in knots])
    return Motion(time, position, arcs[:, 0].copy(), velocity, arcs=arcs)


def _with_manoeuvre(knots: list[Knot], manoeuvre: Manoeuvre) -> list[Knot]:
    """The knots with one more manoeuvre; their positions are not kept up to date."""
    time, speed = manoeuvre.time, manoeuvre.speed
    before, after = [knot for knot in knots if knot.time < time], [knot for knot in knots if knot.time > time]
    now = [knot for knot in knots if knot.time <= time][-1].later(time)
    keeps_turning = manoeuvre.course is None and manoeuvre.turn_rate is None
    following = [now, *after] if keeps_turning else _turned(now, manoeuvre)  # after: the end of a turn that is under way
    return before + [knot if speed is None else knot._replace(speed=speed) for knot in following]


def _turned(now: Knot, manoeuvre: Manoeuvre) -> list[Knot]:
    """The knots from a manoeuvre on: one, or that of its turn and that of the course after it."""
    rate, course = manoeuvre.turn_rate, manoeuvre.course
    if course is None:
        return [now if rate is None else now._replace(turn_rate=rate)]
    turn = math.pi - (math.pi - (course - now.course)) % (2.0 * math.pi)  # in (-pi, pi]
    if rate is None or not turn:
        return [now._replace(course=course, turn_rate=0.0)]
    return [
        now._replace(turn_rate=math.copysign(rate, turn)),
        now._replace(time=now.time + abs(turn / rate), course=course, turn_rate=0.0),
    ]
