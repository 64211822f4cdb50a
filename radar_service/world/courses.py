"""Courses of ships: routes with rounded corners, whose arcs join straight legs and are tangent to both, and manoeuvres."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion, move_along_arc

MIN_CORNER = 1e-9  # rad; a smaller change of course is not a corner
MAX_CORNER = np.pi - 0.02  # rad; a sharper corner needs legs of a hundred radii


class RoundedRoute(NamedTuple):
    """Knots of a route with rounded corners; the last knot is its end.

    time: (M,) [s]. position: (M, 3) [m]. arcs: (M, 3) of the leg that begins at each knot: course [rad], speed [m/s] and
    turn rate [rad/s], 0 for a straight leg.
    """

    time: Floats
    position: Floats
    arcs: Floats


def round_corners(stops: Floats, speeds: Sequence[float], radius: Floats, loop: bool, location: str) -> RoundedRoute:
    """Returns the route through stops (S, 3) [m] with an arc at each corner.

    stops: neighbours differ. speeds: (S - 1,) of the leg to each stop but the first [m/s]; an arc has the speed of the
    leg before it. radius: (S - 1,) of the arc after each leg [m]. loop: the last stop is the first, and its corner is
    rounded too; the route begins in the middle of that arc. location: key path of the radius or turn rate, for messages.
    Raises SceneError if a leg is too short for its arcs (with what fits) or a corner is too sharp.
    """
    steps = np.diff(stops, axis=0)
    length, course = np.linalg.norm(steps, axis=1), np.arctan2(steps[:, 0], steps[:, 1])
    corner = (np.roll(course, -1) - course + np.pi) % (2.0 * np.pi) - np.pi  # at the end of each leg
    if not loop:
        corner[-1] = 0.0
    corner[np.abs(corner) < MIN_CORNER] = 0.0
    _check(corner, length, radius, location)
    cut = radius * np.tan(np.abs(corner) / 2.0)
    previous_cut = np.roll(cut, 1)
    segments: list[tuple[float, float, float, float]] = []  # duration, course, speed, rate
    for k, speed in enumerate(speeds):
        straight = length[k] - previous_cut[k] - cut[k]
        segments.append((straight / speed, course[k], speed, 0.0))
        if corner[k]:
            rate = speed / radius[k] * np.sign(corner[k])
            segments.append((corner[k] / rate, course[k], speed, rate))
    start = stops[0].copy()
    if loop and corner[-1]:
        duration, first, speed, rate = segments.pop()
        segments.insert(0, (duration / 2.0, first + corner[-1] / 2.0, speed, rate))
        segments.append((duration / 2.0, first, speed, rate))
        inward = first + corner[-1] / 2.0 + np.sign(corner[-1]) * np.pi / 2.0
        offset = radius[-1] * (1.0 / np.cos(corner[-1] / 2.0) - 1.0)
        start[:2] += offset * np.array([np.sin(inward), np.cos(inward)])
    return _knots(start, [segment for segment in segments if segment[0] > 0.0])


def _knots(start: Floats, segments: list[tuple[float, float, float, float]]) -> RoundedRoute:
    duration, course, speed, rate = np.array(segments).T
    steps = np.stack([speed * duration * np.sin(course), speed * duration * np.cos(course), 0.0 * course], axis=-1)
    curved = rate != 0.0
    steps[curved] = move_along_arc(course[curved], speed[curved], rate[curved], duration[curved])[0]
    time = np.concatenate([[0.0], np.cumsum(duration)])
    position = np.concatenate([start[None], start + np.cumsum(steps, axis=0)])
    arcs = np.concatenate([np.array(segments)[:, 1:], [[course[-1] + rate[-1] * duration[-1], 0.0, 0.0]]])
    return RoundedRoute(time, position, arcs)


def _check(corner: Floats, length: Floats, radius: Floats, location: str) -> None:
    sharp = np.flatnonzero(np.abs(corner) > MAX_CORNER)
    if len(sharp):
        raise SceneError(
            f"{location}: the track reverses its course at waypoints[{sharp[0]}]; a corner of at most "
            f"{np.rad2deg(MAX_CORNER):.0f} degrees can be rounded: add a waypoint beside it"
        )
    cut = radius * np.tan(np.abs(corner) / 2.0)
    needed = cut + np.roll(cut, 1)
    short = np.flatnonzero(needed > length * (1.0 + 1e-12))
    if len(short):
        k = int(short[np.argmin((length / np.where(needed > 0.0, needed, 1.0))[short])])
        share = length[k] / needed[k]
        leg = f"for the leg of {length[k]:.1f} m to waypoints[{k}]"
        if location.endswith("turn_radius_m"):
            raise SceneError(
                f"{location}: {radius[k]:g} m is too large {leg}; at most {radius[k] * share:.1f} m is possible there: lower "
                "it or move the waypoints apart"
            )
        raise SceneError(
            f"{location}: too slow {leg}; {1.0 / share:.3g} times as fast is possible there: raise it or move the waypoints apart"
        )


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
