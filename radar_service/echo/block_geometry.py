"""Geometry of a block of azimuths: poses and antenna at its nodes and azimuths, and positions of echoes there."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.range_history import Parabola, apparent_position, elevation_of
from radar_service.kernels.library import KERNELS
from radar_service.numerics import Flags, Floats, Indices, Polar, Singles, polar_from_map
from radar_service.scattering import BodyEchoes
from radar_service.world import PoseArrays


@dataclass(frozen=True)
class ObservedEchoes:
    """Echoes (M,) of bodies of a set, as evaluated at one instant or more.

    echoes: in the bodies' own frames.
    position: (M, 3) on the map [m]; of bodies at rest it holds at any time.
    fade: (M, K) weight of each echo at each azimuth of a block; None: 1.
    """

    echoes: BodyEchoes
    position: Floats
    fade: Singles | None = None

    @classmethod
    def joined(cls, parts: "list[ObservedEchoes]") -> "list[ObservedEchoes]":
        """The echoes of several parts as one; none of none. All have fades, or none has."""
        if len(parts) < 2:
            return parts
        position = np.concatenate([part.position for part in parts])
        fades = [part.fade for part in parts if part.fade is not None]
        return [cls(BodyEchoes.joined([part.echoes for part in parts]), position, np.concatenate(fades) if fades else None)]


class BlockGeometry(NamedTuple):
    """Geometry of some azimuths (K,), first at the three nodes of their parabola, then at each of them.

    azimuths: the azimuths.
    over: the parabola over their times.
    poses: of the bodies (3 + K, B); at the nodes alone (3, B) where all bodies go straight.
    antenna: (3 + K, 3) on the map [m].
    level: (3 + K, 3, 3) as `Scene.upright_from_map`; None for an antenna that does not sway.
    rough: (B,) which bodies leave their parabola.
    moves: (B,) which bodies move on the map.
    """

    azimuths: AzimuthTimes
    over: Parabola
    poses: PoseArrays
    antenna: Floats
    level: Floats | None
    rough: Flags
    moves: Flags

    def positions(self, observed: ObservedEchoes, which: Indices, instants: Sequence[int]) -> list[Floats]:
        """Positions (E, 3) of echoes `which` relative to the antenna, along the map's axes [m], at some instants of the block."""
        poses, count, body = self.poses, len(self.moves), observed.echoes.body
        some = np.flatnonzero(np.bincount(body[which], minlength=count))  # headings of others are undefined
        turn = np.zeros((2, len(instants), count))
        heading = poses.heading[instants][:, some]
        turn[0][:, some], turn[1][:, some] = np.cos(heading), np.sin(heading)
        matrices = [rotation[instants] for rotation in poses.rotation.values()]
        lean = np.stack(matrices, axis=1) if matrices else np.zeros((len(instants), 0, 3, 3))
        result = np.empty((len(instants), 3, len(which)))
        taken = which, observed.position, observed.echoes.position, body, self.moves, poses.rotation_numbers
        taken += (poses.position[instants], *turn, lean, self.antenna[instants])
        sizes = len(which), len(instants), len(body), count, len(matrices)
        KERNELS.echo_positions(*sizes, *map(np.ascontiguousarray, taken), result)
        return [position.T for position in result]


@dataclass(frozen=True)
class PartGeometry:
    """Where some echoes (E,) are at the three nodes of a block.

    nodes: positions (E, 3) relative to the antenna [m], along the map's axes.
    apparent: the same as an antenna that sways observes them (`apparent_position`).
    polar: at the middle.
    azimuth, elevation: (E,) at the middle, as observed [rad].
    """

    nodes: list[Floats]
    apparent: list[Floats]
    polar: Polar
    azimuth: Floats
    elevation: Floats

    @classmethod
    def of(cls, observed: ObservedEchoes, which: Indices, block: BlockGeometry, earth_radius: float) -> "PartGeometry":
        """Of echoes `which` (E,)."""
        nodes = block.positions(observed, which, range(3))
        polar, level = polar_from_map(nodes[1], np.zeros(3), earth_radius), block.level
        if level is None:
            return cls(nodes, nodes, polar, polar.azimuth, polar.elevation)
        apparent = [apparent_position(nodes[n], level[n], earth_radius) for n in range(3)]
        azimuth = np.arctan2(apparent[1][:, 0], apparent[1][:, 1])
        return cls(nodes, apparent, polar, azimuth, elevation_of(apparent[1]))

    def elevations(self) -> list[Floats]:
        """Elevations (E,) at the three nodes, as observed [rad]."""
        return [elevation_of(self.apparent[0]), self.elevation, elevation_of(self.apparent[2])]
