"""How echoes reach the antenna other than by the plain beam: a path maps echoes as they are on boresight to those received."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from radar_service.echo.echoes import INDIRECT, MULTIPLE, AzimuthTimes, BeamWeightedEchoes, concatenated
from radar_service.echo.second_time_around import max_apparent_range
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Complexes, Flags, Floats, Indices, Profiles
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.radar.parameters import Radar
from radar_service.radar.structure_reflection import Reflector
from radar_service.radar.structure_shadow import structure_reflectors, structure_shadow
from radar_service.world.scene import Scene


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

    @classmethod
    def joined(cls, parts: Sequence["Sights"]) -> "Sights":
        """The directions of several parts at the same azimuths."""
        return cls(np.concatenate([part.bearing for part in parts]), parts[0].boresight, parts[0].heading)


class BeamPath(Protocol):
    """A path of echoes to the antenna and back. Implementations are safe to call from several threads."""

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """Echoes (M,) that this path makes of echoes (E,), which have the amplitude on boresight at each azimuth."""


class Beam:
    """The one-way field of the antenna, past own ship's structures where it has any."""

    def __init__(self, radar: Radar, extent: float) -> None:
        """extent: offset from boresight up to which structures change the beam [rad]."""
        self._radar, self._shadow = radar, structure_shadow(radar, extent)

    def field(self, sights: Sights) -> Complexes:
        """To the echoes (E, K), over that on boresight; its square is the two-way field."""
        if self._shadow is None:
            return np.sqrt(self._radar.azimuth_gain(wrap_angle(sights.offset))).astype(np.complex128)
        return self._shadow.one_way(sights.from_bow, sights.offset)


class DirectPath:
    """The direct path there and back."""

    def __init__(self, radar: Radar, extent: float) -> None:
        """extent: as of `Beam`."""
        self._beam = Beam(radar, extent)

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The same echoes with the two-way field of the beam."""
        return echoes._replace(amplitude=(echoes.amplitude * self._beam.field(sights) ** 2).astype(np.complex64))


class MultiplePaths:
    """Echoes of ships near by that own ship throws back to them: at n times the range, each weaker than the one before.

    A wave that a ship of cross-section s at R has sent back meets own ship, of s', and returns once more: its field falls by
    root(s s') / (4 pi R^2) each time (the radar equation twice). The ship's own field, all her echoes added, is that of the
    azimuth; it counts as one echo at her centre of power, and own ship as a point below the antenna.
    """

    def __init__(self, radar: Radar, extent: float, ships: Flags) -> None:
        """extent: as of `Beam`; ships: which bodies (B,) of the scene have such echoes."""
        assert radar.multiple is not None
        self._radar, self._multiple, self._beam, self._ships = radar, radar.multiple, Beam(radar, extent), ships

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The second, third, ... traces of all ships."""
        near = (echoes.body >= 0) & self._ships[echoes.body] & (echoes.range <= self._multiple.max_range)
        which = np.flatnonzero(near)
        if not len(which):
            return concatenated([], len(sights.boresight))
        chosen = echoes.chosen(which)
        beam = self._beam.field(Sights(sights.bearing[which], sights.boresight, sights.heading)) ** 2
        once_more, farther = self._once_more(chosen)
        parts, factor = [], beam
        for order in range(1, self._multiple.orders + 1):
            factor = factor * once_more
            parts.append(false_echoes(self._radar, chosen, factor, order * farther, MULTIPLE))
        return concatenated(parts, len(sights.boresight))

    def _once_more(self, echoes: BeamWeightedEchoes) -> tuple[Complexes, Floats]:
        """By what the field (E, K) changes each time, and how much farther off (E, K) it appears [m]."""
        _, ship = np.unique(echoes.body, return_inverse=True)
        distance = echoes.range[:, None] + echoes.range_migration.astype(np.float64)
        power = np.abs(echoes.amplitude) ** 2 + np.float64(np.finfo(np.float32).tiny)
        total = _sums(power, ship)
        middle = _sums(power * distance, ship) / total
        # Of the root of her cross-section, with its phase:
        field = _sums(echoes.amplitude, ship) / received_amplitude(self._radar, middle)
        field *= np.sqrt(self._multiple.own_rcs) / (4.0 * np.pi * np.maximum(middle, self._radar.range_min) ** 2)
        return field[ship], middle[ship]


def _sums(values: Floats | Complexes | Profiles, group: Indices) -> Any:
    """Sums of values (E, K) over the rows of each group, by their numbers (E,) from 0 on."""
    total = np.zeros((int(group.max()) + 1, values.shape[1]), dtype=np.result_type(values.dtype, np.float64))
    np.add.at(total, group, values)
    return total


def false_echoes(
    radar: Radar, echoes: BeamWeightedEchoes, factor: Complexes, farther: Floats, kind: int
) -> BeamWeightedEchoes:
    """Echoes (E,) times a factor (E, K), farther off (E, K) [m], as far as a profile reaches; kind: in place of their bodies."""
    middle = farther[:, farther.shape[1] // 2]
    distance = echoes.range + middle
    kept = np.flatnonzero((distance < max_apparent_range(radar)) & factor.any(axis=1))
    migration = echoes.range_migration[kept] + (farther[kept] - middle[kept, None]).astype(np.float32)
    amplitude = (echoes.amplitude[kept] * factor[kept]).astype(np.complex64)
    return BeamWeightedEchoes(distance[kept], migration, amplitude, np.full(len(kept), kind))


class IndirectPaths:
    """Paths by own ship's structures: there and back by one, and one way by it. Their echoes are false.

    They stand where boresight points at the structure, farther off than the target by the detour or by half of it. A target has
    the echoes that the antenna receives of it: from a structure some metres off, scatterers add up with other phases.
    """

    def __init__(self, radar: Radar, extent: float) -> None:
        """extent: as of `Beam`."""
        self._radar, self._beam, self._reflectors = radar, Beam(radar, extent), structure_reflectors(radar)

    def are_lit(self, scene: Scene, azimuths: AzimuthTimes) -> Flags:
        """At which azimuths (K,) any structure may be lit."""
        boresight = azimuths.boresight - scene.platform.heading(azimuths.time)
        return np.asarray(np.any([reflector.is_lit(boresight) for reflector in self._reflectors], axis=0))

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The false echoes of all structures."""
        direct = self._beam.field(sights)
        parts = [part for reflector in self._reflectors for part in self._by(reflector, echoes, sights, direct)]
        return concatenated(parts, len(sights.boresight))

    def _by(
        self, reflector: Reflector, echoes: BeamWeightedEchoes, sights: Sights, direct: Complexes
    ) -> list[BeamWeightedEchoes]:
        """Paths there and back by one structure, and paths one way by it."""
        field, ray = reflector.field(sights.from_bow, sights.boresight - sights.heading)
        return [
            false_echoes(self._radar, echoes, field**2, ray.detour, INDIRECT),
            false_echoes(self._radar, echoes, 2.0 * direct * field, 0.5 * ray.detour, INDIRECT),
        ]
