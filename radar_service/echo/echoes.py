"""The records that the stages of echoes hand over."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Complexes, Floats, Indices, Profiles, Singles

SECOND_TIME = -1  # in place of a body's index: the echo is one of an earlier pulse


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
    body: (E,) index of the body in the scene; SECOND_TIME for echoes of an earlier pulse; of effects see `Context.echo_sources`.
    """

    range: Floats
    range_migration: Singles
    amplitude: Profiles
    body: Indices

    def chosen(self, which: Indices) -> "BeamWeightedEchoes":
        """The echoes `which` (N,)."""
        return BeamWeightedEchoes(
            self.range[which],
            self.range_migration.take(which, axis=0),
            self.amplitude.take(which, axis=0),
            self.body[which],
        )


def concatenated(parts: Sequence[BeamWeightedEchoes], azimuths: int) -> BeamWeightedEchoes:
    """Echoes of several parts over the same azimuths as one record."""
    if len(parts) == 1:
        return parts[0]
    each = np.zeros((0, azimuths))
    none = BeamWeightedEchoes(np.zeros(0), each.astype(np.float32), each.astype(np.complex64), np.zeros(0, np.int64))
    return BeamWeightedEchoes(*(np.concatenate(column) for column in zip(none, *parts, strict=True)))
