"""Motion that commands change while the radar runs: segments and arcs one after the other, each from an instant on."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from typing_extensions import override

from radar_service.numerics import KNOT, Flags, Floats
from radar_service.world.motion import Motion, Pose, in_stream, move_along_arc
from radar_service.world.seaway import NO_STREAM, Stream, SwayLaw, SwayState, crab_angle
from radar_service.world.seaway_motion import EASING

LOOK_BACK = 12_000.0  # s: so long a segment continues backward: two rotations at 0.01 rpm; the engine looks back for one
MAX_SEGMENTS = 1024  # remembered, of each motion: 20 s of poses at 50 Hz


@dataclass(frozen=True)
class SteeringLimits:
    """What commands may order. max_speed: [m/s]. max_turn_rate: [rad/s], above 0."""

    max_speed: float
    max_turn_rate: float


class MotionSegment(NamedTuple):
    """A straight segment, or an arc and the straight segment after it.

    start: when it begins [s].
    position: (3,) there [m].
    course: there [rad].
    speed: [m/s].
    turn_rate: of the arc, positive to starboard [rad/s]; 0 for a straight segment.
    turn_time: length of the arc [s]; inf for one without end.
    drift: heading minus course [rad]: minus course through the water, where there is a stream.
    stood: heading off the course of a ship that stands [rad]: the crab angle with which it stopped.
    excess: eased velocity, to which the ship responds in a seaway, minus its own at the start, east and north [m/s].
    """

    start: float
    position: Floats
    course: float
    speed: float
    turn_rate: float = 0.0
    turn_time: float = math.inf
    drift: float = 0.0
    stood: float = 0.0
    excess: tuple[float, float] = (0.0, 0.0)

    def at(self, time: float) -> "MotionSegment":
        """Returns the rest of the segment from `time` [s] on."""
        elapsed = time - self.start
        turned = min(elapsed, self.turn_time) if self.turn_rate else 0.0
        course = self.course + self.turn_rate * turned
        position = (
            self.position + self._along(self.course, self.turn_rate, turned) + self._along(course, 0.0, elapsed - turned)
        )
        left = self.turn_time - turned
        rate = self.turn_rate if left > 0.0 else 0.0
        east, north = self.excess
        less = math.exp(-elapsed / EASING)
        return self._replace(
            start=time, position=position, course=course, turn_rate=rate, turn_time=left if rate else math.inf,
            excess=(less * east, less * north),
        )  # fmt: skip

    @property
    def velocity(self) -> Floats:
        """Velocity (3,) over ground at its start [m/s]."""
        return self._along(self.course, 0.0, 1.0)

    def after(self, before: "MotionSegment") -> "MotionSegment":
        """Returns the segment as it follows `before` from its start: the eased velocity is still that of `before`."""
        lost = before.velocity - self.velocity
        return self._replace(excess=(before.excess[0] + float(lost[0]), before.excess[1] + float(lost[1])))

    def with_heading(self, heading: float, stream: Stream) -> "MotionSegment":
        """Returns the segment with a heading [rad] at its start."""
        return self._replace(drift=math.remainder(heading - self.course - self.crab(stream), 2.0 * math.pi))

    def crab(self, stream: Stream) -> float:
        """Returns course through the water minus course over ground [rad] at its start."""
        if not self.speed:
            return self.stood
        return float(crab_angle(self.velocity, stream))

    def motion(self, sway: SwayLaw | None, stream: Stream = NO_STREAM) -> Motion:
        """Returns the motion along the segment, which continues backward over LOOK_BACK. stream: of the water,
        east and north [m/s]."""
        before = self.course - self.turn_rate * LOOK_BACK
        knots = [(self.start - LOOK_BACK, before, self.turn_rate), (self.start, self.course, self.turn_rate)]
        position = [self.position - self._along(before, self.turn_rate, LOOK_BACK), self.position]
        if self.turn_rate and math.isfinite(self.turn_time):
            end = self.at(self.start + self.turn_time)
            knots.append((end.start, end.course, 0.0))
            position.append(end.position)
        time, course, rate = np.array(knots).T
        arcs = np.stack([course, np.full(len(time), self.speed), rate], axis=1)
        velocity = self._along(float(course[-1]), 0.0, 1.0)
        drift = self.drift if self.speed else self.drift + self.stood
        sway = None if sway is None else sway.eased(self.excess, self.start)
        segment_motion = Motion(time, np.array(position), course + drift, velocity, arcs=arcs, sway=sway)
        return in_stream(segment_motion, stream, keeps_heading=False)

    def _along(self, course: float, rate: float, elapsed: float) -> Floats:
        """Displacement (3,) [m] in `elapsed` [s] from a course [rad], turning at `rate` [rad/s]."""
        if rate == 0.0:
            return self.speed * elapsed * np.array([math.sin(course), math.cos(course), 0.0])
        displacement, _ = move_along_arc(*(np.array([value]) for value in (course, self.speed, rate, elapsed)))
        return np.asarray(displacement[0])


class _MotionTrack:
    """What commands have made of a motion.

    first: the motion before the first command. current: the motion that `pose` follows.
    segments: those commanded. past: when they begin [s]; the first motion, and that of each segment.
    """

    def __init__(self, first: Motion) -> None:
        self.first = self.current = first
        self.segments: tuple[MotionSegment, ...] = ()
        self.past: tuple[Floats, tuple[Motion, ...]] = (np.zeros(0), (first,))


@dataclass(frozen=True)
class CommandedMotion(Motion):
    """A motion that commands may change at any time."""

    @property
    def at_rest(self) -> bool:
        """Whether position and heading never change: commands may change them."""
        return False

    @property
    def keeps_course(self) -> bool:
        """Whether it goes straight at one heading from its only knot on: commands may change that."""
        return False


@dataclass(frozen=True)
class SteeredMotion(CommandedMotion):
    """A motion under command. Its fields are those of the motion before the first command.

    `pose` and `turn_rate` follow the segment that `follow` has chosen last, also for earlier times: the engine computes no spoke
    from before the segment, and its methods look at times around each spoke. `past` follows the segment of each time.

    limits: of the commands.
    water: the stream, east and north [m/s], for which the heading allows under command.
    """

    limits: SteeringLimits = field(kw_only=True)
    water: Stream = field(default=NO_STREAM, kw_only=True, metadata={"added": 1})  # see truth.truth_file.scene_hash

    @classmethod
    def under(cls, motion: Motion, limits: SteeringLimits, water: Stream = NO_STREAM) -> Self:
        """Returns a motion that begins as `motion`, and that no command has changed yet."""
        return cls(**_fields(motion), limits=limits, water=water)

    @property
    @override
    def text(self) -> str:
        """What `check` says of it."""
        if self.at_rest:
            return super().text
        speed, rate = self.limits.max_speed / KNOT, math.degrees(self.limits.max_turn_rate)
        return f"{super().text}, steerable up to {speed:g} kn and {rate:g} degrees/s"

    @property
    def top_speed(self) -> float:
        """The highest speed [m/s] that it may have."""
        return max(self._track.first.top_speed, self.limits.max_speed)

    @property
    def top_turn_rate(self) -> float:
        """The highest rate [rad/s] at which it may turn."""
        return max(self._track.first.top_turn_rate, self.limits.max_turn_rate)

    def pose(self, time: Floats | float) -> Pose:
        """Returns the state at each `time` (K,) [s]."""
        return self._track.current.pose(time)

    def turn_rate(self, time: Floats | float) -> Floats:
        """Returns the rate (K,) [rad/s] at which the heading turns to starboard at each `time` (K,) [s]."""
        return self._track.current.turn_rate(time)

    @override
    def sway_state(self, time: Floats) -> SwayState:
        """The sway is that of the motion that `pose` follows."""
        return self._track.current.sway_state(time)

    @override
    def sway_rates(self, time: Floats) -> Floats:
        """The rates are those of the motion that `pose` follows."""
        return self._track.current.sway_rates(time)

    @override
    def corners(self, time: Floats) -> Flags:
        """The corners are those of the motion that `pose` follows."""
        return self._track.current.corners(time)

    def segment_at(self, time: float) -> MotionSegment:
        """Returns what is left of the segment of the last command at `time` [s]; before the first one, the course as it is."""
        if self._track.segments:
            return self._track.segments[-1].at(time)
        pose = replace(self._track.first, sway=None).pose(time)
        course, heading = float(pose.course[0]), float(pose.heading[0])
        excess = (0.0, 0.0) if self.sway is None else self.sway.excess(time)
        begun = MotionSegment(time, pose.position[0], course, float(pose.speed[0]), excess=excess)
        return begun.with_heading(heading, self.water)

    def steer(self, segment: MotionSegment) -> None:
        """Takes a segment from its start on. `pose` follows it after `follow`."""
        track, (start, motions) = self._track, self._track.past
        track.segments = (*track.segments[1 - MAX_SEGMENTS :], segment)
        track.past = (
            np.append(start[1 - MAX_SEGMENTS :], segment.start),
            (*motions[-MAX_SEGMENTS:], segment.motion(self.sway, self.water)),
        )

    def follow(self) -> None:
        """Lets `pose` follow the segment that was taken last."""
        self._track.current = self._track.past[1][-1]

    def forget(self) -> None:
        """Forgets all segments. `pose` goes on as before until `follow`."""
        self._track.segments, self._track.past = (), (np.zeros(0), (self._track.first,))

    @property
    def past(self) -> "PastMotion":
        """The same motion, which follows at each time the segment that was commanded then; it remembers MAX_SEGMENTS segments."""
        return PastMotion(**_fields(self), steered=self)

    def segments_at(self, time: Floats) -> list[tuple[Flags, Motion]]:
        """Returns the motions that were commanded at some times (K,) [s], each with the flags (K,) of its times."""
        start, motions = self._track.past
        segment = np.searchsorted(start, time, side="right")
        return [(segment == number, motions[number]) for number in np.unique(segment).tolist()]

    @cached_property
    def _track(self) -> _MotionTrack:
        return _MotionTrack(Motion(**_fields(self)))


@dataclass(frozen=True)
class PastMotion(CommandedMotion):
    """A motion under command as it was at each time, for the truth."""

    steered: SteeredMotion = field(kw_only=True)

    def pose(self, time: Floats | float) -> Pose:
        """Returns the state at each `time` (K,) [s]."""
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        order: list[int] = []
        parts = [self.steered.pose(t[:0])]
        for which, motion in self.steered.segments_at(t):
            order += np.flatnonzero(which).tolist()
            parts.append(motion.pose(t[which]))
        if len(parts) == 2:
            return parts[1]
        back = np.argsort(np.array(order, dtype=np.int64))
        position, velocity, heading = (np.concatenate(column)[back] for column in list(zip(*parts, strict=True))[:3])
        optional = ([column for column in columns if column is not None] for columns in list(zip(*parts, strict=True))[3:])
        return Pose(position, velocity, heading, *(np.concatenate(parts)[back] if parts else None for parts in optional))

    def turn_rate(self, time: Floats | float) -> Floats:
        """Returns the rate (K,) [rad/s] at which the heading turns to starboard at each `time` (K,) [s]."""
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        rate = np.empty(len(t))
        for which, motion in self.steered.segments_at(t):
            rate[which] = motion.turn_rate(t[which])
        return rate

    @override
    def sway_state(self, time: Floats) -> SwayState:
        """The sway is that of the segment of each time."""
        state = SwayState(*np.empty((2, len(time), 4)))
        for which, motion in self.steered.segments_at(time):
            for column, values in zip(state, motion.sway_state(time[which]), strict=True):
                column[which] = values
        return state

    @override
    def corners(self, time: Floats) -> Flags:
        """Each command begins another segment."""
        corners = np.zeros(max(len(time) - 1, 0), dtype=np.bool_)
        for which, motion in self.steered.segments_at(time):
            corners |= np.where(which[1:] == which[:-1], which[1:] & motion.corners(time), True)
        return corners


def _fields(motion: Motion) -> dict[str, Any]:
    return {field.name: getattr(motion, field.name) for field in fields(Motion)}
