"""Line of sight from the antenna to points, directly or by the sea: past the horizon, the maximum range, the body itself and
all other bodies."""

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from radar_service.frames import Polar, distances_from_map
from radar_service.scene.body import Body
from radar_service.scene.poses import MAP_POSE, BodyPose, BodyPoses, merged_mesh
from radar_service.trace.embree import RayCount
from radar_service.trace.occluder import Occluder, beyond_horizon
from radar_service.types import Flags, Floats, Indices


class SurfacePoints(NamedTuple):
    """E points on surfaces: index of the body in the scene, triangle in its mesh (-1: the body counts as a point), and
    position (E, 3) on the map [m]."""

    body: Indices
    triangle: Indices
    position: Floats


class Shadow(NamedTuple):
    """What one body occludes: its sector, as `Occluder.shadow_sector`, and which positions (W, 3) on the map in it."""

    sector: tuple[float, float, float]
    occludes: Callable[[Floats], Flags]


class OcclusionScene:
    """All that may occlude: one occluder for all bodies at rest, and one for each mesh that moves."""

    def __init__(
        self, bodies: Sequence[Body], earth_radius: float, without: Collection[int] = (), rays: RayCount | None = None
    ) -> None:
        """earth_radius: effective, inf for flat [m]; without: indices of moving bodies that never occlude, not even
        themselves; rays: counts the rays cast, where given."""
        self.earth_radius = earth_radius
        self._resting: Flags = np.array([body.motion.at_rest for body in bodies], dtype=np.bool_)
        self._bodies = tuple(bodies)
        self._occludes: Flags = np.array(
            [b.mesh is not None and i not in without for i, b in enumerate(bodies)], dtype=np.bool_
        )
        self._plan = np.array([[*body.middle_at(0.0)[:2], body.radius] for body in bodies]).reshape(-1, 3)
        self._faces: Indices = np.array(
            [0 if body.mesh is None else len(body.mesh.faces) for body in bodies], dtype=np.int64
        )
        resting_faces = np.where(self._resting, self._faces, 0)
        self._first_face = np.cumsum(resting_faces) - resting_faces  # of each body in the merged mesh
        merged = merged_mesh([body for body in bodies if body.motion.at_rest])
        self._resting_occluder = None if merged is None else Occluder(merged, earth_radius, rays)
        self._movers = {
            i: Occluder(body.mesh, earth_radius, rays)
            for i, body in enumerate(bodies)
            if body.mesh is not None and not body.motion.at_rest and i not in without
        }
        self._poses = BodyPoses([bodies[i] for i in self._movers])
        self._last_poses: tuple[float, dict[int, BodyPose]] = (np.nan, {})

    def visible(
        self,
        points: SurfacePoints,
        antenna: Floats,
        time: float,
        max_range: float,
        movers: bool = True,
        among: Collection[int] | None = None,
    ) -> Flags:
        """Which points (E,) have a line of sight to the antenna (3,) at `time` [s].

        max_range: beyond it nothing is visible [m]; movers: whether bodies that move may occlude; among: the only ones of these
        that can, besides the points' own body, where that is known from `other_occluders`.
        """
        position = points.position
        distance, slant = distances_from_map(position, antenna, self.earth_radius)
        over = beyond_horizon(distance, position[:, 2], float(antenna[2]), self.earth_radius)
        left = np.flatnonzero(~over & (slant < max_range))
        for occluder, pose, key in self._occluders(points.body, time, movers, among):
            own = (self._resting[points.body] if key is None else points.body == key)[left]
            if own.any() or occluder.may_occlude(pose, antenna, position[left]):
                left = left[~self._occluded_by(occluder, pose, points, antenna, left, own)]
        visible = np.zeros(len(position), dtype=np.bool_)
        visible[left] = True
        return visible

    def visible_by_sea(
        self,
        points: SurfacePoints,
        reflection: Floats,
        antenna: Floats,
        time: float,
        max_range: float,
        movers: bool = True,
        among: Collection[int] | None = None,
    ) -> Flags:
        """Which points (E,) the antenna (3,) observes by rays that the sea reflects at `reflection` (E, 3) on the map [m].

        Other arguments as `visible`. Both ways are straight lines: from the antenna to the sea, where land or a hull may stand in
        its place, and on to the point.
        """
        position = points.position
        distance, slant = distances_from_map(position, antenna, self.earth_radius)
        over = beyond_horizon(distance, position[:, 2], float(antenna[2]), self.earth_radius)
        left = np.flatnonzero(~over & (slant < max_range))
        for occluder, pose, key in self._occluders(points.body, time, movers, among):
            own = (self._resting[points.body] if key is None else points.body == key)[left]
            if own.any() or occluder.may_occlude(pose, antenna, position[left]):
                left, own = self._not_hidden(left, own, occluder.occludes(pose, antenna, reflection.take(left, axis=0)))
                left = left[~self._occluded_by(occluder, pose, points, reflection.take(left, axis=0), left, own)]
        visible = np.zeros(len(position), dtype=np.bool_)
        visible[left] = True
        return visible

    def other_occluders(self, body: int, antenna: Floats, time: float, movers: bool = True) -> tuple[Indices, Floats]:
        """Indices (O,) and radii (O,) [m] in plan of the other bodies that may occlude a body from the antenna (3,),
        by a quick test in plan."""
        plan = self._plan if not len(self._movers) else self._plan_at(time)
        line, radius = plan[body, :2] - antenna[:2], plan[:, 2]
        toward = plan[:, :2] - antenna[:2]
        along = np.clip(toward @ line / max(float(line @ line), 1e-12), 0.0, 1.0)
        miss = np.hypot(*(toward - along[:, None] * line).T)
        near = (miss <= (radius + radius[body]) * 1.001 + 1.0) & self._occludes & (movers | self._resting)
        near[body] = False
        return np.flatnonzero(near), radius[near]

    def _plan_at(self, time: float) -> Floats:
        """Middle and radius (B, 3) of all bodies in plan at `time` [s]."""
        plan = self._plan.copy()
        for b in np.flatnonzero(~self._resting & self._occludes):
            plan[b, :2] = self._bodies[b].middle_at(time)[:2]
        return plan

    def occluded(self, position: Floats, antenna: Floats, time: float, movers: bool = True) -> Flags:
        """Which positions (W, 3) on the map any body occludes from the antenna (3,) at `time` [s]; movers: as in `visible`."""
        occluded = np.zeros(len(position), dtype=np.bool_)
        if self._resting_occluder is not None:
            occluded |= self._resting_occluder.occludes(MAP_POSE, antenna, position)
        for key, pose in self._mover_poses(time).items() if movers else ():
            occluded |= self._movers[key].occludes(pose, antenna, position)
        return occluded

    def resting_shadow_sector(self, antenna: Floats) -> tuple[float, float, float]:
        """The sector that bodies at rest may occlude, as `Occluder.shadow_sector`; a half width of 0 where nothing rests."""
        resting = self._resting_occluder
        return (0.0, 0.0, np.inf) if resting is None else resting.shadow_sector(MAP_POSE, antenna)

    def moving_shadow_sectors(self, antenna: Floats, time: float) -> list[tuple[float, float, float]]:
        """The sector that each moving body may occlude at `time` [s], as `Occluder.shadow_sector`."""
        return [self._movers[key].shadow_sector(pose, antenna) for key, pose in self._mover_poses(time).items()]

    def moving_shadows(self, numbers: Sequence[int], antenna: Floats, time: float) -> list[Shadow]:
        """Shadows of moving bodies by their numbers in `moving_shadow_sectors` at `time` [s]."""
        movers = list(self._mover_poses(time).items()) if numbers else []
        shadows = []
        for key, pose in (movers[number] for number in numbers):
            occluder = self._movers[key]
            shadows.append(Shadow(occluder.shadow_sector(pose, antenna), partial(occluder.occludes, pose, antenna)))
        return shadows

    def shadowed(self, position: Floats, polar: Polar, antenna: Floats, time: float) -> Indices:
        """Indices of resting positions that a moving body occludes at `time` [s], each once.

        position: (E, 3), visible past all bodies at rest, by rising azimuth; polar: the same relative to the antenna (3,).
        """
        shadowed = [np.zeros(0, dtype=np.int64)]
        for key, pose in self._mover_poses(time).items() if len(position) else ():
            occluder = self._movers[key]
            middle, half, begin = occluder.shadow_sector(pose, antenna)
            behind = _within(polar.azimuth, middle, half)
            behind = behind[polar.distance[behind] >= begin]
            shadowed.append(behind[occluder.occludes(pose, antenna, position[behind])])
        return np.unique(np.concatenate(shadowed))

    def _occluders(
        self, body: Indices, time: float, movers: bool, among: Collection[int] | None
    ) -> list[tuple[Occluder, BodyPose, int | None]]:
        """All occluders at `time` [s], their poses and body indices (None: all bodies at rest). The resting one comes first,
        but a mover that all points lie on comes before it, as it occludes most of itself."""
        result: list[tuple[Occluder, BodyPose, int | None]] = []
        if self._resting_occluder is not None:
            result.append((self._resting_occluder, MAP_POSE, None))
        result += [(self._movers[key], pose, key) for key, pose in (self._mover_poses(time) if movers else {}).items()]
        if among is not None:
            result = [
                occluder for occluder in result if occluder[2] is None or occluder[2] in among or (body == occluder[2]).any()
            ]
        return sorted(result, key=lambda occluder: occluder[2] is None or not (body == occluder[2]).all())

    def _mover_poses(self, time: float) -> dict[int, BodyPose]:
        at, poses = self._last_poses
        if at != time:
            poses = dict(zip(self._movers, self._poses.each_at(time), strict=True))
            self._last_poses = time, poses  # one assignment: another thread finds either this or its own
        return poses

    @staticmethod
    def _not_hidden(which: Indices, own: Flags, hidden: Flags) -> tuple[Indices, Flags]:
        return which[~hidden], own[~hidden]

    def _occluded_by(
        self, occluder: Occluder, pose: BodyPose, points: SurfacePoints, origin: Floats, which: Indices, own: Flags
    ) -> Flags:
        """Of points `which` (W,), those that this occluder occludes from an origin (3,), or from one each (W, 3); `own` (W,)
        flags points on the occluder itself."""
        if own.all():
            triangles = self._own_triangles(points, which)
            return occluder.self_occluded(pose, origin, points.position.take(which, axis=0), triangles)
        if not own.any():
            return occluder.occludes(pose, origin, points.position.take(which, axis=0))
        occluded = np.zeros(len(which), dtype=np.bool_)
        triangles = self._own_triangles(points, which[own])
        own_origin, other_origin = (origin, origin) if origin.ndim == 1 else (origin[own], origin[~own])
        occluded[own] = occluder.self_occluded(pose, own_origin, points.position[which[own]], triangles)
        occluded[~own] = occluder.occludes(pose, other_origin, points.position[which[~own]])
        return occluded

    def _own_triangles(self, points: SurfacePoints, which: Indices) -> tuple[Indices, Indices]:
        """First and last triangle (exclusive) that cannot occlude each point: its own one, or all of a point-like body."""
        key, triangle = points.body[which], points.triangle[which]
        first = np.where(self._resting, self._first_face, 0)[key]
        on_triangle = triangle >= 0
        last = np.where(on_triangle, first + triangle + 1, first + self._faces[key])
        return first + np.where(on_triangle, triangle, 0), last


def _within(azimuth: Floats, middle: float, half: float) -> Indices:
    """Indices of the rising azimuths (E,) [-pi, pi] that lie within `half` of `middle`, the short way round [rad]."""
    full_turns = 2.0 * np.pi * np.arange(-1, 2)
    first = np.searchsorted(azimuth, middle - half + full_turns)
    last = np.searchsorted(azimuth, middle + half + full_turns, side="right")
    return np.unique(np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)]))
