"""What a radar of another maker is to its readers: how it is found, what it reports and takes, and its spokes. No I/O."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from radar_service.display.video import Bytes

STANDBY, SPINNING_UP, TRANSMIT = 0, 1, 2  # states of the scanner
LEAST_RANGE = 10.0  # m


class IgnoredError(ValueError):
    """A command that is not followed. The text is a word for the reason: form, unknown or value."""


class Spoke(NamedTuple):
    """number: clockwise from the bow; metres: where the last sample ends; heading: true [rad], NaN while it is lost."""

    number: int
    metres: int
    heading: float
    samples: Bytes


class SampleForm(NamedTuple):
    """most: samples in a spoke; fills: whether it is always that; levels: of samples, by the byte of our video."""

    most: int
    fills: bool
    levels: Bytes


@dataclass(frozen=True)
class Setting:
    """What is reported. state: of the scanner; range: shown [m]; range_max: of the scene [m]; level: of auto gain, 0 or 1;
    controls: ours, as REST gives them."""

    state: int = STANDBY
    range: int = 0
    range_max: float = 0.0
    level: int = 0
    controls: Mapping[str, Any] | None = None


class Frames(Protocol):
    """Makes datagrams of the spokes of one radar."""

    def of(self, spokes: Sequence[Spoke]) -> list[bytes]:
        """Returns the datagrams that are complete with these spokes."""

    def clear(self) -> None:
        """Forgets spokes that wait for others: the next one does not follow them."""
        return


@dataclass(frozen=True)
class Dialect:
    """The datagrams of a maker. Destinations and commands are addresses in numbers, and ports.

    name: of the port, whose option is the same; radar: address of a real one, for captures.
    spokes: in a revolution; samples: of a spoke; frames: makes datagrams of spokes.
    destinations: of what it is found by, of reports and of spokes; commands: of readers, "" is the radar itself.
    found_by: returns the datagram by which readers find a radar, of a unique number, how many came before, and its address.
    reports: returns all reports, in the order that readers need.
    changed_by: returns our controls that a command changes; beside these `level` of auto gain, and `sought` where a reader looks
    for radars. Raises IgnoredError.
    """

    name: str
    radar: str
    spokes: int
    samples: SampleForm
    frames: Callable[[], Frames]
    destinations: Sequence[tuple[str, int]]
    commands: Sequence[tuple[str, int]]
    found_by: Callable[[int, int, str], bytes]
    reports: Callable[[Setting], list[bytes]]
    changed_by: Callable[[bytes, Setting], dict[str, Any]]


Change = Callable[[int, Setting], dict[str, Any]]
Commands = Mapping[tuple[int, int], Change]  # by number and bytes of the value


def follow(commands: Commands, number: int, value: bytes, of: Setting) -> dict[str, Any]:
    """Returns what a command of a table changes, whose value is little-endian. Raises IgnoredError."""
    change = commands.get((number, len(value)))
    if change is None:
        raise IgnoredError("form" if any(number == known for known, _ in commands) else "unknown")
    return change(int.from_bytes(value, "little"), of)


def one_of(changes: Mapping[int, dict[str, Any]]) -> Change:
    """Returns a change for each value that a command may have."""

    def change(value: int, of: Setting) -> dict[str, Any]:
        if value not in changes:
            raise IgnoredError("value")
        return dict(changes[value])

    return change


def percent(name: str, full: float, **also: bool) -> Change:
    """Returns a change of a number from 0 to 100. full: the value of 100; also: controls that it sets besides."""

    def change(value: int, of: Setting) -> dict[str, Any]:
        if value > full:
            raise IgnoredError("value")
        return {name: 100.0 * value / full, **also}

    return change


def ranged(metres: float, of: Setting) -> dict[str, Any]:
    """Returns the change to a range, within those of the scene."""
    return {"range_m": min(max(metres, LEAST_RANGE), of.range_max)}


def levels(weakest: int, strongest: int) -> Bytes:
    """Returns the level of each byte of our video: 0 for 0, the others evenly from the weakest to the strongest."""
    return np.append(0, np.rint(weakest + np.arange(255) * ((strongest - weakest) / 254))).astype(np.uint8)
