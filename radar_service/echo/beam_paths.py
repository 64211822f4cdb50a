"""How echoes reach the antenna other than by the plain beam: a path maps echoes as they are on boresight to those received."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.echo.second_time_around import max_apparent_range
from radar_service.numerics import Complexes, Floats, wrap_angle
from radar_service.radar import ChangedPattern, Radar


@dataclass(frozen=True)
class Sights:
    """Directions of echoes (E,) at azimuths (K,), as the antenna observes them [rad].

    bearing: (E, K) of the echoes, clockwise from north.
    boresight, heading: (K,) of the antenna and of own ship.
    """

    bearing: Floats
    boresight: Floats
    heading: Floats

    @property
    def from_bow(self) -> Floats:
        """Directions of the echoes (E, K), clockwise from the bow."""
        return self.bearing - self.heading

    @property
    def offset(self) -> Floats:
        """Directions of the echoes (E, K) from boresight, not wrapped."""
        return self.bearing - self.boresight


class BeamPath(Protocol):
    """A path of echoes to the antenna and back. Implementations are safe to call from several threads."""

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """Echoes (M,) that this path makes of echoes (E,), which have the amplitude on boresight at each azimuth."""


class Beam:
    """The one-way field of the antenna."""

    def __init__(self, radar: Radar, pattern: ChangedPattern | None) -> None:
        """pattern: past what stands before the antenna; None: nothing does."""
        self._radar, self.pattern = radar, pattern

    def field(self, sights: Sights) -> Complexes:
        """To the echoes (E, K), over that on boresight; its square is the two-way field."""
        if self.pattern is None:
            return np.sqrt(self._radar.azimuth_gain(wrap_angle(sights.offset))).astype(np.complex128)
        return self.pattern.one_way(sights.from_bow, sights.offset)


class DirectPath:
    """The direct path there and back."""

    def __init__(self, beam: Beam) -> None:
        self._beam = beam

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The same echoes with the two-way field of the beam."""
        return echoes._replace(amplitude=(echoes.amplitude * self._beam.field(sights) ** 2).astype(np.complex64))


def false_echoes(
    radar: Radar, echoes: BeamWeightedEchoes, factor: Complexes, farther: Floats, source: int
) -> BeamWeightedEchoes:
    """Echoes (E,) times a factor (E, K), farther off (E, K) [m], within a profile; source: in place of their bodies."""
    middle = farther[:, farther.shape[1] // 2]
    distance = echoes.range + middle
    kept = np.flatnonzero((distance < max_apparent_range(radar)) & factor.any(axis=1))
    migration = echoes.range_migration[kept] + (farther[kept] - middle[kept, None]).astype(np.float32)
    amplitude = (echoes.amplitude[kept] * factor[kept]).astype(np.complex64)
    return BeamWeightedEchoes(distance[kept], migration, amplitude, np.full(len(kept), source))
