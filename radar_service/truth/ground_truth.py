"""Ground truth: the state of own ship and of every body at an instant, and whether the antenna has a line of sight to it."""

import math
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise

import numpy as np

from radar_service.echo.second_time_around import apparent_range
from radar_service.numerics.frames import polar_from_map, wrap_bearing
from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.radar.parameters import horizon
from radar_service.records.truth import BodyTruth, Truth
from radar_service.scattering.models import height_over_horizon
from radar_service.stages.points import observed_offset
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.occluder import beyond_horizon
from radar_service.truth.surface_search import SurfaceSearch
from radar_service.world.geo import geographic_from_map
from radar_service.world.motion import Pose
from radar_service.world.poses import pose_at
from radar_service.world.scene import Scene
from radar_service.world.stream import through_water

REASONS = ("beyond range", "below horizon", "blind sector", "shadowed", "")  # by how many tests a body passes, in this order
VISIBLE = len(REASONS) - 1  # tests that a visible point passes


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
            name, _triple(position), _triple(pose.velocity[0]),
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


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
