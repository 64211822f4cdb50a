"""Line of sight from the antenna to points: past the horizon, the maximum range, the body itself and all other bodies."""

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

    def visible(self, points: SurfacePoints, antenna: Floats, time: float, max_range: float, movers: bool = True) -> Flags:
        """Which points (E,) have a line of sight to the antenna (3,) at `time` [s].

        max_range: beyond it nothing is visible [m]; movers: whether bodies that move may occlude.
        """
        position = points.position
        distance, slant = distances_from_map(position, antenna, self.earth_radius)
        over = beyond_horizon(distance, position[:, 2], float(antenna[2]), self.earth_radius)
        left = np.flatnonzero(~over & (slant < max_range))
        for occluder, pose, key in self._occluders(points.body, time, movers):
            own = (self._resting[points.body] if key is None else points.body == key)[left]
            if own.any() or occluder.may_occlude(pose, antenna, position[left]):
                left = left[~self._occluded_by(occluder, pose, points, antenna, left, own)]
        visible = np.zeros(len(position), dtype=np.bool_)
        visible[left] = True
        return visible

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

    def _occluders(self, body: Indices, time: float, movers: bool) -> list[tuple[Occluder, BodyPose, int | None]]:
        """All occluders at `time` [s], their poses and body indices (None: all bodies at rest). The resting one comes first,
        but a mover that all points lie on comes before it, as it occludes most of itself."""
        result: list[tuple[Occluder, BodyPose, int | None]] = []
        if self._resting_occluder is not None:
            result.append((self._resting_occluder, MAP_POSE, None))
        result += [(self._movers[key], pose, key) for key, pose in (self._mover_poses(time) if movers else {}).items()]
        return sorted(result, key=lambda occluder: occluder[2] is None or not (body == occluder[2]).all())

    def _mover_poses(self, time: float) -> dict[int, BodyPose]:
        return dict(zip(self._movers, self._poses.each_at(time), strict=True))

    def _occluded_by(
        self, occluder: Occluder, pose: BodyPose, points: SurfacePoints, antenna: Floats, which: Indices, own: Flags
    ) -> Flags:
        """Of points `which` (W,), those that this occluder occludes; `own` (W,) flags points on the occluder itself."""
        if own.all():
            triangles = self._own_triangles(points, which)
            return occluder.self_occluded(pose, antenna, points.position.take(which, axis=0), triangles)
        if not own.any():
            return occluder.occludes(pose, antenna, points.position.take(which, axis=0))
        occluded = np.zeros(len(which), dtype=np.bool_)
        triangles = self._own_triangles(points, which[own])
        occluded[own] = occluder.self_occluded(pose, antenna, points.position[which[own]], triangles)
        occluded[~own] = occluder.occludes(pose, antenna, points.position[which[~own]])
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
