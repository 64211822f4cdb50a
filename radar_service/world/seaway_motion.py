"""The sway of a ship in a seaway: the sum of the responses of its hull to the waves, exact at any time.

The phase of each wave is that at the ship's position, so all ships have one sea, and the encounter frequency is exact through
turns and changes of speed. Responses are those of a steady course at the heading of the instant, and at an eased velocity,
which follows the true one with the time constant EASING. So sway is continuous where speed jumps; where a heading jumps, sway
jumps too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics import GRAVITY, Complexes, Floats, ResultCache
from radar_service.world.motion import Motion
from radar_service.world.seaway import (
    NO_STREAM,
    REST,
    Path,
    Stream,
    SwayLaw,
    SwayState,
    UprightMotion,
    Waves,
    lean_text,
    with_lean,
)

MAX_FROUDE = 0.4  # of the responses; a faster, planing craft has those of this one
SMALLEST = 1e-12  # below it a phase across the hull, or an encounter frequency over the wave's, counts as so much
SMALL_PHASE = 0.1  # rad: below it a series of three terms errs by 7e-11, and the closed form loses digits


@dataclass(frozen=True)
class HullForm:
    """What the motions of a ship depend on.

    length, breadth, draught: of the hull in the water [m].
    block: displaced volume over length x breadth x draught.
    waterplane: area of the waterplane over length x breadth.
    roll_period: natural period of roll [s].
    roll_damping: over critical damping.
    middle: starboard and forward [m] of the ship's frame, about which it moves.
    """

    length: float
    breadth: float
    draught: float
    block: float
    waterplane: float
    roll_period: float
    roll_damping: float
    middle: tuple[float, float] = (0.0, 0.0)

    @property
    def max_speed(self) -> float:
        """The speed [m/s] at which MAX_FROUDE is reached."""
        return float(MAX_FROUDE * np.sqrt(GRAVITY * self.length))


# Heave and pitch are those of Jensen, Mansour and Olsen, "Estimation of ship motions using closed-form expressions", Ocean
# Engineering 31 (2004) 61-85: a box with the hull's length, draught and displacement. Roll answers to the mean slope of the
# sea across the hull. Their roll moment, from the damping by Haskind's relation, goes to 0 in long waves, where a boat has
# the slope of the sea: in beam seas of sea states 3 and 5 it gives 0.4 and 0.3 of this roll at 75 m (0.9 and 4.2 degrees
# rms), and less at 12 m.
class Response(NamedTuple):
    """Complex amplitudes (..., N) over that of each wave, time factor exp(-i w t): roll, pitch [rad/m] and heave [m/m].

    The wave has phase 0 at the middle of the hull.
    """

    roll: Complexes
    pitch: Complexes
    heave: Complexes


def response(form: HullForm, frequency: Floats, along: Floats, aside: Floats, encounter: Floats) -> Response:
    """Returns the response of a hull to waves.

    frequency: (N,) of the waves in the water [rad/s]. along, aside: (..., N) components of their wavenumber forward and to
    starboard [rad/m]. encounter: (..., N) frequency at which the hull meets them [rad/s], below 0 where it overtakes them.
    """
    k, draught = frequency**2 / GRAVITY, form.draught
    breadth = form.block * form.breadth  # of the box: of the same displacement
    met = encounter**2 / GRAVITY  # k alpha^2
    wave_made = 2.0 * np.sin(met * breadth / 2.0) * np.exp(-met * draught)  # their A
    damping = wave_made**2 / np.maximum(met * breadth, SMALLEST)
    ratio = np.maximum(np.abs(encounter) / frequency, SMALLEST)  # |alpha|
    smith = np.exp(-k * draught)
    force = smith * np.hypot(1.0 - k * draught, damping / ratio)  # their kappa f
    resonance = 1.0 - 2.0 * met * draught - 1j * np.sign(encounter) * damping
    ends, sides = along * form.length / 2.0, aside * form.waterplane * form.breadth / 2.0  # half the phase across the hull
    return Response(
        roll=-1j * aside * smith * np.sinc(ends / np.pi) * _mean_slope(sides) / _rolling(form, encounter),
        pitch=1j * along * force * _mean_slope(ends) / resonance,
        heave=force * np.sinc(ends / np.pi) / resonance,
    )


def _mean_slope(half_phase: Floats) -> Floats:
    """The least-squares slope of a wave over a line on which its phase goes from -x to x, over the largest slope.

    3 (sin x - x cos x) / x^3: their G is the wavenumber along the hull times it.
    """
    x = np.abs(half_phase)
    large = np.maximum(x, SMALL_PHASE)
    closed = 3.0 * (np.sin(large) - large * np.cos(large)) / large**3
    return np.where(x < SMALL_PHASE, 1.0 - x**2 / 10.0 + x**4 / 280.0, closed)


def _rolling(form: HullForm, encounter: Floats) -> Complexes:
    """What a linear oscillator divides the slope of the sea by."""
    ratio = encounter * form.roll_period / (2.0 * np.pi)
    return np.asarray(1.0 - ratio**2 - 2j * form.roll_damping * ratio)


EASING = 10.0  # s: a roll of 10 s with 15 % of critical damping decays so fast
LIKELY = 5.26  # standard deviations that one swing in a million leaves: exp(-x^2 / 2), Rayleigh
HEADINGS, SPEEDS = 48, 6  # of a ship that turns or changes speed, for the bounds
MARGIN = 1.2  # of bounds over what these headings and speeds have: those between have up to 1.17 of it, with 2 % of damping
COURSES = 4  # whose amplitudes are kept: those of threads that are apart
STEP = 1e-6  # s over which responses are differentiated: they change in seconds, so that it errs by 1e-6 of their change


class Bounds(NamedTuple):
    """What roll, pitch, yaw and heave (4,) reach: sums of amplitudes, and standard deviations, of values and of rates."""

    values: Floats
    rates: Floats
    deviation: Floats
    rate_deviation: Floats


@dataclass(frozen=True)
class Easing:
    """Eased velocity, to which a ship responds, minus its own velocity: given at each knot, and decaying after it.

    time: (M,) of the knots [s]. excess: (M, 2) east and north there [m/s]. period: of a closed track [s], or None.
    before: (2,) of a ship that rests before the first knot, as just after it; None: the excess there.
    """

    time: Floats = field(default_factory=lambda: np.zeros(1))
    excess: Floats = field(default_factory=lambda: np.zeros((1, 2)))
    period: float | None = None
    before: Floats | None = None

    @cached_property
    def _at_knots(self) -> bool:
        """Whether the velocities differ at a knot."""
        return bool(self.excess.any())

    def vanishes(self, time: Floats) -> bool:
        """Returns whether the ship responds to its own velocity at each time (K,) [s]."""
        return not self._at_knots and (self.before is None or bool((self._since(time) >= self.time[0]).all()))

    def at(self, time: Floats) -> Floats:
        """Returns the excess (K, 2) [m/s] at each time (K,) [s]."""
        since = self._since(time)
        knot = np.maximum(np.searchsorted(self.time, since, side="right") - 1, 0)
        elapsed = np.maximum(since - self.time[knot], 0.0)
        excess = self.excess[knot] * np.exp(-elapsed / EASING)[:, None]
        if self.before is not None:
            excess[since < self.time[0]] = self.before
        return np.asarray(excess)

    def _since(self, time: Floats) -> Floats:
        return time if self.period is None else time % self.period


def easing_of(motion: Motion) -> Easing:
    """Returns the easing of a motion, whose velocity jumps at its knots; it rests before the first one if that is after 0."""
    begin, end = motion.knot_velocities()
    if motion.period is not None:
        begin[-1] = begin[0]  # the next lap begins
    decay = np.exp(-np.diff(motion.time) / EASING)
    jump = end[:-1] - begin[1:]
    first = -begin[0] if motion.time[0] > 0.0 else np.zeros(2)
    excess = _followed(first, decay, jump)
    if motion.period is not None:  # of a lap among many: as it ends, so it begins
        lap, before = float(np.prod(decay)), _followed(np.zeros(2), decay, jump)[-1]
        excess = _followed(before / (1.0 - lap), decay, jump)
    rested = begin[0] + excess[0]
    return Easing(motion.time, excess, motion.period, rested if rested.any() else None)


def _followed(first: Floats, decay: Floats, jump: Floats) -> Floats:
    """Excess (M, 2) at all knots from that at the first one; decay (M - 1,) and jump (M - 1, 2) up to each later one."""
    excess = [first]
    for factor, step in zip(decay, jump, strict=True):
        excess.append(excess[-1] * factor + step)
    return np.array(excess)


@dataclass(frozen=True, eq=False)
class SeawayMotion(SwayLaw):
    """The sway of one ship in a seaway, without yaw.

    waves: of the sea, which all ships have. form: of the hull.
    bounds: of the sway on all courses that the ship may take.
    lean: list (to starboard) and trim (by the stern) that are added to roll and pitch [rad].
    easing: of its velocity. stream: of the water, east and north [m/s].
    """

    waves: Waves
    form: HullForm
    bounds: Bounds
    lean: tuple[float, float] = (0.0, 0.0)
    easing: Easing = field(default_factory=Easing)
    stream: Stream = NO_STREAM

    @property
    def max_values(self) -> Floats:
        """The sums of amplitudes (4,) of roll, pitch, yaw and heave [rad, m], with list and trim."""
        return with_lean(self.bounds.values, self.lean)

    @property
    def max_rates(self) -> Floats:
        """The sums of amplitudes (4,) of their rates [rad/s, m/s]."""
        return self.bounds.rates

    @property
    def likely_values(self) -> Floats:
        """What roll, pitch, yaw and heave (4,) [rad, m] leave in one swing of a million."""
        return with_lean(np.minimum(LIKELY * self.bounds.deviation, self.bounds.values), self.lean)

    @property
    def likely_rates(self) -> Floats:
        """What their rates (4,) [rad/s, m/s] leave in one swing of a million."""
        return np.minimum(LIKELY * self.bounds.rate_deviation, self.bounds.rates)

    @property
    def shortest_period(self) -> float:
        """The shortest of 2 pi x (sum of amplitudes) / (sum of those of rates) [s]."""
        moves = self.bounds.rates > 0.0
        return float((2.0 * np.pi * self.bounds.values[moves] / self.bounds.rates[moves]).min())

    @property
    def text(self) -> str:
        """What `check` says of it, with a comma before each item."""
        roll, pitch, _, heave = (*np.degrees(self.bounds.deviation[:3]), self.bounds.deviation[3])
        rms = f", in the seaway up to {roll:.2g} degrees rms of roll, {pitch:.2g} of pitch, {heave:.2g} m of heave"
        return rms + lean_text(self.lean)

    @property
    def tilts(self) -> bool:
        """Whether the ship rolls or pitches: always."""
        return True

    @property
    def max_tilt(self) -> float:
        """An angle [rad] that its mast never leaves the vertical by."""
        return float(min(self.max_values[:2].sum(), np.pi / 2.0))

    def state(self, time: Floats, path: Path) -> SwayState:
        """Returns the sway at each time (K,) [s] of a motion along a path."""
        upright = path.upright(time)
        amplitude = self._amplitudes(upright.heading, self._felt(upright, time))
        phase = self.waves.phases(upright.position, time)
        values, rates = np.zeros((len(time), 4)), np.zeros((len(time), 4))
        cosine, sine = np.cos(phase), np.sin(phase)
        values[:, MOVES] = _real_sums(amplitude, cosine, sine)
        values[:, :2] += self.lean
        rates[:, MOVES] = _real_sums(self._rate_amplitudes(upright, time, amplitude), cosine, sine)
        return SwayState(values, rates)

    def rates_about(self, time: Floats, path: Path) -> Floats:
        """Returns rates (K, 4) [rad/s, m/s] about each time (K,) [s]; a swing reaches |sum of rotating phasors|."""
        upright = path.upright(time)
        amplitude = self._rate_amplitudes(upright, time, self._amplitudes(upright.heading, self._felt(upright, time)))
        phase = self.waves.phases(upright.position, time)
        cosine, sine = np.cos(phase), np.sin(phase)
        rate, across = _real_sums(amplitude, cosine, sine), _real_sums(-1j * amplitude, cosine, sine)
        rates = np.zeros((len(time), 4))
        rates[:, MOVES] = np.hypot(rate, REST * np.hypot(rate, across))
        return rates

    def on_course(self, heading: Floats, velocity: Floats) -> Complexes | None:
        """Returns amplitudes (1, 3, N) at all times on one heading (1,) [rad] at one velocity (3,) over ground [m/s]; None while
        the eased velocity is another one."""
        return None if self.easing.excess.any() else self._amplitudes(heading, velocity[None, :2] - self.stream)

    def excess(self, time: float) -> tuple[float, float]:
        """Returns the eased velocity minus the true one, east and north [m/s], at `time` [s]."""
        east, north = self.easing.at(np.array([time]))[0].tolist()
        return east, north

    def eased(self, excess: tuple[float, float], since: float) -> Self:
        """Returns the law along another path, with this `excess` [m/s] at time `since` [s]."""
        return replace(self, easing=Easing(np.array([since]), np.array([excess])))

    def _felt(self, upright: UprightMotion, time: Floats) -> Floats:
        """Eased velocity (K, 2) through the water [m/s]."""
        velocity = upright.velocity[:, :2] - self.stream
        return velocity if self.easing.vanishes(time) else velocity + self.easing.at(time)

    def _amplitudes(self, heading: Floats, velocity: Floats) -> Complexes:
        """Complex amplitudes (K, 3, N), or (1, 3, N) where all are one, of roll, pitch and heave; velocity: (K, 2)."""
        if len(heading) and (heading == heading[0]).all() and (velocity == velocity[0]).all():
            key = float(heading[0]), *velocity[0].tolist()
            return self._kept.get(key, lambda: amplitudes(self.waves, self.form, heading[:1], velocity[:1]))
        return amplitudes(self.waves, self.form, heading, velocity)

    @cached_property
    def _kept(self) -> ResultCache[tuple[float, ...], Complexes]:
        """Amplitudes on the latest courses: a straight one has one row of them."""
        return ResultCache(COURSES)

    def _rate_amplitudes(self, upright: UprightMotion, time: Floats, amplitude: Complexes) -> Complexes:
        """Complex amplitudes (K, 3, N) of the rates; amplitude: of the values."""
        east, north = self.waves.wavenumber.T
        met = upright.velocity[:, :1] * east + upright.velocity[:, 1:2] * north - self.waves.over_ground
        rate = 1j * met[:, None] * amplitude
        turn, turned = upright.turn_rate, upright.course_rate
        if self.easing.vanishes(time) and not turn.any() and not turned.any():
            return np.asarray(rate)
        v_east, v_north = upright.velocity[:, 0], upright.velocity[:, 1]
        change = np.stack([turned * v_north, -turned * v_east], axis=1) - self.easing.at(time) / EASING
        heading, felt = upright.heading, self._felt(upright, time)
        after = amplitudes(self.waves, self.form, heading + STEP * turn, felt + STEP * change)
        return np.asarray(rate + (after - amplitude) / STEP)


MOVES = [0, 1, 3]  # columns of roll, pitch and heave


def sways_on_course(
    laws: Sequence[SeawayMotion], amplitude: Sequence[Complexes], position: Floats, time: Floats
) -> tuple[Floats, Floats, Floats]:
    """Returns roll, pitch and heave (B, K) [rad, m] of ships of one seaway at times (K,) [s], by their amplitudes `on_course`.

    position: (B, K, 3) without heave [m].
    """
    phase = laws[0].waves.phases(position.reshape(-1, 3), np.tile(time, len(laws)))
    phase = phase.reshape(*position.shape[:2], phase.shape[1])
    roll, pitch, heave = np.moveaxis(_real_sums(np.stack(amplitude), np.cos(phase), np.sin(phase)), -1, 0)
    lean = np.array([law.lean for law in laws])
    return roll + lean[:, :1], pitch + lean[:, 1:], heave


def _real_sums(amplitude: Complexes, cosine: Floats, sine: Floats) -> Floats:
    """Real parts (..., K, 3) of sums of amplitude (..., K or 1, 3, N) x exp(i phase (..., K, N)); each row by itself, whatever
    their number."""
    return np.asarray((amplitude.real * cosine[..., None, :] - amplitude.imag * sine[..., None, :]).sum(axis=-1))


def amplitudes(waves: Waves, form: HullForm, heading: Floats, velocity: Floats) -> Complexes:
    """Returns complex amplitudes (K, 3, N) of roll, pitch [rad] and heave [m] by each wave, which has phase 0 at the origin of
    the ship's frame, about which it moves.

    heading: (K,) [rad]. velocity: (K, 2) through the water, east and north [m/s]; at most the largest speed of `form`.
    """
    east, north = waves.wavenumber.T
    cosine, sine = np.cos(heading)[:, None], np.sin(heading)[:, None]
    along, aside = sine * east + cosine * north, cosine * east - sine * north
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    slower = np.minimum(1.0, form.max_speed / np.maximum(speed, 1e-9))[:, None]
    encounter = waves.frequency - slower * (velocity[:, :1] * east + velocity[:, 1:] * north)
    roll, pitch, heave = response(form, waves.frequency, along, aside, encounter)
    starboard, forward = form.middle
    if starboard or forward:
        shift = np.exp(1j * (aside * starboard + along * forward))
        roll, pitch, heave = shift * roll, shift * pitch, shift * (heave - forward * pitch + starboard * roll)
    return np.asarray(waves.amplitude * np.stack([roll, pitch, heave], axis=1))


def bounds_of(waves: Waves, form: HullForm, heading: Floats, velocity: Floats, turn_rate: float = 0.0) -> Bounds:
    """Returns the bounds of a ship's sway over given headings (K,) [rad] and velocities (K, 2) through the water [m/s].

    turn_rate: the highest one [rad/s].
    """
    amplitude = np.abs(amplitudes(waves, form, heading, velocity))
    met = np.abs(waves.over_ground - velocity @ waves.wavenumber.T)[:, None]
    turning = 0.0
    if turn_rate:
        turned = amplitudes(waves, form, heading + STEP, velocity) - amplitudes(waves, form, heading, velocity)
        turning = turn_rate * np.abs(turned).sum(axis=-1).max(axis=0) / STEP
    values, rates = amplitude.sum(axis=-1).max(axis=0), (met * amplitude).sum(axis=-1).max(axis=0) + turning
    deviations = (np.sqrt((part**2).sum(axis=-1) / 2.0).max(axis=0) for part in (amplitude, met * amplitude))
    return Bounds(*(_with_yaw(part) for part in (values, rates, *deviations)))


def bounds_on_any_course(waves: Waves, form: HullForm, max_speed: float, turn_rate: float) -> Bounds:
    """Returns the bounds of a ship's sway on all headings, ahead at up to a speed through the water [m/s]; turn_rate: the
    highest one [rad/s]."""
    heading = np.repeat(2.0 * np.pi * np.arange(HEADINGS) / HEADINGS, SPEEDS)
    speed = np.tile(np.linspace(0.0, max_speed, SPEEDS), HEADINGS)
    velocity = speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    return Bounds(*(MARGIN * part for part in bounds_of(waves, form, heading, velocity, turn_rate)))


def _with_yaw(values: Floats) -> Floats:
    return np.array([values[0], values[1], 0.0, values[2]])
