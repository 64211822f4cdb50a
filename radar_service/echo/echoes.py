"""The records that the stages of echoes hand over."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.types import Complexes, Floats, Indices, Profiles, Singles


@dataclass(frozen=True)
class Echoes:
    """Echoes (E,) on boresight: range (E,) [m], azimuth (E,) [rad], amplitude (E,) [sqrt(W)]."""

    range: Floats
    azimuth: Floats
    amplitude: Complexes

    def __post_init__(self) -> None:
        assert self.range.shape == self.azimuth.shape == self.amplitude.shape


@dataclass(frozen=True)
class AzimuthTimes:
    """Consecutive azimuths (K,): number since the start, boresight [rad], time [s]."""

    number: Indices
    boresight: Floats
    time: Floats

    def part(self, start: int, stop: int) -> "AzimuthTimes":
        """Azimuths start to stop (exclusive)."""
        return AzimuthTimes(self.number[start:stop], self.boresight[start:stop], self.time[start:stop])

    @property
    def middle(self) -> float:
        """Time of the middle azimuth [s]."""
        return float(self.time[len(self.time) // 2])


class BeamWeightedEchoes(NamedTuple):
    """Echoes (E,) over K consecutive azimuths, weighted by the beam.

    range: (E,) at the middle azimuth [m].
    range_migration: (E, K) change of range since the middle [m].
    amplitude: (E, K) [sqrt(W)].
    """

    range: Floats
    range_migration: Singles
    amplitude: Profiles


def concatenated(parts: Sequence[BeamWeightedEchoes], azimuths: int) -> BeamWeightedEchoes:
    """Echoes of several parts over the same azimuths as one record."""
    if len(parts) == 1:
        return parts[0]
    none = BeamWeightedEchoes(np.zeros(0), np.zeros((0, azimuths), np.float32), np.zeros((0, azimuths), np.complex64))
    return BeamWeightedEchoes(*(np.concatenate(column) for column in zip(none, *parts, strict=True)))
