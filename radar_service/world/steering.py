"""The commands to one world: what may be steered, all commands by the times at which they act, and the motions they make."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from operator import attrgetter
from threading import Lock
from types import MappingProxyType
from typing import Any

import numpy as np

from radar_service.numerics import KNOT, Revision
from radar_service.world.commands import Command, check_count
from radar_service.world.motion import Motion
from radar_service.world.presence import Presence, SteeredPresence
from radar_service.world.scene import Scene
from radar_service.world.seaway import NO_STREAM, Stream
from radar_service.world.steered_motion import MotionSegment, SteeredMotion, SteeringLimits

_spoke, _time = attrgetter("spoke"), attrgetter("time")  # of a command


def with_motions(
    scene: Scene, motions: Mapping[str | None, Motion], presences: Mapping[str, Presence] = MappingProxyType({})
) -> Scene:
    """Returns a scene with other motions of some bodies, and other presences of the same ones, by name; None is own ship."""
    if not motions:
        return scene
    bodies = tuple(
        replace(body, motion=motions[body.name], presence=presences.get(body.name, body.presence))
        if body.name in motions
        else body
        for body in scene.world.bodies
    )
    own_ship = replace(scene.platform, motion=motions.get(scene.platform.body, scene.own_ship))
    return replace(scene.with_world(bodies=bodies), platform=own_ship, revision=Revision(), own_revision=Revision())


class Steering:
    """All commands to a world. They are sorted by time; of the same time, the later one acts after the earlier one.

    Two commanders may steer one body: the command that came last holds. `go_to` is called by the thread that computes while
    it computes nothing; all else may be called from any thread.

    steerable: what may be steered.
    scene: the given one, with motions of its own, which `go_to` changes. past: the same, as it was at each time.
    """

    def __init__(self, scene: Scene) -> None:
        self._motions = {name: replace(motion) for name, motion in scene.steered.items()}
        presences = {
            body.name: SteeredPresence.under(body.presence) for body in scene.world.bodies if body.name in self._motions
        }
        self.scene = with_motions(scene, self._motions, presences)
        past = {name: motion.past for name, motion in self._motions.items()}
        self.past = with_motions(scene, past, {name: presence.past for name, presence in presences.items()})
        self._presences: dict[str | None, SteeredPresence] = {name: presence for name, presence in presences.items()}
        self.steerable = scene.steerable
        self._commands: list[Command] = []  # by time
        self._taken = 0  # how many of them the motions have taken
        self._followed = 0  # how many of them the spokes that are computed now follow
        self._changed: set[str | None] = set()  # whose commands were taken or forgotten since `go_to`
        self._lock = Lock()

    @property
    def count(self) -> int:
        """Number of all commands."""
        return len(self._commands)

    @property
    def commands(self) -> tuple[Command, ...]:
        """All commands, those that act later among them."""
        with self._lock:
            return tuple(self._commands)

    @property
    def due(self) -> float:
        """The first spoke that the motions which `go_to` has chosen do not hold for; inf where they always do."""
        with self._lock:
            return self._commands[self._followed].spoke if self._followed < len(self._commands) else math.inf

    @property
    def followed(self) -> tuple[Command, ...]:
        """The commands that the motions of `scene` follow."""
        with self._lock:
            return tuple(self._commands[: self._followed])

    @contextmanager
    def unchanged(self) -> Iterator[None]:
        """Keeps commands away during a `with` block."""
        with self._lock:
            yield

    def add(
        self, spoke: int | None, body: str | None, values: Mapping[str, Any], reached: int = -1, time: float | None = None
    ) -> Command:
        """Adds a command that acts from a spoke on, or at a time [s]. reached: the next spoke; `past` takes all commands up to
        it at once.

        Raises CommandError.
        """
        command = self.steerable.command(spoke, self.steerable.name_of(body), values, time)
        self.take(command, reached)
        return command

    def take(self, command: Command, reached: int = -1) -> None:
        """Adds a command that was made for this world, as `add`. Raises CommandError where there are too many."""
        command = replace(command, body=self.steerable.name_of(command.body))
        with self._lock:
            check_count(len(self._commands) + 1)
            at = bisect_right(self._commands, command.time, key=_time)
            self._commands.insert(at, command)
            self._followed = min(self._followed, at)
            if at < self._taken:
                self._take(at)
            self._take(max(self._taken, bisect_right(self._commands, reached, key=_spoke)))

    def replay(self, commands: Iterable[Command]) -> None:
        """Replaces all commands by those of another run. Raises CommandError, and then nothing changes."""
        checked = [
            replace(
                self.steerable.command(command.spoke, self.steerable.name_of(command.body), command.values, command.time),
                by=command.by,
            )
            for command in commands
        ]
        with self._lock:
            check_count(len(checked))
            self._commands = sorted(checked, key=_time)
            self._taken, self._followed, self._changed = 0, 0, set(self._motions)
            for motion in self._steered():
                motion.forget()
            self._change_past()

    def follow(self, commands: Sequence[Command]) -> None:
        """Lets the motions of `scene` follow all commands that those of a copy of it follow, and no other one."""
        with self._lock:
            self._take(min(same_at_first(commands, self._commands), self._taken))
            self._commands = list(commands)
        self.go_to(math.inf)

    def go_to(self, spoke: float) -> None:
        """Lets the motions of `scene` follow all commands up to this spoke, and no later one."""
        with self._lock:
            count = bisect_right(self._commands, spoke, key=_spoke)
            self._take(count)
            changed, self._changed, self._followed = self._changed, set(), count
            if changed:
                for motion in self._steered():
                    motion.follow()
                self.scene.revision.change()
            if self.scene.platform.body in changed:
                self.scene.own_revision.change()

    def _take(self, count: int) -> None:
        """Lets the motions take the first `count` commands, and no other ones."""
        if count != self._taken:
            self._change_past()
        if count < self._taken:
            self._taken = 0
            self._changed |= set(self._motions)
            for motion in self._steered():
                motion.forget()
        for command in self._commands[self._taken : count]:
            motion = self._motions[command.body]
            self._changed.add(command.body)
            if command.moves:
                motion.steer(begun_segment(command, motion.segment_at(command.time), motion.limits, motion.water))
            if command.present is not None:
                self._presences[command.body].steer(command.time, command.present)
        self._taken = count

    def _change_past(self) -> None:
        if self._motions:
            self.past.revision.change()
            self.past.own_revision.change()

    def _steered(self) -> list[SteeredMotion | SteeredPresence]:
        return [*self._motions.values(), *self._presences.values()]


def same_at_first(commands: Sequence[Command], others: Sequence[Command]) -> int:
    """How many commands two sequences begin with alike."""
    pairs = enumerate(zip(commands, others, strict=False))
    shorter = min(len(commands), len(others))
    return next((at for at, (each, other) in pairs if each is not other and each != other), shorter)


def begun_segment(
    command: Command, before: MotionSegment, limits: SteeringLimits, stream: Stream = NO_STREAM
) -> MotionSegment:
    """Returns the segment that begins with a command. before: what is left of the segment until then. stream: of the water."""
    segment = before
    if command.position_m is not None:
        segment = segment._replace(position=np.array([*command.position_m, before.position[2]]))
    if command.speed_kn is not None:
        segment = segment._replace(speed=command.speed_kn * KNOT, stood=segment.crab(stream))
    if command.turn_rate_deg_s is not None:
        segment = segment._replace(turn_rate=math.radians(command.turn_rate_deg_s), turn_time=math.inf)
    if command.course_deg is not None:
        segment = _on_course(command, segment, math.radians(command.course_deg), limits)
    if command.heading_deg is not None:
        segment = segment.with_heading(math.radians(command.heading_deg), stream)
    return segment.after(before)


def _on_course(command: Command, segment: MotionSegment, course: float, limits: SteeringLimits) -> MotionSegment:
    turn = math.remainder(course - segment.course, 2.0 * math.pi)
    if command.at_once:
        rate = 0.0 if command.turn_rate_deg_s is None else segment.turn_rate
        return segment._replace(course=course, turn_rate=rate, turn_time=math.inf)
    if turn == 0.0:
        return segment._replace(turn_rate=0.0, turn_time=math.inf)
    if command.turn_rate_deg_s is None:
        return segment._replace(
            turn_rate=math.copysign(limits.max_turn_rate, turn), turn_time=abs(turn) / limits.max_turn_rate
        )
    way = turn % math.copysign(2.0 * math.pi, segment.turn_rate)  # round by the side to which it turns
    return segment._replace(turn_time=way / segment.turn_rate)
