"""Records of a seaway: what it is drawn from, and regular waves, whose sum is the elevation of the sea at any place and time.

Waves are linear and long-crested each, on deep water. They go with the tidal stream.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Floats

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
