"""How echoes reach the antenna other than by the plain beam: a path maps echoes as they are on boresight to those received."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.numerics.types import Floats
from radar_service.radar.structure_shadow import StructureShadow


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


class ShadowedBeam:
    """The direct path through a beam that own ship's structures shadow."""

    def __init__(self, shadow: StructureShadow) -> None:
        self._shadow = shadow

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The same echoes with the two-way field of the beam."""
        field = self._shadow.one_way(sights.from_bow, sights.offset)
        return echoes._replace(amplitude=(echoes.amplitude * field**2).astype(np.complex64))
