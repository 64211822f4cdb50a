"""The water: the tidal stream, the waves of a seaway, and how a ship moves in them.

A stream is the velocity (2,) of the water over ground, east and north [m/s]. Velocity through the water is that over ground less
the stream. Waves are linear and long-crested each, on deep water; their sum is the elevation of the sea. They go with the stream.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, Self

import numpy as np

from radar_service.numerics import GRAVITY, Floats, map_from_deck, wrap_bearing

Stream = tuple[float, float]
NO_STREAM: Stream = (0.0, 0.0)


def crab_angle(velocity: Floats, stream: Stream) -> Floats:
    """Returns course through the water minus course over ground (...) [rad, -pi to pi] at velocities (..., 2 or more) [m/s].

    It is 0 for what stands over ground, and for what drifts with the stream: these have one course alone.
    """
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    ahead = east * velocity[..., 0] + north * velocity[..., 1]
    aside = east * velocity[..., 1] - north * velocity[..., 0]  # + 0.0 below: the angle of (-0.0, 0.0) would be pi
    return np.asarray(np.arctan2(aside + 0.0, ahead + 0.0))


def turn_factor(velocity: Floats, stream: Stream) -> Floats:
    """Returns how many times as fast (...) the course through the water turns as that over ground, at a constant speed over
    ground: v (v - c) / |v - c|^2, the derivative of the course of v - c; 1 where `crab_angle` is 0 by definition."""
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    square = east**2 + north**2
    ahead = east * velocity[..., 0] + north * velocity[..., 1]
    defined = (square > 0.0) & (np.hypot(velocity[..., 0], velocity[..., 1]) > 0.0)
    return np.divide(ahead, square, out=np.ones_like(square), where=defined)


def through_water(velocity: Floats, heading: Floats, stream: Stream) -> tuple[Floats, Floats]:
    """Returns course (...) [rad, 0 to 2 pi) and speed (...) [m/s] through the water at velocities (..., 2 or more) [m/s].

    heading: (...) [rad], which is the course of what does not move through the water.
    """
    east, north = velocity[..., 0] - stream[0], velocity[..., 1] - stream[1]
    speed = np.hypot(east, north)
    return wrap_bearing(np.where(speed > 0.0, np.arctan2(east, north), heading)), speed


MAX_SEA_STATE = 9  # 10.1 m
MIN_WIND_STATE = 0.5  # ripples below have its wind, 1.8 m/s
CALM, RISE, POWER = 0.04, 0.1, 2.1  # of the height by sea state
# Most probable period of the spectrum's peak [s] by significant wave height [m] on the open North Atlantic: Bales 1983 and NATO
# STANAG 4194. Below 0.875 m they have none, and the one of that height here.
PERIOD_HEIGHT = (0.875, 1.875, 3.25, 5.0, 7.5, 11.5, 14.0)
PEAK_PERIOD = (7.5, 8.8, 9.7, 12.4, 15.0, 16.4, 20.0)


def significant_wave_height(sea_state: float) -> float:
    """Returns H_1/3 [m] of a sea state of 0 to 9, fractions too: 0.04 + 0.1 s^2.1 m, and none at 0; else ValueError.

    The states of the data behind sigma0: Gregers-Hansen and Mital, NRL/MR/5310-12-9346 (2012), p. 3. Those from 2 to 6 lie in
    the bands of the Douglas scale (WMO code table 3700).
    """
    if not 0.0 <= sea_state <= MAX_SEA_STATE:
        raise ValueError(
            f"sea_state: {sea_state:g} is not allowed; 0 to 9, where 3 has waves of 1.04 m; give the nearest of these"
        )
    return CALM + RISE * sea_state**POWER if sea_state else 0.0


def sea_state_of(height: float) -> float:
    """Returns the sea state whose significant wave height this is [m], 0 to 0.04 m."""
    return float(max((height - CALM) / RISE, 0.0) ** (1.0 / POWER))


def wind_speed(sea_state: float) -> float:
    """Returns the wind [m/s] that raises a sea, 3.16 s^0.8 (GIT: Horst, Dyer and Tuley 1978); ValueError without one."""
    if not 0.0 < sea_state <= MAX_SEA_STATE:
        raise ValueError(f"sea_state: {sea_state:g} has no wind; give one above 0 and up to 9")
    return float(3.16 * max(sea_state, MIN_WIND_STATE) ** 0.8)


@dataclass(frozen=True)
class Seaway:
    """What a seaway is drawn from.

    height: significant wave height H_1/3 [m].
    period: of the spectrum's peak [s].
    towards: mean direction into which waves travel, clockwise from north [rad].
    spread: s of the distribution of directions, cos^(2 s) within a quarter turn of the mean one.
    seed: of frequencies, directions and phases, and of lists and trims.
    list_rms, trim_rms: standard deviation of the lists and trims that are drawn for ships [rad].
    """

    height: float
    period: float
    towards: float
    spread: float
    seed: int
    list_rms: float
    trim_rms: float


@dataclass(frozen=True, eq=False)
class Waves:
    """Regular waves (N,): amplitude x cos(wavenumber x position - over_ground x time + phase).

    amplitude: (N,) [m]. frequency: (N,) in the water [rad/s]. wavenumber: (N, 2) east and north [rad/m].
    over_ground: (N,) frequency at a fixed place, with the stream [rad/s]. phase: (N,) [rad].
    """

    amplitude: Floats
    frequency: Floats
    wavenumber: Floats
    over_ground: Floats
    phase: Floats

    def phases(self, position: Floats, time: Floats) -> Floats:
        """Returns the phases (K, N) [rad] at positions (K, 2 or more) [m] and times (K,) [s]."""
        east, north = self.wavenumber.T
        place = position[:, :1] * east + position[:, 1:2] * north
        return np.asarray(place - time[:, None] * self.over_ground + self.phase)

    def elevation(self, position: Floats, time: Floats) -> Floats:
        """Returns the height (K,) [m] of the sea above its mean at positions (K, 2 or more) [m] and times (K,) [s]."""
        return np.asarray((self.amplitude * np.cos(self.phases(position, time))).sum(axis=1))


WAVES = 64  # regular waves; their bands are 2.9 % wide, a third of the resonance of a roll with 5 % of critical damping
LOWEST, HIGHEST = 0.55, 3.5  # frequencies over that of the peak: 1.2e-6 of the energy lies below, 0.8 % above
DIRECTIONS = 4001  # points of the table of directions: its steps are 0.045 degrees


def drawn_waves(seaway: Seaway, stream: Stream = NO_STREAM) -> Waves:
    """Returns the waves of a seaway. The variance of their sum over time is (height / 4)^2.

    A wave has the energy of its band of the spectrum, a frequency within the band, and a direction. Directions are spread
    evenly over their distribution, in random order. stream: of the water, east and north [m/s].
    """
    from radar_service.numerics import SEAWAY, generator  # here: they need scipy, and most programs only the records

    rng = generator(seaway.seed, SEAWAY)
    peak = 2.0 * np.pi / seaway.period
    edges = peak * np.geomspace(LOWEST, HIGHEST, WAVES + 1)
    energy = np.diff(energy_below(edges, peak))
    frequency = edges[:-1] * (edges[1:] / edges[:-1]) ** rng.random(WAVES)
    share = (np.argsort(rng.random(WAVES)) + rng.random(WAVES)) / WAVES
    direction = seaway.towards + _directions(share, seaway.spread)
    wavenumber = (frequency**2 / GRAVITY)[:, None] * np.stack([np.sin(direction), np.cos(direction)], axis=1)
    return Waves(
        amplitude=seaway.height / 4.0 * np.sqrt(2.0 * energy / energy.sum()),
        frequency=frequency,
        wavenumber=wavenumber,
        over_ground=frequency + wavenumber @ np.array(stream),
        phase=2.0 * np.pi * rng.random(WAVES),
    )


def energy_below(frequency: Floats, peak: float) -> Floats:
    """Returns the share (...) of a wave spectrum's energy below frequencies (...) [rad/s]; peak: of the spectrum [rad/s].

    S(w) = 5/16 H^2 wp^4 w^-5 exp(-5/4 (wp / w)^4), whose integral is H^2 / 16 exp(-5/4 (wp / w)^4): Bretschneider 1959, the
    two-parameter spectrum of the ITTC 1978; of a fully developed sea it is that of Pierson and Moskowitz 1964.
    """
    return np.asarray(np.exp(-1.25 * (peak / frequency) ** 4))


def _directions(share: Floats, spread: float) -> Floats:
    """Directions (N,) off the mean one [rad] below which these shares (N,) of the energy go."""
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, DIRECTIONS)
    density = np.cos(angle) ** (2.0 * spread)
    below = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    return np.interp(share, below / below[-1], angle)


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


class SwayLaw(ABC):
    """Roll, pitch, yaw and heave about a course. Maxima hold at all times; one swing in a million exceeds `likely` ones."""

    @property
    @abstractmethod
    def max_values(self) -> Floats:
        """The largest roll, pitch, yaw and heave (4,) [rad, m] to either side."""

    @property
    @abstractmethod
    def max_rates(self) -> Floats:
        """The highest rates (4,) [rad/s, m/s] of roll, pitch, yaw and heave."""

    @property
    def likely_values(self) -> Floats:
        """What roll, pitch, yaw and heave (4,) [rad, m] hardly ever leave."""
        return self.max_values

    @property
    def likely_rates(self) -> Floats:
        """What their rates (4,) [rad/s, m/s] hardly ever leave."""
        return self.max_rates

    @property
    @abstractmethod
    def shortest_period(self) -> float:
        """The shortest period [s] of roll, pitch, yaw and heave."""

    @property
    @abstractmethod
    def text(self) -> str:
        """What `check` says of it, with a comma before each item."""

    @property
    @abstractmethod
    def tilts(self) -> bool:
        """Whether the ship rolls or pitches, or lies over."""

    @property
    def max_tilt(self) -> float:
        """An angle [rad] that its mast never leaves the vertical by."""
        return float(self.max_values[:2].sum())

    @property
    def max_heave(self) -> float:
        """The largest heave [m]."""
        return float(self.max_values[3])

    @abstractmethod
    def state(self, time: Floats, path: Path) -> SwayState:
        """Returns the sway at each time (K,) [s] of a motion along a path."""

    @abstractmethod
    def rates_about(self, time: Floats, path: Path) -> Floats:
        """Returns rates (K, 4) [rad/s, m/s] about each time (K,) [s]: roots of the squares of the rate and of REST of what the
        swing reaches."""

    def excess(self, time: float) -> tuple[float, float]:
        """Returns the eased velocity minus the true one, east and north [m/s], at `time` [s]; 0 where sway ignores velocity."""
        return 0.0, 0.0

    def eased(self, excess: tuple[float, float], since: float) -> Self:
        """Returns the law along another path, with this `excess` [m/s] at time `since` [s]."""
        return self


@dataclass(frozen=True)
class Sway(SwayLaw):
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


def lean_text(lean: tuple[float, float]) -> str:
    """Returns what `check` says of list and trim [rad], with a comma before each."""
    leans = zip(("listing", "trimmed"), lean, strict=True)
    return "".join(f", {verb} {math.degrees(angle):.3g} degrees" for verb, angle in leans if angle)


def with_lean(values: Floats, lean: tuple[float, float]) -> Floats:
    """Returns maxima (4,) of roll, pitch, yaw and heave with a list and a trim [rad]."""
    return values + np.abs([*lean, 0.0, 0.0]) if any(lean) else values
