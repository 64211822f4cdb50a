"""How a ship moves in a seaway: roll, pitch, yaw and heave, by sines of its own or by a law that follows the waves."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, Self

import numpy as np

from radar_service.numerics import Floats, map_from_deck

STEP = 1e-20  # s of the complex step: its square is nothing beside 1, so that the derivative is exact to rounding
REST = 0.5  # of the rate that a swing reaches: nodes of metal err by up to 0.013 (24 drawn boxes, 25 degrees/s), without by 0.036


class SwayState(NamedTuple):
    """Sway at K times.

    values: (K, 4) roll (starboard side down), pitch (bow up), yaw (to starboard) [rad], heave (up) [m].
    rates: (K, 4) their derivatives [rad/s, m/s].
    """

    values: Floats
    rates: Floats

    def rotation(self, heading: Floats) -> Floats:
        """Returns matrices (K, 3, 3) map_from_body; heading: (K,) with yaw [rad]."""
        return map_from_deck(heading, self.values[:, 0], self.values[:, 1])

    def rotation_rate(self, heading: Floats, turn_rate: Floats) -> Floats:
        """Returns how the matrices (K, 3, 3) of `rotation` change [1/s]; turn_rate: (K,) of the heading with yaw [rad/s].

        By the complex step (Squire and Trapp, SIAM Review 40, 1998).
        """
        angles, rates = (heading, *self.values[:, :2].T), (turn_rate, *self.rates[:, :2].T)
        ahead = (angle + 1j * STEP * rate for angle, rate in zip(angles, rates, strict=True))
        return np.asarray(map_from_deck(*ahead).imag / STEP)


class UprightMotion(NamedTuple):
    """A motion without its sway at K times.

    position: (K, 3) [m]. velocity: (K, 3) [m/s]. heading: (K,) [rad].
    turn_rate, course_rate: (K,) at which heading and course turn to starboard [rad/s].
    """

    position: Floats
    velocity: Floats
    heading: Floats
    turn_rate: Floats
    course_rate: Floats


class Path(Protocol):
    """A motion that a law of sway may follow."""

    def upright(self, time: Floats) -> UprightMotion:
        """Returns the motion without its sway at each time (K,) [s]."""


class SwayLaw(Protocol):
    """Roll, pitch, yaw and heave about a course. Maxima hold at all times; one swing in a million exceeds `likely` ones."""

    @property
    def max_values(self) -> Floats:
        """The largest roll, pitch, yaw and heave (4,) [rad, m] to either side."""

    @property
    def max_rates(self) -> Floats:
        """The highest rates (4,) [rad/s, m/s] of roll, pitch, yaw and heave."""

    @property
    def likely_values(self) -> Floats:
        """What roll, pitch, yaw and heave (4,) [rad, m] hardly ever leave."""

    @property
    def likely_rates(self) -> Floats:
        """What their rates (4,) [rad/s, m/s] hardly ever leave."""

    @property
    def shortest_period(self) -> float:
        """The shortest period [s] of roll, pitch, yaw and heave."""

    @property
    def text(self) -> str:
        """What `check` says of it, with a comma before each item."""

    @property
    def tilts(self) -> bool:
        """Whether the ship rolls or pitches, or lies over."""

    @property
    def max_tilt(self) -> float:
        """An angle [rad] that its mast never leaves the vertical by."""

    @property
    def max_heave(self) -> float:
        """The largest heave [m]."""

    def state(self, time: Floats, path: Path) -> SwayState:
        """Returns the sway at each time (K,) [s] of a motion along a path."""

    def rates_about(self, time: Floats, path: Path) -> Floats:
        """Returns rates (K, 4) [rad/s, m/s] about each time (K,) [s]: roots of the squares of the rate and of REST of what the
        swing reaches."""

    def excess(self, time: float) -> tuple[float, float]:
        """Returns the eased velocity minus the true one, east and north [m/s], at `time` [s]."""

    def eased(self, excess: tuple[float, float], since: float) -> Self:
        """Returns the law along another path, with this `excess` [m/s] at time `since` [s]."""


@dataclass(frozen=True)
class Sway:
    """Roll, pitch, yaw and heave: amplitude x sin(2 pi t / period + phase), about the origin of the ship's own frame.

    amplitude: (4,) of roll (starboard side down), pitch (bow up) and yaw (to starboard) [rad], and of heave (up) [m].
    period: (4,) [s]. phase: (4,) [rad].
    lean: list (to starboard) and trim (by the stern) that are added to roll and pitch [rad].
    """

    amplitude: Floats
    period: Floats
    phase: Floats = field(default_factory=lambda: np.zeros(4))
    lean: tuple[float, float] = field(default=(0.0, 0.0), metadata={"added": 1})  # see truth.truth_file.scene_hash

    def __post_init__(self) -> None:
        assert self.amplitude.shape == self.period.shape == self.phase.shape == (4,)

    @property
    def max_values(self) -> Floats:
        """The largest roll, pitch, yaw and heave (4,) [rad, m] to either side."""
        return with_lean(self.amplitude, self.lean)

    @property
    def max_rates(self) -> Floats:
        """The highest rates (4,) [rad/s, m/s] of roll, pitch, yaw and heave."""
        return self.amplitude * 2.0 * np.pi / self.period

    @property
    def likely_values(self) -> Floats:
        """The largest values: each swing reaches them."""
        return self.max_values

    @property
    def likely_rates(self) -> Floats:
        """The highest rates: each swing reaches them."""
        return self.max_rates

    @property
    def shortest_period(self) -> float:
        """The shortest period [s] of roll, pitch, yaw and heave, also of those with amplitude 0."""
        return float(self.period.min())

    @property
    def text(self) -> str:
        """What `check` says of it, with a comma before each item."""
        sizes = [*(f"{math.degrees(angle):g} degrees" for angle in self.amplitude[:3]), f"{self.max_heave:g} m"]
        swings = zip(("rolling", "pitching", "yawing", "heaving"), sizes, self.amplitude, self.period, strict=True)
        swinging = "".join(f", {verb} {size} in {period:g} s" for verb, size, amplitude, period in swings if amplitude)
        return swinging + lean_text(self.lean)

    @property
    def tilts(self) -> bool:
        """Whether the ship rolls or pitches, or lies over."""
        return bool(self.amplitude[:2].any()) or any(self.lean)

    @property
    def max_tilt(self) -> float:
        """An angle [rad] that its mast never leaves the vertical by."""
        return float(self.max_values[:2].sum())

    @property
    def max_heave(self) -> float:
        """The amplitude of heave [m]."""
        return float(self.amplitude[3])

    def state(self, time: Floats, path: Path) -> SwayState:
        """Returns the sway at each time (K,) [s]; it follows no path."""
        frequency = 2.0 * np.pi / self.period
        angle = frequency * time[:, None] + self.phase
        values = self.amplitude * np.sin(angle)
        if any(self.lean):
            values[:, :2] += self.lean
        return SwayState(values, self.amplitude * frequency * np.cos(angle))

    def rates_about(self, time: Floats, path: Path) -> Floats:
        """Returns rates (K, 4) [rad/s, m/s] about each time (K,) [s], as a `SwayLaw`."""
        return np.asarray(np.hypot(self.state(time, path).rates, REST * self.max_rates))

    def excess(self, time: float) -> tuple[float, float]:
        """Returns 0: sines do not depend on the velocity."""
        return 0.0, 0.0

    def eased(self, excess: tuple[float, float], since: float) -> Self:
        """Returns the same law."""
        return self


def lean_text(lean: tuple[float, float]) -> str:
    """Returns what `check` says of list and trim [rad], with a comma before each."""
    leans = zip(("listing", "trimmed"), lean, strict=True)
    return "".join(f", {verb} {math.degrees(angle):.3g} degrees" for verb, angle in leans if angle)


def with_lean(values: Floats, lean: tuple[float, float]) -> Floats:
    """Returns maxima (4,) of roll, pitch, yaw and heave with a list and a trim [rad]."""
    return values + np.abs([*lean, 0.0, 0.0]) if any(lean) else values
