"""Shadows that a body casts on itself, found in the frame in which it is upright: no point goes to the map and back."""

from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.frames import body_rotation, map_from_body
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.trace.occluder import NO_TRIANGLE, Occluder
from radar_service.world.poses import BodyPose

MARGIN = 1.0  # m by which a reflection point must lie before the body, so that it needs no search
BEFORE_THE_SEA = -2  # in place of a triangle: the body occludes the way from the antenna to the sea
UPRIGHT = np.eye(3)  # the lean of a body that does not
STEPS = 5  # from triangle to triangle, toward the edge of a shadow; most end after one or two
ONWARD = 1e-3  # m beyond the edge of a triangle's shadow, where the next ray ends; twice as far at each step


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
        return np.asarray(self.occluding(points, triangle)[0] == NO_TRIANGLE)

    def edges(self, hidden: Floats, seen: Floats, triangle: Indices) -> Floats:
        """Where the edge of the shadow lies on the way from points that are hidden to ones that are seen, both (M, 3) in the
        frame of the upright body [m]: shares (M,) of the way, NaN where it was not found.

        From a hidden point the way goes on to where the triangle that occludes it ceases to do so, which is exact, and so on
        from triangle to triangle until nothing occludes.
        """
        way = seen - hidden
        curved_way = self._in_body(self._curved(seen) - self._curved(hidden))
        onward = ONWARD / np.maximum(np.sqrt(np.einsum("ij,ij->i", way, way)), ONWARD)
        scene, points, on, count = self.occluder.scene, hidden, triangle, len(way)
        known = (way, curved_way, *map(np.ascontiguousarray, (hidden, triangle)), onward, scene.vertices, scene.faces)
        share, edge, result, left = np.zeros(count), np.zeros(count), np.full(count, np.nan), np.arange(count)
        for step in range(STEPS):
            occluding, end, origin = self.occluding(points, on)
            points, on = np.empty((count, 3)), np.empty(count, dtype=np.int64)
            at, vertices = (left, occluding, end, origin), len(scene.vertices)
            count = KERNELS.shadow_edge_step(count, vertices, 2.0**step, *at, *known, share, edge, result, points, on)
            points, on = points[:count], on[:count]
            if not count:
                break
        return result

    def occluding(self, points: Floats, triangle: Indices) -> tuple[Indices, Floats, Floats]:
        """Which triangle occludes points (M, 3) on triangles (M,), NO_TRIANGLE or BEFORE_THE_SEA; the points in the body's own
        curved frame, and where their rays seem to come from (M, 3) [m]."""
        at_x, at_y, _ = (self.antenna - self.pose.position) @ body_rotation(self.pose.heading)
        scene, count = self.occluder.scene, len(points)
        end, line, origin, reflection = (np.empty((count, 3)) for _ in range(4))
        begin, direction = np.empty((count, 3), dtype=np.float32), np.empty((count, 3), dtype=np.float32)
        beyond, occluding = np.empty(count), np.empty(count, dtype=np.int64)
        KERNELS.own_shadow_rays(
            count, self.by_sea, np.ascontiguousarray(points), float(at_x), float(at_y), float(self.antenna[2]),
            -float(self.pose.position[2]), self.earth_radius, scene.centre, scene.radius,
            UPRIGHT if self.pose.lean is None else np.ascontiguousarray(self.pose.lean),
            end, line, origin, begin, direction, reflection, beyond,
        )  # fmt: skip
        hit = scene.first_hit_of(begin, direction)
        on = np.ascontiguousarray(triangle, dtype=np.int64)
        KERNELS.own_shadow_hits(count, hit, on, end, line, *scene.planes, occluding)
        if self.by_sea:
            occluding[self._lost(occluding == NO_TRIANGLE, reflection, beyond)] = BEFORE_THE_SEA
        return occluding, end, origin

    def _lost(self, free: Flags, reflection: Floats, beyond: Floats) -> Indices:
        """The free ones of points (M,) whose rays do not reach the sea before the body.

        reflection: (M, 3) points at the sea [m]; beyond: how far they lie before the points in plan [m].
        """
        near = np.flatnonzero(free & (beyond < 2.0 * self.occluder.sphere[1] + MARGIN))
        if not len(near):
            return near
        position = map_from_body(reflection[near], self.pose.position, self.pose.heading)
        return near[self.occluder.occludes(self.pose, self.antenna, position)]

    def _curved(self, points: Floats) -> Floats:
        """Points (M, 3) in the curved frame of the upright body [m]."""
        curved = points.copy()
        curved[:, 2] -= self._drop(curved[:, 0], curved[:, 1])
        return curved

    def _in_body(self, vectors: Floats) -> Floats:
        """Vectors (M, 3) of the upright body's frame in the body's own."""
        return vectors if self.pose.lean is None else vectors @ self.pose.lean

    def _drop(self, x: Floats, y: Floats) -> Floats:
        """By how much the earth curves away at (x, y) from the body's origin [m]."""
        return np.asarray((x * x + y * y) / (2.0 * self.earth_radius))
