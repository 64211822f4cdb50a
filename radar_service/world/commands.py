"""Commands to own ship and to bodies: what they may order, and all that a world has been given."""

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

from radar_service.numerics import KNOT, MAX_COORDINATE
from radar_service.radar import Radar
from radar_service.world.steered_motion import SteeringLimits

MAX_COMMANDS = 1_000_000  # to one world: five hours of poses at 50 Hz, or a day of 11 a second
MAX_SPOKE = 2**53  # beyond it a time has no exact number
MAX_BEARING = 360.0  # degrees either way, as in scenes
ROUNDING = 1e-9  # of a limit, which comes back from SI units


class CommandError(ValueError):
    """A command that is not possible. The text names the key, the value, the allowed range and the remedy."""


class UnknownBodyError(CommandError):
    """No body of the scene has this name."""


class NotSteerableError(CommandError):
    """The scene does not let commands steer this body."""


@dataclass(frozen=True)
class Command:
    """A command that acts from a time on. A value of None changes nothing.

    time: at which it acts [s].
    spoke: number of the first spoke that shows it, from the start: the first one not before that time.
    body: its name; None for own ship.
    course_deg: over the ground, clockwise from true north; reached by the shorter way at the highest turn rate allowed, or at
        turn_rate_deg_s, then straight on.
    speed_kn: over the ground, at once.
    turn_rate_deg_s: of the course, positive to starboard; without course_deg it goes on.
    heading_deg: of the bow, at once; from then on the angle between heading and course stays.
    position_m: east, north, at once; the height stays.
    present: whether a body is there at all; own ship always is.
    at_once: the course jumps to course_deg, and turn_rate_deg_s goes on from there.
    by: what sent it to a service, as "rest", "poses" or "nmea"; None in process. It changes nothing.
    """

    spoke: int
    time: float
    body: str | None
    course_deg: float | None = None
    speed_kn: float | None = None
    turn_rate_deg_s: float | None = None
    heading_deg: float | None = None
    position_m: tuple[float, float] | None = None
    present: bool | None = None
    at_once: bool | None = None
    by: str | None = None

    @property
    def values(self) -> dict[str, Any]:
        """The values that it gives, by key."""
        return {key: value for key in KEYS if (value := getattr(self, key)) is not None}

    @property
    def moves(self) -> bool:
        """Whether it begins another leg."""
        return bool(self.values.keys() - {"present", "at_once"})

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as JSON has it: spoke, time, body, the values that it gives, and what sent it where that is known."""
        by = {} if self.by is None else {"by": self.by}
        return {"spoke": self.spoke, "time": self.time, "body": self.body, **self.values, **by}


@dataclass(frozen=True)
class Steerable:
    """What commands may steer in a world.

    limits: of the commands, by the name of what is steerable; None is own ship.
    names: of all bodies.
    radar: whose spokes the commands act from.
    own_ship: name of the body that own ship is; None where it is none.
    """

    limits: Mapping[str | None, SteeringLimits]
    names: Collection[str]
    radar: Radar | None
    own_ship: str | None = None

    def command(self, spoke: int | None, body: str | None, values: Mapping[str, Any], time: float | None = None) -> Command:
        """Returns the command that acts from a spoke on, or at a time [s]. With both, they must agree. Raises CommandError."""
        checked = self.checked(body, values)
        assert self.radar  # else nothing is steerable
        if time is None or spoke is not None:
            _check_spoke(spoke)
        if time is None:
            assert spoke is not None  # _check_spoke
            return Command(spoke, self.radar.time_of_spokes(float(spoke)), body, **checked)
        return Command(_spoke_at(self.radar, time, spoke), time, body, **checked)

    def seen(self, command: Command, body: str | None) -> Command:
        """Returns a command to `body` as this radar shows it; it was made by another radar of the same world, or at another rate
        of rotation."""
        assert self.radar  # else nothing is steerable
        return replace(command, body=body, spoke=_spoke_at(self.radar, command.time, None))

    def checked(self, body: str | None, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the values of a command to `body` as `Command` has them. Raises CommandError."""
        limits = self.limits_of(body)
        given = {key: value for key, value in values.items() if value is not None}
        _check_keys(given)
        if not given.keys() - {"at_once"}:
            raise CommandError(f"a command without a value: give at least one of {', '.join(KEYS[:-1])}")
        if body is None and "present" in given:
            raise CommandError("present: own ship is always present; leave it out")
        result = {key: CHECKS[key](key, value, limits) for key, value in given.items()}
        if result.get("turn_rate_deg_s") == 0.0 and "course_deg" in result and not result.get("at_once"):
            raise CommandError(
                f"turn_rate_deg_s: 0 never reaches course_deg {result['course_deg']:g}; give another rate, or leave it out"
            )
        return result

    def name_of(self, body: str | None) -> str | None:
        """Returns the name of what a command steers; None where own ship is no body."""
        return self.own_ship if body is None else body

    def limits_of(self, body: str | None) -> SteeringLimits:
        """Returns the limits of commands to `body`. Raises UnknownBodyError and NotSteerableError."""
        if body is not None and body not in self.names:
            known = ", ".join(sorted(f'"{name}"' for name in self.limits if name is not None)[:5]) or "none"
            raise UnknownBodyError(f'body: the scene has no "{str(body)[:200]}"; bodies that may be steered: {known}')
        if body not in self.limits:
            who = "own ship" if body is None else f'body "{body}"'
            raise NotSteerableError(f"{who} is not steerable in this scene; add steerable = {{}} to its table in the scene")
        return self.limits[body]


class CommandLog:
    """All commands to a world in the order of their arrival. One thread writes; others may read.

    Another source of spokes of the same scene goes on from them.
    """

    def __init__(self, steerable: Steerable, commands: Iterable[Command] = ()) -> None:
        """steerable: what may be steered; commands: those of another source, which are known to be right."""
        self._steerable = steerable
        self._commands = list(commands)
        self._latest = {self._steerable.name_of(command.body): command for command in self._commands}

    def __len__(self) -> int:
        return len(self._commands)

    def __iter__(self) -> Iterator[Command]:
        return iter(self._commands)

    def since(self, count: int) -> Sequence[Command]:
        """Returns the commands that came after the first `count`."""
        return self._commands[count:]

    def first_unknown(self, count: int) -> float:
        """Returns the first spoke that the commands after the first `count` change; inf where there are none."""
        return min((command.spoke for command in self._commands[count:]), default=math.inf)

    def acting_at(self, spoke: int) -> int:
        """Returns how many commands act at a spoke, where they came in the order of their spokes."""
        return bisect_right(self._commands, spoke, key=attrgetter("spoke"))

    def command(self, spoke: int | None, body: str | None, values: Mapping[str, Any], time: float | None = None) -> Command:
        """Returns a command from a spoke on, or at a time [s], for `add`. Here it is checked, and nowhere later.

        Raises CommandError.
        """
        check_count(len(self._commands) + 1)
        return self._steerable.command(spoke, body, values, time)

    def add(self, command: Command) -> None:
        """Adds a command that was made for this world."""
        self._commands.append(command)
        self._latest[self._steerable.name_of(command.body)] = command

    def latest(self, body: str | None) -> Command | None:
        """Returns the command to a body that came last; None for own ship."""
        return self._latest.get(self._steerable.name_of(body))

    def latest_after(self, count: int) -> list[Command]:
        """Returns the last command to each body, of those that came after the first `count`. With 0 it looks at no other ones."""
        latest = (
            self._latest
            if count == 0
            else {self._steerable.name_of(command.body): command for command in self._commands[count:]}
        )
        return list(latest.values())


def check_count(count: int) -> None:
    """Raises CommandError where a world has not room for so many commands."""
    if count > MAX_COMMANDS:
        raise CommandError(f"a world takes {MAX_COMMANDS} commands, and has had as many; start the scene anew")


def _check_spoke(spoke: Any) -> None:
    if isinstance(spoke, bool) or not isinstance(spoke, int) or not 0 <= spoke <= MAX_SPOKE:
        raise CommandError(f"spoke: {str(spoke)[:100]} is not allowed; a whole number from 0 to {MAX_SPOKE}")


def _spoke_at(radar: Radar, time: float, spoke: int | None) -> int:
    """Returns the spoke of a command that acts at a time [s]. Raises CommandError where the spoke that is given is another
    one."""
    _number("time", time, 0.0, radar.time_of_spokes(float(MAX_SPOKE)))
    first = radar.first_spoke(time)
    if spoke not in (None, first):
        raise CommandError(f"time: {time:g} s is that of spoke {first}, not of spoke {spoke}; give one of both alone")
    return first


KEYS = tuple(name for name in Command.__dataclass_fields__ if name not in ("spoke", "time", "body", "by"))


def command_from(data: Mapping[str, Any]) -> Command:
    """Returns the command of plain data, whose values are still to be checked. Raises CommandError for an unknown key."""
    values = dict(data)
    spoke, time, body, by = (values.pop(key, None) for key in ("spoke", "time", "body", "by"))
    _check_keys(values)
    return Command(spoke, time, body, by=by, **values)  # a spoke and a time of any kind are checked later


def _check_keys(values: Mapping[str, Any]) -> None:
    for key in values:
        if key not in KEYS:
            raise CommandError(f"{str(key)[:100]}: not a key of a command; allowed are {', '.join(KEYS)}")


def _number(key: str, value: Any, low: float, high: float) -> float:
    """Returns a number within limits."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise CommandError(f"{key}: {str(value)[:100]} is not a number; give one from {low:g} to {high:g}")
    if not low - ROUNDING * abs(low) <= value <= high + ROUNDING * abs(high):
        raise CommandError(f"{key}: {value:g} is not allowed; {low:g} to {high:g}: give another value")
    return float(value)


def _bearing(key: str, value: Any, limits: SteeringLimits) -> float:
    return _number(key, value, -MAX_BEARING, MAX_BEARING)


def _speed(key: str, value: Any, limits: SteeringLimits) -> float:
    return _number(key, value, 0.0, limits.max_speed / KNOT)


def _turn_rate(key: str, value: Any, limits: SteeringLimits) -> float:
    highest = math.degrees(limits.max_turn_rate)
    return _number(key, value, -highest, highest)


def _position(key: str, value: Any, limits: SteeringLimits) -> tuple[float, float]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise CommandError(f"{key}: {str(value)[:100]} is not a position; give [east, north] in metres")
    east, north = (_number(f"{key}[{i}]", coordinate, -MAX_COORDINATE, MAX_COORDINATE) for i, coordinate in enumerate(value))
    return east, north


def _flag(key: str, value: Any, limits: SteeringLimits) -> bool:
    if not isinstance(value, bool):
        raise CommandError(f"{key}: {str(value)[:100]} is not allowed; true or false")
    return value


CHECKS: dict[str, Callable[[str, Any, SteeringLimits], Any]] = {
    "course_deg": _bearing,
    "speed_kn": _speed,
    "turn_rate_deg_s": _turn_rate,
    "heading_deg": _bearing,
    "position_m": _position,
    "present": _flag,
    "at_once": _flag,
}
