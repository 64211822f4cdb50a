"""Legs in the frame of a body: direct or by the sea, with their polarization, their wavefronts and what they can reach."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.frames import body_rotation, map_from_body
from radar_service.propagation.legs import Leg, direct_leg, leg_length, sea_leg
from radar_service.scene.poses import BodyPose
from radar_service.types import Flags, Floats, Indices

Visible = Callable[[Floats, Indices], Flags]  # which points (M, 3) on triangles (M,) a leg reaches past all bodies


class LegRays(NamedTuple):
    """The rays of one leg at points (M,), vectors in the body's own frame.

    length: of the leg [m].
    direction: (M, 3) of travel, of unit length.
    level, upright: (M, 3) unit vectors across it: horizontal, and in the vertical plane.
    curvature: (M,) of the wavefront in the vertical plane [1/m]; across it is 1 / length.
    tilt: (M,) by which the ray rises more steeply against the body, as the earth curves away from the antenna [rad].
    arrives: (M,) whether a ray gets there over the curved earth.
    """

    length: Floats
    direction: Floats
    level: Floats
    upright: Floats
    curvature: Floats
    tilt: Floats
    arrives: Flags

    def polarization(self, name: str) -> Floats:
        """Unit electric field (M, 3) of "h" (level) or "v" (upright) waves, the same out and back."""
        return self.level if name == "h" else self.upright

    def chosen(self, which: Indices) -> "LegRays":
        """The rays `which` (N,)."""
        return LegRays._make(column.take(which, axis=0) for column in self)

    def joined(self, other: "LegRays") -> "LegRays":
        """These rays, then the other ones."""
        return LegRays._make(np.concatenate(pair) for pair in zip(self, other, strict=True))

    def detours(self, offset: Floats) -> Floats:
        """How much longer the legs to neighbouring points are (N, M) [m], to second order; offset: (N, M, 3) from the points."""
        return _along(offset, self.direction) - self.sags(offset)

    def sags(self, edge: Floats) -> Floats:
        """-1/2 of the wavefront's bend over vectors (N, M, 3) [m]; an eighth of it is how much less the leg to the middle of an
        edge is than the mean of those to its ends, negative."""
        return -0.5 * (_along(edge, self.level) ** 2 / self.length + _along(edge, self.upright) ** 2 * self.curvature)


@dataclass(frozen=True)
class BodyLeg:
    """One leg between the antenna and a body.

    by_sea: whether the sea reflects it.
    pose: of the body.
    antenna: (3,) on the map [m].
    earth_radius: effective, inf for flat [m].
    visible: which points on which triangles the leg reaches past all bodies.
    crowded: whether another body may cast a shadow on this one.
    thin: whether a small one may.
    strength: no less than the field by this leg over that by the direct one, anywhere on the body.
    """

    by_sea: bool
    pose: BodyPose
    antenna: Floats
    earth_radius: float
    visible: Visible
    crowded: bool = True
    thin: bool = True
    strength: float = 1.0

    def rays(self, points: Floats) -> LegRays:
        """The rays at points (M, 3) in the body's frame [m]."""
        leg = self._leg(points)
        plan = leg.level @ body_rotation(self.pose.heading)[:2, :2]
        flat = np.sqrt(np.maximum(1.0 - leg.rise**2, 0.0))
        zero = np.zeros(len(flat))
        direction = np.stack([plan[:, 0] * flat, plan[:, 1] * flat, leg.rise], axis=1)
        level = np.stack([plan[:, 1], -plan[:, 0], zero], axis=1)
        upright = np.stack([-plan[:, 0] * leg.rise, -plan[:, 1] * leg.rise, flat], axis=1)
        return LegRays(leg.length, direction, level, upright, leg.curvature, leg.tilt, leg.arrives)

    def length(self, points: Floats) -> Floats:
        """Lengths (M,) of the leg to points (M, 3) in the body's frame [m]."""
        position = map_from_body(points, self.pose.position, self.pose.heading)
        return leg_length(position, self.antenna, self.earth_radius, self.by_sea)

    def _leg(self, points: Floats) -> Leg:
        position = map_from_body(points, self.pose.position, self.pose.heading)
        return (sea_leg if self.by_sea else direct_leg)(position, self.antenna, self.earth_radius)


def _along(vectors: Floats, axis: Floats) -> Floats:
    """Components (N, M) of vectors (N, M, 3) along an axis of each (M, 3)."""
    return np.asarray(np.einsum("nmi,mi->nm", vectors, axis))
