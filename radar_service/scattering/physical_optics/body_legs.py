"""Legs in the frame of a body: direct or by the sea, with their rays, their lengths, and what hides the body on the way."""

import math
from dataclasses import dataclass

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.frames import body_rotation, map_from_body
from radar_service.numerics.types import Complexes, Floats
from radar_service.scattering.physical_optics.cast_shadows import CastShadows
from radar_service.scattering.physical_optics.sea_field import SeaField
from radar_service.world.poses import BodyPose


@dataclass(frozen=True)
class BodyLeg:
    """One leg between the antenna and a body.

    by_sea: whether the sea reflects it.
    pose: of the body.
    antenna: (3,) on the map [m].
    earth_radius: effective, inf for flat [m].
    sea: the field of this leg where diffraction counts; of all paths where it stands for them; None: that of a ray.
    others: what other bodies hide; None: nothing.
    """

    by_sea: bool
    pose: BodyPose
    antenna: Floats
    earth_radius: float
    sea: SeaField | None = None
    others: CastShadows | None = None

    def eye(self, middle: Floats) -> Floats:
        """The point (3,) in the body's frame from which straight lines run as the leg does about the middle (3,) of the body
        [m]."""
        length, direction = np.empty(1), np.empty(3)
        KERNELS.leg_rays(1, self.by_sea, *self._to(middle[None]), length, direction[None])
        return np.asarray(middle - length * direction / np.linalg.norm(direction))

    def screens(self, middle: Floats, eye: Floats) -> Floats:
        """The triangles (T, 3, 3) of other bodies that hide parts of this one, as the eye has them in the body's frame [m];
        middle, eye: as of `eye`."""
        if self.others is None or not len(self.others):
            return np.zeros((0, 3, 3))
        flipped = np.array([1.0, 1.0, -1.0 if self.by_sea else 1.0])

        def turned(virtual: Floats) -> Floats:
            return np.asarray(virtual * flipped @ body_rotation(self.pose.heading))

        ahead, seen = middle - eye, turned(self.others.picture.virtual(self.on_map(middle)))
        level = ahead[:2] / max(np.hypot(*ahead[:2]), 1e-9)
        lift = np.arctan2(ahead[2], ahead[:2] @ level) - np.arctan2(seen[2], seen[:2] @ level)
        corners = turned(self.others.corners)
        along, up = corners[..., :2] @ level, corners[..., 2]
        farther = along * (np.cos(lift) - 1.0) - up * np.sin(lift)
        corners[..., :2] += farther[..., None] * level
        corners[..., 2] = along * np.sin(lift) + up * np.cos(lift)
        return np.asarray(eye + corners)

    def on_map(self, points: Floats) -> Floats:
        """Points (..., 3) of the body's frame on the map [m]."""
        return map_from_body(points, self.pose.position, self.pose.heading)

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
