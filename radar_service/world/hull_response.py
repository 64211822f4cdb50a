"""How a hull answers to regular waves: roll, pitch and heave over the wave's amplitude, in closed form.

Heave and pitch are those of Jensen, Mansour and Olsen, "Estimation of ship motions using closed-form expressions", Ocean
Engineering 31 (2004) 61-85: a box with the hull's length, draught and displacement. Roll answers to the mean slope of the sea
across the hull. Their roll moment, from the damping by Haskind's relation, goes to 0 in long waves, where a boat has the slope
of the sea: in beam seas of sea states 3 and 5 it gives 0.4 and 0.3 of this roll at 75 m (0.9 and 4.2 degrees
rms), and less at 12 m.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.numerics import GRAVITY, Complexes, Floats

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
