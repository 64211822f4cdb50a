"""Legs in the frame of a body: direct or by the sea, with their polarization, their wavefronts and what they can reach."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.frames import map_from_body
from radar_service.numerics.types import Complexes, Flags, Floats, Indices
from radar_service.scattering.physical_optics.cast_shadows import CastShadows
from radar_service.scattering.physical_optics.sea_field import SeaField
from radar_service.scattering.physical_optics.shadow_edges import Edges, Visible
from radar_service.world.poses import BodyPose


class LegRays(NamedTuple):
    """The rays of one leg at points (M,), in the body's own frame. Vectors are made of numbers where they are asked for.

    length: of the leg [m].
    east, north: (M,) horizontal unit vector of travel, along the frame's x and y.
    rise, flat: (M,) sine and cosine of the elevation of travel.
    curvature: (M,) of the wavefront in the vertical plane [1/m]; across it is 1 / length.
    tilt: (M,) by which the ray rises more steeply against the body, as the earth curves away from the antenna [rad].
    arrives: (M,) whether a ray gets there over the curved earth.
    """

    length: Floats
    east: Floats
    north: Floats
    rise: Floats
    flat: Floats
    curvature: Floats
    tilt: Floats
    arrives: Flags

    @property
    def direction(self) -> Floats:
        """Unit vectors (M, 3) of travel."""
        return np.stack([self.east * self.flat, self.north * self.flat, self.rise], axis=1)

    @property
    def level(self) -> Floats:
        """Horizontal unit vectors (M, 3) across the rays."""
        return np.stack([self.north, -self.east, np.zeros(len(self.rise))], axis=1)

    @property
    def upright(self) -> Floats:
        """Unit vectors (M, 3) across the rays in the vertical plane."""
        return np.stack([-self.east * self.rise, -self.north * self.rise, self.flat], axis=1)

    def polarization(self, name: str) -> Floats:
        """Unit electric field (M, 3) of "h" (level) or "v" (upright) waves, the same out and back."""
        return self.level if name == "h" else self.upright

    def chosen(self, which: Indices) -> "LegRays":
        """The rays `which` (N,)."""
        return LegRays._make(column.take(which, axis=0) for column in self)

    def along(self, vector: Floats) -> Floats:
        """Components (..., M) of vectors (3, ..., M) along the rays."""
        return np.asarray((vector[0] * self.east + vector[1] * self.north) * self.flat + vector[2] * self.rise)

    def sags(self, edge: Floats) -> Floats:
        """-1/2 of the wavefront's bend over vectors (3, N, M) [m]; an eighth of it is how much less the leg to the middle of an
        edge is than the mean of those to its ends, negative."""
        bends = np.empty((edge.shape[1], edge.shape[2]))
        taken = (edge, self.east, self.north, self.rise, self.flat, self.length, self.curvature)
        KERNELS.sags(edge.shape[2], len(bends), *map(np.ascontiguousarray, taken), bends)
        return bends


@dataclass(frozen=True)
class BodyLeg:
    """One leg between the antenna and a body.

    by_sea: whether the sea reflects it.
    pose: of the body.
    antenna: (3,) on the map [m].
    earth_radius: effective, inf for flat [m].
    visible: which points on which triangles the leg reaches past the body itself.
    others: the shadows of all others.
    edges: finds the edges of its own shadows exactly; None where shadows are searched for by `visible` alone.
    strength: no less than the field by this leg over that by the direct one, anywhere on the body.
    sea: the field of this leg where diffraction counts; of all paths where it stands for them; None: that of a ray.
    """

    by_sea: bool
    pose: BodyPose
    antenna: Floats
    earth_radius: float
    visible: Visible
    edges: Edges | None = None
    strength: float = 1.0
    sea: SeaField | None = None
    others: CastShadows | None = None

    def reaches(self, points: Floats, triangle: Indices) -> Flags:
        """Which points (M, 3) in the body's frame [m] on triangles (M,) the leg reaches past all bodies."""
        seen = self.visible(points, triangle)
        if self.others is not None and len(self.others):
            seen &= self.others.visible(self.on_map(points))
        return seen

    def on_map(self, points: Floats) -> Floats:
        """Points (..., 3) of the body's frame on the map [m]."""
        return map_from_body(points, self.pose.position, self.pose.heading)

    def rays(self, points: Floats) -> LegRays:
        """The rays at points (M, 3) in the body's frame [m]."""
        rays = LegRays._make([*np.empty((7, len(points))), np.empty(len(points), dtype=np.bool_)])
        KERNELS.leg_rays(len(points), self.by_sea, *self._to(points), *rays)
        return rays

    def length(self, points: Floats) -> Floats:
        """Lengths (M,) of the leg to points (M, 3) in the body's frame [m]."""
        length = np.empty(len(points))
        KERNELS.leg_lengths(len(points), self.by_sea, *self._to(points), length)
        return length

    def weight(self, points: Floats) -> Complexes | Floats:
        """What fields at points (M, 3) in the body's frame [m] are multiplied by (M,), besides their way: 1 of the direct leg,
        what the curved sea leaves of the one by it, or what `sea` says."""
        if self.sea is not None:
            return self.sea.at(points[:, 2] + float(self.pose.position[2]))
        if not self.by_sea:
            return np.ones(len(points))
        weight = np.empty(len(points))
        KERNELS.leg_weights(len(points), *self._to(points), weight)
        return weight

    def _to(self, points: Floats) -> tuple[Floats, Floats, float, float, Floats, float]:
        """What kernels take of the leg to points (M, 3) in the body's frame [m]."""
        pose, heading = self.pose, self.pose.heading
        return (
            np.ascontiguousarray(points), np.ascontiguousarray(pose.position), math.cos(heading), math.sin(heading),
            np.ascontiguousarray(self.antenna), self.earth_radius,
        )  # fmt: skip
