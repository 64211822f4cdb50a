"""A seaway: regular waves, drawn once from a spectrum, whose sum is the elevation of the sea at any place and time.

Waves are linear and long-crested each, on deep water. They go with the tidal stream.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.constants import GRAVITY
from radar_service.numerics.random import SEAWAY, generator
from radar_service.numerics.types import Floats
from radar_service.world.stream import NO_STREAM, Stream

# Significant wave height H_1/3 [m] by Douglas sea state: the middle of each band of WMO code table 3700. State 9 has no
# upper limit, so it has its lower edge.
SIGNIFICANT_WAVE_HEIGHT = (0.0, 0.05, 0.3, 0.875, 1.875, 3.25, 5.0, 7.5, 11.5, 14.0)
# Most probable period of the spectrum's peak [s] by sea state on the open North Atlantic: Bales 1983 and NATO STANAG 4194, whose
# wave heights are those above. States 0 and 1 have none there, and the one of state 2 here.
PEAK_PERIOD = (7.5, 7.5, 7.5, 7.5, 8.8, 9.7, 12.4, 15.0, 16.4, 20.0)
WAVES = 64  # regular waves; their bands are 2.9 % wide, a third of the resonance of a roll with 5 % of critical damping
LOWEST, HIGHEST = 0.55, 3.5  # frequencies over that of the peak: 1.2e-6 of the energy lies below, 0.8 % above
DIRECTIONS = 4001  # points of the table of directions: its steps are 0.045 degrees


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


def drawn_waves(seaway: Seaway, stream: Stream = NO_STREAM) -> Waves:
    """Returns the waves of a seaway. The variance of their sum over time is (height / 4)^2.

    A wave has the energy of its band of the spectrum, a frequency within the band, and a direction. Directions are spread
    evenly over their distribution, in random order. stream: of the water, east and north [m/s].
    """
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
