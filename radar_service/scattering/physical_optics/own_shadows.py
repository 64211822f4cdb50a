"""Shadows that a body casts on itself, found in the frame in which it is upright: no point goes to the map and back."""

from typing import NamedTuple

import numpy as np

from radar_service.frames import body_rotation, map_from_body
from radar_service.propagation.multipath import reflection_distance
from radar_service.scene.poses import BodyPose
from radar_service.trace.occluder import Occluder
from radar_service.types import Flags, Floats, Indices

MARGIN = 1.0  # m by which a reflection point must lie before the body, so that it needs no search


class OwnShadows(NamedTuple):
    """What a body hides of itself along one leg.

    occluder, pose: of the body.
    antenna: (3,) on the map [m].
    earth_radius: effective, inf for flat [m].
    by_sea: whether the sea reflects the leg.
    """

    occluder: Occluder
    pose: BodyPose
    antenna: Floats
    earth_radius: float
    by_sea: bool

    def visible(self, points: Floats, triangle: Indices) -> Flags:
        """Which points (M, 3) in the frame of the upright body [m], on triangles (M,), no other part of it occludes."""
        at_x, at_y, at_z = (self.antenna - self.pose.position) @ body_rotation(self.pose.heading)
        if not self.by_sea:
            return ~self._occluded(points, at_x, at_y, at_z - self._drop(at_x, at_y), triangle)
        x, y, z = points.T
        distance = np.sqrt((x - at_x) ** 2 + (y - at_y) ** 2)
        share = reflection_distance(distance, z + self.pose.position[2], float(self.antenna[2]), self.earth_radius)
        share /= np.maximum(distance, MARGIN)
        begin_x, begin_y, sea = at_x + share * (x - at_x), at_y + share * (y - at_y), -self.pose.position[2]
        free = ~self._occluded(points, begin_x, begin_y, sea - self._drop(begin_x, begin_y), triangle)
        return self._reached(free, np.stack([begin_x, begin_y, np.full(len(x), sea)], axis=1), distance * (1.0 - share))

    def _reached(self, free: Flags, reflection: Floats, beyond: Floats) -> Flags:
        """Those of points (M,) that are free whose rays reach the sea before the body.

        reflection: (M, 3) points at the sea [m]; beyond: how far they lie before the points in plan [m].
        """
        near = np.flatnonzero(free & (beyond < 2.0 * self.occluder.sphere[1] + MARGIN))
        if len(near):
            position = map_from_body(reflection[near], self.pose.position, self.pose.heading)
            free[near] = ~self.occluder.occludes(self.pose, self.antenna, position)
        return free

    def _occluded(self, points: Floats, begin_x: Floats, begin_y: Floats, begin_z: Floats, triangle: Indices) -> Flags:
        """Which points (M, 3) are occluded from begins in the upright body's curved frame [m], one for all or one each (M,)."""
        end = points.copy()
        end[:, 2] -= self._drop(end[:, 0], end[:, 1])
        line = np.empty_like(end)
        for axis, begin in enumerate((begin_x, begin_y, begin_z)):
            np.subtract(end[:, axis], begin, out=line[:, axis])
        lean = self.pose.lean
        if lean is not None:
            end, line = end @ lean, line @ lean
        return self.occluder.occludes_own(end, line, triangle)

    def _drop(self, x: Floats, y: Floats) -> Floats:
        """By how much the earth curves away at (x, y) from the body's origin [m]."""
        return np.asarray((x * x + y * y) / (2.0 * self.earth_radius))
