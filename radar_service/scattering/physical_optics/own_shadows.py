"""Shadows that a body casts on itself, found in the frame in which it is upright: no point goes to the map and back."""

from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import Kernels, kernels
from radar_service.numerics.frames import body_rotation, map_from_body
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.propagation.multipath import reflection_distance
from radar_service.scattering.physical_optics.ray_tubes import by_axis, cross, dot
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
        if compiled := kernels():
            return self._compiled_edges(compiled, hidden, triangle, (way, curved_way, onward))
        share, edge, result = np.zeros(len(way)), np.zeros(len(way)), np.full(len(way), np.nan)
        left = np.arange(len(way))
        for step in range(STEPS):
            occluding, end, origin = self.occluding(hidden[left] + share[left, None] * way[left], triangle[left])
            free = left[occluding == NO_TRIANGLE]
            result[free] = edge[free]
            known = np.flatnonzero(occluding >= 0)
            if not len(known):
                break
            left, corners = left[known], self.occluder.corners(occluding[known])
            further = _way_out(corners, by_axis(end[known]), by_axis(origin[known]), by_axis(curved_way[left]))
            edge[left] = np.minimum(share[left] + further, 1.0)
            share[left] = np.minimum(edge[left] + 2.0**step * onward[left], 1.0)
        return result

    def occluding(self, points: Floats, triangle: Indices) -> tuple[Indices, Floats, Floats]:
        """Which triangle occludes points (M, 3) on triangles (M,), NO_TRIANGLE or BEFORE_THE_SEA; the points in the body's own
        curved frame, and where their rays seem to come from (M, 3) [m]."""
        at_x, at_y, at_z = (self.antenna - self.pose.position) @ body_rotation(self.pose.heading)
        if compiled := kernels():
            return self._compiled_occluding(compiled, points, triangle, float(at_x), float(at_y))
        if not self.by_sea:
            end, line = self._lines(points, at_x, at_y, at_z - self._drop(at_x, at_y))
            return self.occluder.occluding_triangle(end, line, triangle), end, end - line
        x, y, z = points.T
        distance = np.sqrt((x - at_x) ** 2 + (y - at_y) ** 2)
        share = reflection_distance(distance, z + self.pose.position[2], float(self.antenna[2]), self.earth_radius)
        share /= np.maximum(distance, MARGIN)
        begin_x, begin_y, sea = at_x + share * (x - at_x), at_y + share * (y - at_y), -self.pose.position[2]
        end, line = self._lines(points, begin_x, begin_y, sea - self._drop(begin_x, begin_y))
        occluding = self.occluder.occluding_triangle(end, line, triangle)
        reflection = np.stack([begin_x, begin_y, np.full(len(x), sea)], axis=1)
        occluding[self._lost(occluding == NO_TRIANGLE, reflection, distance * (1.0 - share))] = BEFORE_THE_SEA
        return occluding, end, end - line / np.maximum(1.0 - share, 1e-6)[:, None]

    def _compiled_occluding(
        self, compiled: Kernels, points: Floats, triangle: Indices, at_x: float, at_y: float
    ) -> tuple[Indices, Floats, Floats]:
        """Runs the kernels that do what `occluding` does. at_x, at_y: the antenna in the upright body's frame [m]."""
        scene, count = self.occluder.scene, len(points)
        end, line, origin, reflection = (np.empty((count, 3)) for _ in range(4))
        begin, direction = np.empty((count, 3), dtype=np.float32), np.empty((count, 3), dtype=np.float32)
        beyond, occluding = np.empty(count), np.empty(count, dtype=np.int64)
        compiled.run(
            "own_shadow_rays", count, self.by_sea, np.ascontiguousarray(points), at_x, at_y, float(self.antenna[2]),
            -float(self.pose.position[2]), self.earth_radius, scene.centre, scene.radius,
            UPRIGHT if self.pose.lean is None else np.ascontiguousarray(self.pose.lean),
            end, line, origin, begin, direction, reflection, beyond,
        )  # fmt: skip
        hit = scene.first_hit_of(begin, direction)
        on = np.ascontiguousarray(triangle, dtype=np.int64)
        compiled.run("own_shadow_hits", count, hit, on, end, line, *scene.planes, occluding)
        if self.by_sea:
            occluding[self._lost(occluding == NO_TRIANGLE, reflection, beyond)] = BEFORE_THE_SEA
        return occluding, end, origin

    def _compiled_edges(
        self, compiled: Kernels, hidden: Floats, triangle: Indices, ways: tuple[Floats, Floats, Floats]
    ) -> Floats:
        """Runs the kernel that does what `edges` does.

        ways: (M, 3) in the upright body's frame, the same curved and in the body's own, and how far beyond an edge the next ray
        ends (M,), a share.
        """
        scene, points, on, count = self.occluder.scene, hidden, triangle, len(hidden)
        way, curved_way, onward = ways
        known = (
            way,
            curved_way,
            np.ascontiguousarray(hidden),
            np.ascontiguousarray(triangle),
            onward,
            scene.vertices,
            scene.faces,
        )
        share, edge, result, left = np.zeros(count), np.zeros(count), np.full(count, np.nan), np.arange(count)
        for step in range(STEPS):
            occluding, end, origin = self.occluding(points, on)
            points, on = np.empty((count, 3)), np.empty(count, dtype=np.int64)
            at = (left, occluding, end, origin)
            count = compiled.run("shadow_edge_step", count, 2.0**step, *at, *known, share, edge, result, points, on)
            points, on = points[:count], on[:count]
            if not count:
                break
        return result

    def _lost(self, free: Flags, reflection: Floats, beyond: Floats) -> Indices:
        """The free ones of points (M,) whose rays do not reach the sea before the body.

        reflection: (M, 3) points at the sea [m]; beyond: how far they lie before the points in plan [m].
        """
        near = np.flatnonzero(free & (beyond < 2.0 * self.occluder.sphere[1] + MARGIN))
        if not len(near):
            return near
        position = map_from_body(reflection[near], self.pose.position, self.pose.heading)
        return near[self.occluder.occludes(self.pose, self.antenna, position)]

    def _lines(self, points: Floats, begin_x: Floats, begin_y: Floats, begin_z: Floats) -> tuple[Floats, Floats]:
        """Points (M, 3) in the body's own curved frame, and the lines to them from begins in the upright body's curved frame
        [m], one for all or one each (M,)."""
        end = self._curved(points)
        line = np.empty_like(end)
        for axis, begin in enumerate((begin_x, begin_y, begin_z)):
            np.subtract(end[:, axis], begin, out=line[:, axis])
        return self._in_body(end), self._in_body(line)

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


def _way_out(corners: Floats, begin: Floats, origin: Floats, way: Floats) -> Floats:
    """Where ways (3, M) from points in the shadows of triangles leave these: shares (M,), inf where they never do.

    corners: (3, 3, M), by corner and axis; begin, origin: (3, M) the points, and where the rays come from. The shadow ends at
    planes through `origin` and the edges; the third corner tells which side of each is inside.
    """
    from_origin, offset = corners - origin, begin - origin
    result = np.full(way.shape[1], np.inf)
    for a, b, c in zip(from_origin, from_origin[[1, 2, 0]], from_origin[[2, 0, 1]], strict=True):
        plane = cross(a, b)
        change = dot(plane, way)
        leaves = change * dot(plane, c) < 0.0
        share = np.divide(-dot(plane, offset), change, out=np.full(len(result), np.inf), where=leaves)
        np.minimum(result, np.maximum(share, 0.0), out=result)
    return result
