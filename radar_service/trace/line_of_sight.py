"""Line of sight from the antenna to points, directly or by the sea: past the horizon, the maximum range, the body itself and
all other bodies."""

from collections.abc import Collection, Sequence
from copy import copy
from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics import STEADY, Flags, Floats, Indices, ResultCache, Revision, distances_from_map
from radar_service.trace.embree import RayCount
from radar_service.trace.land_mask import LandMask
from radar_service.trace.moving_occluders import MovingOccluders
from radar_service.trace.occluder import Occluder, beyond_horizon
from radar_service.trace.shadow_sectors import ShadowSectors, on_the_way, shadow_sectors
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world import MAP_POSE, Body, BodyPose, Presences, is_ground, merged_mesh, pose_at


class SurfacePoints(NamedTuple):
    """E points on surfaces: index of the body in the scene, triangle in its mesh (-1: the body counts as a point), and
    position (E, 3) on the map [m]."""

    body: Indices
    triangle: Indices
    position: Floats


class OcclusionScene:
    """All that may occlude: one occluder for all bodies at rest, and one for each mesh that moves. Absent bodies do not."""

    def __init__(
        self, bodies: Sequence[Body], earth_radius: float, without: Collection[int] = (), rays: RayCount | None = None,
        revision: Revision = STEADY,
    ) -> None:  # fmt: skip
        """earth_radius: effective, inf for flat [m]; without: indices of moving bodies that never occlude, not even
        themselves; rays: counts the rays cast, where given; revision: of the bodies' motions."""
        self.earth_radius = earth_radius
        self._resting: Flags = np.array([body.at_rest for body in bodies], dtype=np.bool_)
        occludes = [body.mesh is not None and i not in without for i, body in enumerate(bodies)]
        self._occludes: Flags = np.array(occludes, dtype=np.bool_)
        self._plan = np.array([[*body.middle_at(0.0)[:2], body.radius] for body in bodies]).reshape(-1, 3)
        self._speed = np.array([body.top_speed for body in bodies])
        faces = [0 if body.mesh is None else len(body.mesh.faces) for body in bodies]
        self._faces: Indices = np.array(faces, dtype=np.int64)
        resting_faces = np.where(self._resting, self._faces, 0)
        self._first_face = np.cumsum(resting_faces) - resting_faces  # of each body in the merged mesh
        merged = merged_mesh([body for body in bodies if body.at_rest])
        self._resting_occluder = None if merged is None else Occluder(merged, earth_radius, rays)
        self.moving = MovingOccluders(bodies, earth_radius, without, rays, revision)
        self._bodies, self.revision = tuple(bodies), revision
        self._triangles: ResultCache[int, TriangleClusters] = ResultCache(max(1, len(bodies)))
        self._land: ResultCache[None, LandMask | None] = ResultCache(1)

    @property
    def land(self) -> LandMask | None:
        """The land that always rests, as a mask that is made when it is first asked for; None without any."""
        return self._land.get(None, lambda: LandMask.of(self._bodies))

    @property
    def presences(self) -> Presences:
        """The presence of all bodies."""
        return self.moving.presences

    def as_of(self, time: float) -> Self:
        """The same where those bodies are present that are at `time` [s], whatever the instant of their poses."""
        moving = self.moving.as_of(time)
        if moving is self.moving:
            return self
        view = copy(self)
        view.moving = moving
        return view

    def present(self, time: float) -> Flags:
        """Which bodies (B,) are present at `time` [s], or at that of `as_of`."""
        return self.moving.present(time)

    def visible(
        self, points: SurfacePoints, antenna: Floats, time: float, max_range: float, movers: bool = True,
        over_horizon: float = 0.0, reflection: Floats | None = None,
    ) -> Flags:  # fmt: skip
        """Which points (E,) have a line of sight to the antenna (3,) at `time` [s].

        max_range: beyond it nothing is visible [m]; movers: whether bodies that move may occlude; over_horizon: height up to
        which fields reach beyond the horizon [m]; reflection: (E, 3) of the rays on the sea [m], None: direct ones.
        """
        position = points.position
        distance, slant = distances_from_map(position, antenna, self.earth_radius)
        over = beyond_horizon(distance, position[:, 2], float(antenna[2]), self.earth_radius, over_horizon)
        visible: Flags = ~over & (slant < max_range)
        left, occluder = np.flatnonzero(visible), self._resting_occluder
        own = self._resting[points.body[left]]
        if occluder is not None and (own.any() or occluder.may_occlude(MAP_POSE, antenna, position[left])):
            origin = antenna
            if reflection is not None:
                hidden = occluder.occludes(MAP_POSE, antenna, reflection.take(left, axis=0))
                visible[left[hidden]] = False
                left, own = left[~hidden], own[~hidden]
                origin = reflection.take(left, axis=0)
            visible[left[self._occluded_by(occluder, points, origin, left, own)]] = False
        if movers and self.has_movers:
            left = np.flatnonzero(visible)
            body, place = points.body[left], position.take(left, axis=0)
            foot = None if reflection is None else reflection.take(left, axis=0)
            args = body, place, distance[left], lambda own: self._own_triangles(points, left[own]), foot, antenna, time
            hidden = self.moving.occluded_surfaces(*args)
            visible[left] = ~hidden
        return visible

    def visible_by_sea(
        self, points: SurfacePoints, reflection: Floats, antenna: Floats, time: float, max_range: float
    ) -> Flags:
        """Which points (E,) the antenna (3,) observes by rays that the sea reflects at `reflection` (E, 3) on the map [m].

        Other arguments as `visible`. Both ways are straight lines: from the antenna to the sea, where land or a hull may stand in
        its place, and on to the point.
        """
        return self.visible(points, antenna, time, max_range, reflection=reflection)

    def occludes_itself(self, body: Indices, time: float, movers: bool = True) -> Flags:
        """Which of bodies (B,) their own parts occlude at `time` [s]; movers: whether moving ones do."""
        return np.asarray((self._occludes & self.present(time))[body] & (movers | self._resting[body]))

    def other_occluders(
        self, body: int, antenna: Floats, time: float, movers: bool = True, span: float = 0.0, own_speed: float = 0.0
    ) -> list[int]:
        """The other bodies that may occlude a body from the antenna (3,), by a quick test in plan. span: how long before and
        after they may, present at `time` or not [s], while the antenna moves at `own_speed` [m/s]."""
        plan, moved = self._plan, span * (self._speed + self._speed[body] + own_speed)
        near = self._occludes & (movers | self._resting) & (self.present(time) | (span > 0.0))
        if len(self.moving.keys):
            plan, strays = plan.copy(), np.zeros(len(plan))
            plan[self.moving.keys, :2], strays[self.moving.keys] = self.moving.near_middles(time)
            near &= on_the_way(plan, body, antenna[:2], moved + strays + strays[body])
            exactly = np.flatnonzero(near[self.moving.keys] | (self.moving.keys == body))
            plan[self.moving.keys[exactly], :2] = self.moving.middles(time, exactly)
        near &= on_the_way(plan, body, antenna[:2], moved)
        return np.flatnonzero(near).tolist()

    def posed_triangles(self, bodies: Sequence[int], time: float) -> list[tuple[TriangleClusters, BodyPose]]:
        """The triangles of bodies with meshes and their poses at `time` [s], present or not."""
        poses = self.moving.poses_of(bodies, time)
        return [(self._triangles_of(key), poses.get(key) or pose_at(self._bodies[key], time)) for key in bodies]

    def _triangles_of(self, key: int) -> TriangleClusters:
        """The triangles of a body with a mesh, in clusters that are made when they are needed first."""
        body = self._bodies[key]
        assert body.mesh is not None
        mesh = body.mesh
        return self._triangles.get(key, lambda: TriangleClusters(mesh, is_ground(body)))

    def following(self, bodies: Sequence[Body], revision: Revision = STEADY) -> Self:
        """The same occluders, moving as other `bodies` of the scene do. revision: of their motions."""
        other = copy(self)
        other._bodies, other._speed = tuple(bodies), np.array([body.top_speed for body in bodies])
        other.revision, other.moving = revision, self.moving.following(bodies, revision)
        return other

    @property
    def has_movers(self) -> bool:
        """Whether a body that moves may occlude anything."""
        return len(self.moving.keys) > 0

    def occluded_by_resting(self, position: Floats, antenna: Floats) -> Flags:
        """Which positions (W, 3) on the map a body at rest occludes from the antenna (3,), or from one each (W, 3)."""
        if self._resting_occluder is None:
            return np.zeros(len(position), dtype=np.bool_)
        return self._resting_occluder.occludes(MAP_POSE, antenna, position)

    def occluded_by_moving(self, position: Floats, antenna: Floats, time: float) -> Flags:
        """Which positions (W, 3) on the map a moving body occludes from the antenna (3,) at `time` [s]."""
        distance, _ = distances_from_map(position, antenna, self.earth_radius)
        return self.moving.occluded(position, distance, antenna, time)

    def resting_shadow_sector(self, antenna: Floats) -> ShadowSectors:
        """The one sector that bodies at rest may occlude; of half width 0, and begun at infinity, where nothing rests."""
        if self._resting_occluder is None:
            return ShadowSectors(np.zeros(1), np.zeros(1), np.full(1, np.inf))
        centre, radius = self._resting_occluder.sphere
        return shadow_sectors(centre[None], np.array([radius]), antenna)

    def moving_shadow_sectors(self, antenna: Floats, time: float) -> ShadowSectors:
        """The sectors that the moving bodies may occlude at `time` [s], as if all were present."""
        return self.moving.sectors(antenna, time)

    def _occluded_by(self, occluder: Occluder, points: SurfacePoints, origin: Floats, which: Indices, own: Flags) -> Flags:
        """Of points `which` (W,), those that bodies at rest occlude from an origin (3,), or from one each (W, 3); `own` (W,)
        flags points on one of these."""
        occluded = np.zeros(len(which), dtype=np.bool_)
        for some, on_it in ((np.flatnonzero(own), True), (np.flatnonzero(~own), False)):
            if not len(some):
                continue
            begin, place = origin if origin.ndim == 1 else origin[some], points.position.take(which[some], axis=0)
            if on_it:
                occluded[some] = occluder.self_occluded(MAP_POSE, begin, place, self._own_triangles(points, which[some]))
            else:
                occluded[some] = occluder.occludes(MAP_POSE, begin, place)
        return occluded

    def _own_triangles(self, points: SurfacePoints, which: Indices) -> tuple[Indices, Indices]:
        """First and last triangle (exclusive) that cannot occlude each point: its own one, or all of a point-like body."""
        key, triangle = points.body[which], points.triangle[which]
        first = np.where(self._resting, self._first_face, 0)[key]
        on_triangle = triangle >= 0
        last = np.where(on_triangle, first + triangle + 1, first + self._faces[key])
        return first + np.where(on_triangle, triangle, 0), last
