"""Records of motion: the pose of a body at given times, and a motion through knots."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from radar_service.numerics import KNOT, Flags, Floats, Indices, ResultCache, bearing_text, wrap_bearing
from radar_service.world.seaway import NO_STREAM, Stream, SwayLaw, SwayState, UprightMotion, crab_angle, turn_factor


class Pose(NamedTuple):
    """State at K times: position (K, 3) [m], velocity (K, 3) [m/s], heading (K,) [rad] in [0, 2 pi).

    rotation: matrices (K, 3, 3) map_from_body of what rolls or pitches; None: the heading alone turns the body.
    heave: (K,) by which sway lifts the position [m]; None without sway.
    """

    position: Floats
    velocity: Floats
    heading: Floats
    rotation: Floats | None = None
    heave: Floats | None = None

    @property
    def course(self) -> Floats:
        """Course over ground (K,) [rad] in [0, 2 pi); the heading of a body at rest."""
        moving = np.hypot(self.velocity[:, 0], self.velocity[:, 1]) > 0
        return wrap_bearing(np.where(moving, np.arctan2(self.velocity[:, 0], self.velocity[:, 1]), self.heading))

    @property
    def speed(self) -> Floats:
        """Speed over ground (K,) [m/s]."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])


@dataclass(frozen=True)
class Motion:
    """Motion through knots along straight segments or arcs; the body is at rest before the first knot.

    time: (M,) of the knots [s], rising.
    position: (M, 3) of the knots [m].
    heading: (M,) [rad] on the segment that begins at each knot; with `turning`, at the knot, interpolated the short way.
    final_velocity: (3,) [m/s] after the last knot.
    turning: whether the heading is interpolated between knots.
    period: time after which a closed track repeats [s], or None.
    arcs: (M, 3) of the segment that begins at each knot: course [rad], speed [m/s] and turn rate [rad/s, 0: straight]; or None.
    fixed: whether the heading stays constant on arcs.
    sway: adds yaw to the heading, heave to the position, and roll and pitch; None for a body without sway.
    stream: for which the heading on arcs allows, east and north [m/s]; `heading` itself does so on straight segments.
    """

    time: Floats
    position: Floats
    heading: Floats
    final_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    turning: bool = False
    period: float | None = None
    arcs: Floats | None = None
    fixed: bool = False
    sway: SwayLaw | None = None
    stream: Stream = field(default=NO_STREAM, metadata={"added": 1})  # see truth.truth_file.scene_hash

    def __post_init__(self) -> None:
        assert self.time.ndim == 1 and self.position.shape == (self.time.size, 3) and self.heading.shape == self.time.shape

    @cached_property
    def at_rest(self) -> bool:
        """Whether position and heading never change."""
        resting = bool(np.all(self.position == self.position[0]) and not self.final_velocity.any()) and not self.final_turn
        return resting and bool(np.all(self.heading == self.heading[0])) and self.sway is None

    @cached_property
    def keeps_course(self) -> bool:
        """Whether it goes straight at one heading from its only knot on, but for its sway."""
        return len(self.time) == 1 and not self.final_turn

    @cached_property
    def is_straight(self) -> bool:
        """Whether it goes straight at one heading from its only knot on."""
        return self.keeps_course and self.sway is None

    def is_even(self, time: Floats) -> bool:
        """Whether it certainly rests, or goes straight at one speed, throughout times (K,) [s]."""
        return self.at_rest or (self.is_straight and bool(self.time[0] <= time.min()))

    @property
    def final_turn(self) -> float:
        """The rate [rad/s] at which it turns for ever after the last knot."""
        return 0.0 if self.arcs is None or self.period is not None else float(self.arcs[-1, 2])

    @cached_property
    def top_speed(self) -> float:
        """The highest speed [m/s] on any segment or arc, and beyond the last knot; sway not counted."""
        on_segments = np.linalg.norm(self.segment_velocity, axis=1).max()
        arcs = 0.0 if self.arcs is None else self.arcs[:, 1].max()
        return float(max(on_segments, arcs))

    @property
    def text(self) -> str:
        """What `check` says of it."""
        pose = self.pose(max(float(self.time[0]), 0.0))
        position = f"at east {pose.position[0, 0]:.1f}, north {pose.position[0, 1]:.1f}, up {pose.position[0, 2]:.1f} m"
        heading = f"heading {bearing_text(pose.heading[0])}{self.sway.text if self.sway else ''}"
        if self.at_rest:
            return f"{position}, {heading}, at rest"
        course = f"course {bearing_text(pose.course[0])}, {pose.speed[0] / KNOT:.1f} kn"
        arcs = 0 if self.arcs is None else int(np.count_nonzero(self.arcs[:-1, 2]))
        segments = f", {len(self.time) - 1 - arcs} legs" if len(self.time) > 1 else ""
        segments += f" and {arcs} arcs" if arcs else ""
        loop = f", repeats every {self.period:.0f} s" if self.period is not None else ""
        turn = f", at last turning at {math.degrees(self.final_turn):g} degrees/s" if self.final_turn else ""
        return f"{position}, {heading}, {course}{segments}{turn}{loop}"

    def pose(self, time: Floats | float) -> Pose:
        """Returns the state at each `time` (K,) [s]; with sway it is kept, and read only."""
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        if self.is_straight:
            return self._straight(t)
        return self._computed(t) if self.sway is None else self._kept.get(t.tobytes(), lambda: self._computed(t))

    def _computed(self, t: Floats) -> Pose:
        """Computes `pose`."""
        position, velocity, heading = self._upright(t)
        if self.sway is None:
            return Pose(position, velocity, wrap_bearing(heading))
        sway = self.sway.state(t, self)
        heading = wrap_bearing(heading + sway.values[:, 2])
        if self.sway.max_heave:
            position[:, 2] += sway.values[:, 3]
            velocity[:, 2] += sway.rates[:, 3]
        rotation = sway.rotation(heading) if self.sway.tilts else None
        for shared in (position, velocity, heading, sway.values, rotation):
            if shared is not None:
                shared.flags.writeable = False
        return Pose(position, velocity, heading, rotation, sway.values[:, 3])

    @cached_property
    def _kept(self) -> ResultCache[bytes, Pose]:
        """Poses at the latest times (K,), which are asked for again."""
        return ResultCache(8)  # in a strait in a seaway 44 % of the poses asked for are among so many

    def upright(self, time: Floats) -> UprightMotion:
        """Returns the motion without its sway at each time (K,) [s]."""
        since = time if self.period is None else time % self.period
        rests = since < self.time[0]
        position, velocity, heading = self._upright(time)
        velocity[rests] = 0.0
        course_rate = np.zeros(len(time))
        if self.arcs is not None:
            segment = np.searchsorted(self.time[1:], since, side="right")
            course_rate = np.where(rests, 0.0, self.arcs[segment, 2])
        return UprightMotion(position, velocity, heading, self._upright_turn_rate(time), course_rate)

    def sway_state(self, time: Floats) -> SwayState:
        """Returns the sway at each time (K,) [s]; 0 without one."""
        return SwayState(*np.zeros((2, len(time), 4))) if self.sway is None else self.sway.state(time, self)

    def sway_rates(self, time: Floats) -> Floats:
        """Returns the rates (K or 1, 4) [rad/s, m/s] of swings about each time (K,) [s], as a `SwayLaw`; 0 without sway."""
        return np.zeros((1, 4)) if self.sway is None else self.sway.rates_about(time, self)

    def turn_rate(self, time: Floats | float) -> Floats:
        """Returns the rate (K,) [rad/s] at which the heading turns to starboard at each `time` (K,) [s]."""
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        rate = self._upright_turn_rate(t)
        return rate if self.sway is None else rate + self.sway.state(t, self).rates[:, 2]

    @cached_property
    def top_turn_rate(self) -> float:
        """The highest rate [rad/s] at which the heading turns on any segment or arc; crab in a stream and sway not counted."""
        arcs = 0.0 if self.arcs is None or self.fixed else np.abs(self.arcs[:, 2]).max()
        return float(max(arcs, np.abs(self._segment_turn).max() if self.turning else 0.0))

    def knot_velocities(self) -> tuple[Floats, Floats]:
        """Returns the velocity (M, 2) [m/s] at the begin of the segment after each knot, and at its end; that after the last knot
        has no end, and its velocity stands for it."""
        span = np.append(np.diff(self.time), 0.0)
        begin = self.segment_velocity[:, :2].copy()
        end = begin.copy()
        if self.arcs is not None:
            curved = np.flatnonzero(self.arcs[:, 2])
            course, speed, rate = self.arcs[curved].T
            for velocity, elapsed in ((begin, 0.0 * span), (end, span)):
                velocity[curved] = move_along_arc(course, speed, rate, elapsed[curved])[1][:, :2]
        return begin, end

    def corners(self, time: Floats) -> Flags:
        """Returns whether another segment, or another lap, begins between each of `time` (K,) [s] and the next one (K - 1,).

        Between two of them without a corner the motion is smooth. It begins at the first knot, before which the body rests.
        """
        if self.at_rest:
            return np.zeros(max(len(time) - 1, 0), dtype=np.bool_)
        laps, since = (np.zeros(len(time)), time) if self.period is None else np.divmod(time, self.period)
        segment = np.searchsorted(self.time, since, side="right")
        return np.asarray((np.diff(segment) != 0) | (np.diff(laps) != 0.0))

    def _upright(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Position (K, 3) [m], velocity (K, 3) [m/s] and heading (K,) [rad], not wrapped, without sway at each time (K,) [s]."""
        if self.period is not None:
            t = t % self.period
        segment = np.searchsorted(self.time[1:], t, side="right")
        velocity = self.segment_velocity[segment]
        if t.size and t.min() < self.time[0]:
            velocity[t < self.time[0]] = 0.0
        elapsed = np.maximum(t - self.time[segment], 0.0)
        heading = self.heading[segment]
        if self.turning:
            heading = heading + self._segment_turn[segment] * elapsed
        displacement = velocity * elapsed[:, None]
        if self.arcs is not None:
            curved = np.flatnonzero(self.arcs[segment, 2])
            course, speed, rate = self.arcs[segment[curved]].T
            displacement[curved], velocity[curved] = move_along_arc(course, speed, rate, elapsed[curved])
            heading = heading if self.fixed else heading + self.arcs[segment, 2] * elapsed
            if any(self.stream) and not self.fixed:
                heading[curved] += crab_angle(velocity[curved], self.stream)
        return self.position[segment] + displacement, velocity, heading

    def _upright_turn_rate(self, t: Floats) -> Floats:
        """The rate (K,) [rad/s] at which the heading turns to starboard without sway at each time (K,) [s]."""
        since = t if self.period is None else t % self.period
        segment = np.searchsorted(self.time[1:], since, side="right")
        rate = self._segment_turn[segment] if self.turning else np.zeros(len(t))
        if self.arcs is not None and not self.fixed:
            rate = rate + self.arcs[segment, 2] * self._turn_factor(segment, since)
        return np.where(since < self.time[0], 0.0, rate)

    def _turn_factor(self, segment: Indices, t: Floats) -> Floats | float:
        """How many times as fast the heading turns as the course, on segments (K,) at times (K,) [s]."""
        if self.arcs is None or not any(self.stream):
            return 1.0
        course, speed, rate = self.arcs[segment].T
        now = course + rate * np.maximum(t - self.time[segment], 0.0)
        return turn_factor(np.stack([speed * np.sin(now), speed * np.cos(now)], axis=-1), self.stream)

    @cached_property
    def curved(self) -> Flags:
        """Which segments (M,) are arcs along which it moves."""
        if self.arcs is None:
            return np.zeros(len(self.time), dtype=np.bool_)
        return np.asarray((self.arcs[:, 2] != 0.0) & (self.arcs[:, 1] > 0.0))

    @cached_property
    def latest_velocity(self) -> Floats:
        """Velocity (M, 2) [m/s] at the end of each segment; where it stands, of the last one that moves; or 0."""
        _, velocity = self.knot_velocities()
        moves = np.flatnonzero(np.hypot(velocity[:, 0], velocity[:, 1]) > 0.0)
        if not len(moves):
            return np.zeros_like(velocity)
        latest = np.searchsorted(moves, np.arange(len(velocity)), side="right") - 1
        return np.where((latest < 0)[:, None], 0.0, velocity[moves[np.maximum(latest, 0)]])

    @cached_property
    def segment_velocity(self) -> Floats:
        """Velocity (M, 3) [m/s] on the segment that begins at each knot: of an arc that along its chord; 0 without duration."""
        span, steps = np.diff(self.time)[:, None], np.diff(self.position, axis=0)
        velocity = np.divide(steps, span, out=np.zeros_like(steps), where=span > 0)
        return np.concatenate([velocity, self.final_velocity[None]])

    @cached_property
    def _segment_turn(self) -> Floats:
        """Rate (M,) [rad/s] at which the heading turns the short way to that of the next knot."""
        span, turn = np.diff(self.time), (np.diff(self.heading) + np.pi) % (2 * np.pi) - np.pi
        return np.append(np.divide(turn, span, out=np.zeros_like(turn), where=span > 0), 0.0)

    @cached_property
    def _first_heading(self) -> float:
        """Heading [rad] at the first knot, in [0, 2 pi)."""
        return float(wrap_bearing(self.heading[0]))

    def _straight(self, t: Floats) -> Pose:
        """Returns the state at each t (K,) [s] of a motion with one knot, which most bodies have."""
        elapsed = np.maximum(t - self.time[0], 0.0)[:, None]
        velocity = np.where(t[:, None] >= self.time[0], self.final_velocity, 0.0)
        heading = np.full(len(t), self._first_heading)
        return Pose(self.position[0] + elapsed * self.final_velocity, velocity, heading)


def move_along_arc(course: Floats, speed: Floats, rate: Floats, elapsed: Floats) -> tuple[Floats, Floats]:
    """Returns displacement (K, 3) [m] and velocity (K, 3) [m/s] at `elapsed` (K,) [s] after the start of arcs.

    course: (K,) at the start [rad]. speed: (K,) [m/s]. rate: (K,) of turn [rad/s], not 0.
    """
    now = course + rate * elapsed
    radius, up = speed / rate, np.zeros(len(now))
    displacement = np.stack([radius * (np.cos(course) - np.cos(now)), radius * (np.sin(now) - np.sin(course)), up], axis=-1)
    return displacement, np.stack([speed * np.sin(now), speed * np.cos(now), up], axis=-1)


def in_stream(motion: Motion, stream: Stream, keeps_heading: bool) -> Motion:
    """Returns a motion over ground whose heading allows for a stream: that through the water takes the place of the course.

    keeps_heading: it was given, and stays. A body that stands keeps the heading with which it came to rest.
    """
    if not any(stream) or keeps_heading or motion.turning:
        return motion
    angle = np.where(motion.curved, 0.0, crab_angle(motion.latest_velocity, stream))
    return replace(motion, heading=motion.heading + angle, stream=stream)


def segment_headings(position: Floats, heading_deg: float | None) -> Floats:
    """Returns the heading (M,) [rad] on the segment that begins at each knot of position (M, 3) [m]: the course of the segment.

    A segment without movement keeps the course before it, or the first course. heading_deg: constant heading, None for the
    course.
    """
    if heading_deg is not None:
        return np.full(len(position), math.radians(heading_deg))
    steps = np.diff(position[:, :2], axis=0)
    moving = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > 0.0)
    if moving.size == 0:
        return np.zeros(len(position))
    course = np.arctan2(steps[moving, 0], steps[moving, 1])
    latest = np.searchsorted(moving, np.arange(len(position)), side="right") - 1
    headings: Floats = course[np.maximum(latest, 0)]
    return headings
