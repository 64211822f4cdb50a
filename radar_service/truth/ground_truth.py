"""Ground truth: the state of own ship and of every body at an instant, and whether the antenna has a line of sight to it.

A body in plain sight is told by its outermost vertices. What others hide in part is asked in points of its faces.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from radar_service.echo import apparent_range
from radar_service.numerics import BLAS_LIMIT, Flags, Floats, Indices, ResultCache, polar_from_map, wrap_bearing
from radar_service.propagation import ABOVE_LAND, LandBefore, radar_two_rays
from radar_service.radar import horizon
from radar_service.records import BodyTruth, Truth
from radar_service.scattering import R2, height_over_horizon, normals_and_areas, points_in_triangles, scattering_model
from radar_service.stages.points import observed_offset
from radar_service.trace import OcclusionScene, SurfacePoints, beyond_horizon
from radar_service.world import Mesh, Pose, Scene, geographic_from_map, pose_at, through_water

REASONS = ("beyond range", "below horizon", "blind sector", "shadowed", "")  # by how many tests a body passes, in this order
VISIBLE = len(REASONS) - 1  # tests that a visible point passes
OUTWARD = np.array(
    [[0, 0, 8], [1, 1, 2], [1, -1, 2], [-1, 1, 2], [-1, -1, 2], [1, 0, 0.1], [-1, 0, 0.1], [0, 1, 0.1], [0, -1, 0.1]]
)  # top, upper corners, sides
VERTICES = 2**18  # at a time
FACE_POINTS = 4096  # of a body, spread evenly over the area of its faces: 15 mm apart on a wall of 60 m, seen from its foot
FIRST = 8  # of so many points one is asked first, which tells most bodies
MAX_SURFACES = 512  # whose points are kept: 130 KB each
Candidates = tuple[Floats, Callable[[Indices], Flags]]  # points (W, 3) on the map [m]; which of them, by index, are visible


class GroundTruth:
    """The truth of a scene at any instant. Safe to call from several threads."""

    @BLAS_LIMIT.held()
    def __init__(self, scene: Scene, line_of_sight: OcclusionScene, sampler: str = "scatterers") -> None:
        """sampler: of the fidelity, as `scattering_model` takes it."""
        self.scene, self.line_of_sight, self.earth_radius = scene, line_of_sight, line_of_sight.earth_radius
        self._rests = scene.own_ship.at_rest and all(body.at_rest for body in scene.bodies)
        self._search = SurfaceSearch(scene, line_of_sight)
        self._over_horizon = np.array([height_over_horizon(body, scene, sampler) for body in scene.bodies])

    @BLAS_LIMIT.held()
    def at(self, time: float) -> Truth:
        """Own ship and every body at `time` [s]."""
        scene = self.scene
        antenna = scene.antenna(time)[0]
        own = scene.own_ship.pose(time)
        every = np.arange(len(scene.bodies))
        reasons = self.why_invisible(every, np.full(len(every), time))
        bodies = tuple(
            self._record(body.name, body.motion.pose(time), antenna, reason, body.mmsi, body.arm)
            for body, reason in zip(scene.bodies, reasons, strict=True)
        )
        return Truth(time, self._record("own ship", own, antenna, "", None, 0.0), bodies)

    @BLAS_LIMIT.held()
    def why_invisible(self, bodies: Indices, time: Floats) -> list[str]:
        """For each of bodies (E,) the reason why no part of it is visible at its time (E,) [s]; "" where one is."""
        if not len(bodies):
            return []
        if self._rests:
            return [self._resting_reasons[body] for body in bodies.tolist()]
        return self._reasons(bodies, time)

    @cached_property
    def _resting_reasons(self) -> list[str]:
        """The reasons of all bodies in a scene where nothing moves."""
        every = np.arange(len(self.scene.bodies))
        return self._reasons(every, np.zeros(len(every)))

    def _reasons(self, bodies: Indices, time: Floats) -> list[str]:
        here, passed = self._present(bodies, time), self._tests_passed(bodies, time)
        for e in np.flatnonzero(here & (passed < VISIBLE)).tolist():
            passed[e] = max(passed[e], self._searched(int(bodies[e]), float(time[e])))
        return [REASONS[n] if present else "absent" for n, present in zip(passed.tolist(), here.tolist(), strict=True)]

    def _tests_passed(self, bodies: Indices, time: Floats) -> Indices:
        """How many tests each of bodies (E,) passes at its time (E,) [s], by its outermost points alone."""
        parts = [self._outermost(int(body), t) for body, t in zip(bodies, time.tolist(), strict=True)]
        count = [len(part) for part in parts]
        point, when = np.concatenate(parts), np.repeat(time, count)
        antenna = self.scene.antenna(time).repeat(count, axis=0)
        reach = np.repeat(self._over_horizon[bodies], count)
        passed = self._passed(point, antenna, when, reach, lambda lit: ~self._occluded(point[lit], antenna[lit], when[lit]))
        return np.maximum.reduceat(passed, np.cumsum([0, *count[:-1]]))

    def _searched(self, body: int, time: float) -> int:
        """How many tests any point of a body's surface passes at `time` [s]: the search ends at the first that passes all."""
        antenna, reach = self.scene.antenna(time)[0], float(self._over_horizon[body])
        when, most = np.array(time), 0
        if self.scene.bodies[body].mesh is None or self._is_far(body, antenna, time):
            return most
        for point, seen in self._search.candidates(body, antenna, time, reach):
            if len(point):
                most = max(most, int(self._passed(point, antenna, when, reach, seen).max()))
            if most == VISIBLE:
                break
        return most

    def _passed(
        self, point: Floats, antenna: Floats, when: Floats, reach: Floats | float, seen: Callable[[Indices], Flags]
    ) -> Indices:
        """How many tests, in the order of REASONS, each point (W, 3) on the map passes.

        antenna: (3,) or (W, 3); when: () or (W,) [s]; reach: height up to which fields reach beyond the horizon [m];
        seen: which of some points, by their indices, nothing occludes.
        """
        polar = polar_from_map(point, antenna, self.earth_radius)
        near = apparent_range(self.scene.radar, polar.range) <= self.scene.radar.range_max
        over = beyond_horizon(polar.distance, point[:, 2], antenna[..., 2], self.earth_radius, reach)
        lit = near & ~over & ~self._in_blind_sector(point - antenna, np.broadcast_to(when, near.shape))
        which = np.flatnonzero(lit)
        visible = np.zeros(len(point), dtype=np.int64)
        visible[which] = seen(which)
        return np.asarray(near.astype(np.int64) + (near & ~over) + lit + visible)

    def _in_blind_sector(self, offset: Floats, time: Floats) -> Flags:
        """Which points at offsets (W, 3) from the antenna [m] it observes in a blind sector at times (W,) [s]."""
        if not self.scene.radar.blind_sectors:
            return np.zeros(len(offset), dtype=np.bool_)
        observed = observed_offset(self.scene, offset, time)
        return self.scene.blind(time, np.arctan2(observed[:, 0], observed[:, 1]))

    def _is_far(self, body: int, antenna: Floats, time: float) -> bool:
        """Whether all of a body with a mesh lies beyond the maximum range or the horizon."""
        scene_body, radar = self.scene.bodies[body], self.scene.radar
        nearest = math.dist(scene_body.middle_at(time)[:2], antenna[:2]) - scene_body.radius
        top = float(self._outermost(body, time)[:, 2].max()) + scene_body.diagonal
        sea = np.inf if self._over_horizon[body] else float(horizon(top, float(antenna[2]), self.earth_radius))
        return nearest > min(np.inf if radar.second_time_around else radar.range_max, sea)

    def _present(self, bodies: Indices, time: Floats) -> Flags:
        """Whether each of bodies (E,) is present at its time (E,) [s]."""
        presences = self.line_of_sight.presences
        if not len(presences.changing):
            return np.asarray(presences.at(0.0)[bodies])
        return np.array([presences.at(t)[body] for body, t in zip(bodies.tolist(), time.tolist(), strict=True)])

    def _outermost(self, body: int, time: float) -> Floats:
        """The outermost points (W, 3) of a body on the map at `time` [s]."""
        return pose_at(self.scene.bodies[body], time).map_from_frame(self._search.outermost[body])

    def _occluded(self, point: Floats, antenna: Floats, time: Floats) -> Flags:
        """Which points (W, 3) any body occludes from antennas (W, 3) at times (W,) [s]."""
        occluded = self.line_of_sight.occluded_by_resting(point, antenna)
        edges = [0, *(np.flatnonzero(np.diff(time)) + 1).tolist(), len(time)]
        for start, stop in pairwise(edges) if self.line_of_sight.has_movers else ():
            left = start + np.flatnonzero(~occluded[start:stop])
            if len(left):
                occluded[left] = self.line_of_sight.occluded_by_moving(point[left], antenna[start], float(time[start]))
        return occluded

    def _record(self, name: str, pose: Pose, antenna: Floats, reason: str, mmsi: int | None, extent: float) -> BodyTruth:
        position = pose.position[0]
        polar = polar_from_map(position, antenna, self.earth_radius)
        latitude, longitude = None, None
        if self.scene.origin is not None:
            latitude, longitude = (float(v) for v in geographic_from_map(position, self.scene.origin))
        course, speed = water_tracks(self.scene, pose)
        return BodyTruth(
            name, triple(position), triple(pose.velocity[0]),
            float(pose.heading[0]), float(pose.course[0]), float(pose.speed[0]), float(polar.range),
            float(wrap_bearing(polar.azimuth)), float(polar.elevation), not reason, reason, latitude, longitude, mmsi,
            float(extent), course[0], speed[0],
        )  # fmt: skip


def water_tracks(scene: Scene, pose: Pose) -> tuple[list[float], list[float]] | tuple[list[None], list[None]]:
    """Returns course [rad] and speed [m/s] through the water at K times; None without a tidal stream."""
    if not any(scene.environment.stream):
        return [None] * len(pose.heading), [None] * len(pose.heading)
    course, speed = through_water(pose.velocity, pose.heading, scene.environment.stream)
    return course.tolist(), speed.tolist()


def triple(vector: Sequence[float] | Floats) -> tuple[float, float, float]:
    """Returns a vector (3,) as plain numbers."""
    return float(vector[0]), float(vector[1]), float(vector[2])


def outermost(mesh: Mesh) -> Floats:
    """The vertices (K, 3) that lie farthest out in the directions of OUTWARD, in the body's own frame [m]."""
    vertices, farthest, index = mesh.used_vertices, np.full(len(OUTWARD), -np.inf), np.zeros(len(OUTWARD), dtype=np.int64)
    for start in range(0, len(vertices), VERTICES):
        reach = vertices[start : start + VERTICES] @ OUTWARD.T
        first, most = reach.argmax(axis=0), reach.max(axis=0)
        index, farthest = np.where(most > farthest, start + first, index), np.maximum(most, farthest)
    return np.asarray(vertices[np.unique(index)])


def face_points(mesh: Mesh) -> tuple[Indices, Floats]:
    """FACE_POINTS points in faces, evenly over their area: the triangle of each, and positions (N, 3) in the body's frame [m]."""
    cumulated, number = np.cumsum(normals_and_areas(mesh)[1]), np.arange(FACE_POINTS)
    steps = (number + 0.5) * (cumulated[-1] / FACE_POINTS)
    return points_in_triangles(mesh, cumulated, steps, np.outer(R2, number + 1) % 1.0)


class SurfaceSearch:
    """Points of the bodies of a scene, in the order in which the truth tests them. Safe to call from several threads.

    outermost: points (K, 3) of each body in its own frame [m]; the origin of a body without a mesh.
    """

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self._scene, self._line_of_sight = scene, line_of_sight
        self._faces: ResultCache[int, tuple[Indices, Floats]] = ResultCache(MAX_SURFACES)
        self.outermost = [np.zeros((1, 3)) if body.mesh is None else outermost(body.mesh) for body in scene.bodies]

    def candidates(self, body: int, antenna: Floats, time: float, reach: float) -> Iterator[Candidates]:
        """Points of a body with a mesh for the antenna (3,) at `time` [s]; reach: height up to which fields reach beyond
        the horizon [m]."""
        faces = self._points(body, time)
        seen = partial(self._line_of_sight.visible, antenna=antenna, time=time, max_range=np.inf, over_horizon=reach)
        for points in (_chosen(faces, np.arange(0, FACE_POINTS, FIRST)), faces):
            yield points.position, lambda lit, points=points: seen(_chosen(points, lit))  # type: ignore[misc]
        if scattering_model(self._scene.bodies[body]).lit_by_sea and self._scene.environment.multipath:
            yield faces.position, lambda lit: self._visible_by_sea(_chosen(faces, lit), antenna, time)

    def _points(self, body: int, time: float) -> SurfacePoints:
        scene_body = self._scene.bodies[body]
        assert scene_body.mesh is not None
        mesh = scene_body.mesh
        triangle, position = self._faces.get(body, lambda: face_points(mesh))
        return SurfacePoints(np.full(len(triangle), body), triangle, pose_at(scene_body, time).map_from_frame(position))

    def _visible_by_sea(self, points: SurfacePoints, antenna: Floats, time: float) -> Flags:
        """Which points (W,) a ray by the sea reaches, or by land."""
        land = LandBefore(self._line_of_sight, antenna, points.position - antenna)
        rays = radar_two_rays(self._scene.radar, self._scene.environment, *land.site, land=land)
        reflection = antenna + land.offset * (rays.geometry.reflection / np.maximum(land.site[0], 1e-9))[:, None]
        reflection[:, 2] = rays.level + ABOVE_LAND * (rays.level != 0.0)
        arrives = (rays.geometry.grazing > 0.0) & (rays.ratio != 0.0)
        return np.asarray(arrives & self._line_of_sight.visible_by_sea(points, reflection, antenna, time, np.inf))


def _chosen(points: SurfacePoints, which: Indices) -> SurfacePoints:
    return SurfacePoints(points.body[which], points.triangle[which], points.position[which])
