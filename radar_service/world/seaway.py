"""Records of a seaway: what it is drawn from, and regular waves, whose sum is the elevation of the sea at any place and time.

Waves are linear and long-crested each, on deep water. They go with the tidal stream.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Floats

# Significant wave height H_1/3 [m] by Douglas sea state: the middle of each band of WMO code table 3700. State 9 has no
# upper limit, so it has its lower edge.
SIGNIFICANT_WAVE_HEIGHT = (0.0, 0.05, 0.3, 0.875, 1.875, 3.25, 5.0, 7.5, 11.5, 14.0)
# Most probable period of the spectrum's peak [s] by sea state on the open North Atlantic: Bales 1983 and NATO STANAG 4194, whose
# wave heights are those above. States 0 and 1 have none there, and the one of state 2 here.
PEAK_PERIOD = (7.5, 7.5, 7.5, 7.5, 8.8, 9.7, 12.4, 15.0, 16.4, 20.0)


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
