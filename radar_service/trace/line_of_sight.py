"""Line of sight from the antenna to points: past the horizon, the maximum range, the body itself and all other bodies."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from radar_service.frames import Polar, distances_from_map
from radar_service.scene.body import Body
from radar_service.scene.poses import MAP_POSE, BodyPose, merged_mesh
from radar_service.trace.embree import RayCount
from radar_service.trace.moving_occluders import MovingOccluders
from radar_service.trace.occluder import Occluder, beyond_horizon
from radar_service.trace.shadow_sectors import shadow_sectors
from radar_service.types import Flags, Floats, Indices


class SurfacePoints(NamedTuple):
    """E points on surfaces: index of the body in the scene, triangle in its mesh (-1: the body counts as a point), and
    position (E, 3) on the map [m]."""

    body: Indices
    triangle: Indices
    position: Floats


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
        self._moving = MovingOccluders(bodies, earth_radius, without, rays)

    def visible(self, points: SurfacePoints, antenna: Floats, time: float, max_range: float, movers: bool = True) -> Flags:
        """Which points (E,) have a line of sight to the antenna (3,) at `time` [s].

        max_range: beyond it nothing is visible [m]; movers: whether bodies that move may occlude.
        """
        position = points.position
        distance, slant = distances_from_map(position, antenna, self.earth_radius)
        over = beyond_horizon(distance, position[:, 2], float(antenna[2]), self.earth_radius)
        visible: Flags = ~over & (slant < max_range)
        for occluder, pose, key, which in self._occluders(points, np.flatnonzero(visible), antenna, time, movers):
            left = which[visible[which]]
            own = self._resting[points.body[left]] if key is None else points.body[left] == key
            if own.any() or occluder.may_occlude(pose, antenna, position[left]):
                visible[left[self._occluded_by(occluder, pose, points, antenna, left, own)]] = False
        return visible

    def occluded(self, position: Floats, antenna: Floats, time: float, movers: bool = True) -> Flags:
        """Which positions (W, 3) on the map any body occludes from the antenna (3,) at `time` [s]; movers: as in `visible`."""
        occluded = np.zeros(len(position), dtype=np.bool_)
        if self._resting_occluder is not None:
            occluded |= self._resting_occluder.occludes(MAP_POSE, antenna, position)
        if movers:
            distance, _ = distances_from_map(position, antenna, self.earth_radius)
            for _, occluder, pose, behind in self._moving.before(position, distance, antenna, time):
                left = behind[~occluded[behind]]
                occluded[left] = occluder.occludes(pose, antenna, position[left])
        return occluded

    def resting_shadow_sector(self, antenna: Floats) -> tuple[float, float, float]:
        """The sector that bodies at rest may occlude: azimuth of its middle and half width [rad], ground distance of its start
        [m]; a half width of 0 where nothing rests."""
        if self._resting_occluder is None:
            return 0.0, 0.0, np.inf
        centre, radius = self._resting_occluder.sphere
        middle, half, begin = shadow_sectors(centre[None], np.array([radius]), antenna)
        return float(middle[0]), float(half[0]), float(begin[0])

    def shadowed(self, position: Floats, polar: Polar, antenna: Floats, time: float) -> Indices:
        """Indices of resting positions that a moving body occludes at `time` [s], each once.

        position: (E, 3), visible past all bodies at rest, by rising azimuth; polar: the same relative to the antenna (3,).
        """
        shadowed = [np.zeros(0, dtype=np.int64)]
        for _, occluder, pose, behind in self._moving.before(position, polar.distance, antenna, time):
            shadowed.append(behind[occluder.occludes(pose, antenna, position[behind])])
        return np.unique(np.concatenate(shadowed))

    def _occluders(
        self, points: SurfacePoints, which: Indices, antenna: Floats, time: float, movers: bool
    ) -> list[tuple[Occluder, BodyPose, int | None, Indices]]:
        """All that may occlude any of points `which` (W,) at `time` [s]: occluders, their poses, body indices (None: all bodies
        at rest), and indices of the points. The resting one comes first, but a mover that all points lie on comes before it,
        as it occludes most of itself."""
        result: list[tuple[Occluder, BodyPose, int | None, Indices]] = []
        if self._resting_occluder is not None:
            result.append((self._resting_occluder, MAP_POSE, None, which))
        if movers:
            position = points.position[which]
            distance, _ = distances_from_map(position, antenna, self.earth_radius)
            for key, occluder, pose, some in self._moving.before(position, distance, antenna, time):
                result.append((occluder, pose, key, which[some]))
        own = set(np.unique(points.body[which]).tolist())
        return sorted(result, key=lambda occluder: {occluder[2]} != own)

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
