"""The occluders of all bodies that move, and which of them may occlude which points at an instant."""

from collections.abc import Callable, Collection, Iterator, Sequence
from copy import copy
from typing import Self

import numpy as np

from radar_service.numerics import STEADY, Flags, Floats, Indices, ResultCache, Revision
from radar_service.trace.embree import RayCount
from radar_service.trace.occluder import Occluder
from radar_service.trace.posed_occluders import OccluderKinds, PosedOccluders
from radar_service.trace.shadow_sectors import ShadowSectors, points_behind, shadow_sectors, top_slopes
from radar_service.world import Body, BodyPose, BodyPoses, PoseArrays, Presences

FEW_BODIES = 32  # bodies whose pairs with points take less time than to look which of these lie over them
SLOT = 0.5  # s of motion for which the bodies that may occlude one are first chosen together
INSTANTS = 8  # kept: threads may be some visibility steps apart, and the truth is asked for at instants of its own


class MovingOccluders:
    """One occluder for each mesh that moves, or comes and goes. Safe to call from several threads.

    keys: (N,) indices of their bodies in the scene, rising.
    presences: of all bodies of the scene.
    """

    def __init__(
        self, bodies: Sequence[Body], earth_radius: float, without: Collection[int] = (), rays: RayCount | None = None,
        revision: Revision = STEADY,
    ) -> None:  # fmt: skip
        """Arguments as `OcclusionScene`."""
        keys = [i for i, body in enumerate(bodies) if body.mesh is not None and not body.at_rest and i not in without]
        meshes = {id(body.mesh): body.mesh for body in (bodies[i] for i in keys) if body.mesh is not None}
        of_mesh = {number: Occluder(mesh, earth_radius, rays) for number, mesh in meshes.items()}
        self._kinds, self._earth_radius = OccluderKinds.of([of_mesh[id(bodies[i].mesh)] for i in keys]), earth_radius
        self.keys: Indices = np.array(keys, dtype=np.int64)
        self._number: Indices = np.full(len(bodies), -1)
        self._number[self.keys] = np.arange(len(self.keys))
        self.presences = Presences(bodies)
        self.presence_time: float | None = None  # of presence, where it is not that of the poses
        self._middle: Floats = np.array([bodies[i].middle for i in keys]).reshape(-1, 3)
        self._follow([bodies[i] for i in keys], revision)

    def as_of(self, time: float) -> Self:
        """The same where those bodies are present that are at `time` [s], whatever the instant of their poses."""
        if not len(self.presences.changing):
            return self
        view = copy(self)
        view.presence_time = time
        return view

    def present(self, time: float) -> Flags:
        """Which bodies (B,) of the scene are present at `time` [s], or at that of `as_of`."""
        return self.presences.at(time if self.presence_time is None else self.presence_time)

    def occluded(self, position: Floats, distance: Floats, antenna: Floats, time: float) -> Flags:
        """Which points (E, 3) on the map [m] any of them occludes from the antenna (3,) at `time` [s].

        distance: of the points along the ground (E,) [m].
        """
        occluded = np.zeros(len(position), dtype=np.bool_)
        posed = self._posed(antenna, time)
        for body, point in self._behind(position, distance, antenna, time, straight=True):
            occluded[point[posed.occluded(body, antenna, position.take(point, axis=0))]] = True
        return occluded

    def occluded_surfaces(
        self,
        key: Indices,
        position: Floats,
        distance: Floats,
        triangles: Callable[[Indices], tuple[Indices, Indices]],
        reflection: Floats | None,
        antenna: Floats,
        time: float,
    ) -> Flags:
        """Which points (E, 3) on surfaces of bodies any of them occludes, their own among these.

        key: (E,) indices of the points' bodies in the scene; distance: (E,) along the ground [m]; triangles: first and last
        (exclusive) one (W,) that never occlude points (W,); reflection: (E, 3) points of the sea [m], None for the direct ray.
        """
        occluded, posed = np.zeros(len(position), dtype=np.bool_), self._posed(antenna, time)
        number = self._number[key]
        own = np.flatnonzero((number >= 0) & self.present(time)[key])
        origin = _origins(antenna, reflection, own)
        occluded[own] = posed.self_occluded(number[own], origin, position.take(own, axis=0), triangles(own))
        left = np.flatnonzero(~occluded)
        straight = reflection is None
        for body, some in self._behind(position.take(left, axis=0), distance[left], antenna, time, straight):
            point = left[some]
            if reflection is not None:
                occluded[point[posed.occluded(body, antenna, reflection.take(point, axis=0))]] = True
            other = np.flatnonzero((body != number[point]) & ~occluded[point])
            body, point = body[other], point[other]
            hidden = posed.occluded(body, _origins(antenna, reflection, point), position.take(point, axis=0))
            occluded[point[hidden]] = True
        return occluded

    def _behind(
        self, position: Floats, distance: Floats, antenna: Floats, time: float, straight: bool
    ) -> Iterator[tuple[Indices, Indices]]:
        """Pairs (P,) of the number of a body present at `time` [s] and a point that it may occlude, some at a time.

        distance: along the ground (E,) [m]; straight: whether lines of sight are straight, or go by the sea.
        """
        if not len(self.keys):
            return
        azimuth = np.arctan2(position[:, 0] - antenna[0], position[:, 1] - antenna[1])
        present = self.present(time)[self.keys]
        slopes = self._slopes(position, distance, antenna, time) if straight and len(self.keys) > FEW_BODIES else None
        for body, point in points_behind(self.sectors(antenna, time), azimuth, distance, slopes):
            kept = np.flatnonzero(present[body])
            yield (body, point) if len(kept) == len(body) else (body[kept], point[kept])

    def _slopes(self, position: Floats, distance: Floats, antenna: Floats, time: float) -> tuple[Floats, Floats]:
        """`top_slopes` of all bodies (N,), and slopes of the lines of sight to points (E,)."""
        posed, earth = self._posed(antenna, time), self._earth_radius
        centre = posed.poses.map_from_bodies(0, self._kinds.centre, np.arange(len(self.keys)))
        tops = top_slopes(centre, self._kinds.radius, self._kinds.tops(posed.poses), antenna, earth)
        return tops, (position[:, 2] - antenna[2]) / np.maximum(distance, 1e-9) - distance / (2.0 * earth)

    def _posed(self, antenna: Floats, time: float) -> PosedOccluders:
        """All of them at `time` [s]."""
        poses = self._instant(antenna, time)[0]
        return PosedOccluders(self._kinds, poses, self._earth_radius)

    def poses_of(self, keys: Collection[int], time: float) -> dict[int, BodyPose]:
        """Poses at `time` [s] of those bodies of `keys` that move and are present."""
        present = self.present(time)
        moving = [key for key in keys if self._number[key] >= 0 and present[key]]
        if not moving:
            return {}
        numbers = self._number[moving]
        poses = self._poses.at(np.array([time]), numbers)
        return {key: poses.of_body(0, n) for key, n in zip(moving, numbers.tolist(), strict=True)}

    def sectors(self, antenna: Floats, time: float) -> ShadowSectors:
        """The sectors (N,) that the bodies may occlude from the antenna (3,) at `time` [s], as if all were present."""
        return self._instant(antenna, time)[1]

    def middles(self, time: float, some: Indices) -> Floats:
        """Middles (M, 2) of the plans of bodies, by their numbers (M,) in `keys`, on the map at `time` [s]."""
        return self._poses.at(np.array([time]), some).map_from_bodies(0, self._middle[some], some)[:, :2]

    def near_middles(self, time: float) -> tuple[Floats, Floats]:
        """Middles (N, 2) of the plans of all bodies at about `time` [s], and how far each may be from there then (N,) [m]."""
        slot = int(time // SLOT)
        middles = self._middles.get(slot, lambda: self.middles((slot + 0.5) * SLOT, np.arange(len(self.keys))))
        return middles, self._strays

    def following(self, bodies: Sequence[Body], revision: Revision = STEADY) -> Self:
        """The same occluders, moving as other `bodies` of the scene do. revision: of their motions."""
        other = copy(self)
        other.presences = Presences(bodies)
        other._follow([bodies[i] for i in self.keys.tolist()], revision)
        return other

    def _follow(self, bodies: Sequence[Body], revision: Revision) -> None:
        """Follows the motions of those `bodies` (N,) that have occluders; revision: of these motions."""
        self._poses = BodyPoses(bodies)
        swing = 2.0 * np.hypot(self._middle[:, 0], self._middle[:, 1])  # m, by which turns move a middle at most
        self._strays: Floats = np.array([body.top_speed for body in bodies]) * (SLOT / 2.0) + swing
        self._instants: ResultCache[tuple[float, bytes], tuple[PoseArrays, ShadowSectors]] = ResultCache(INSTANTS, revision)
        self._middles: ResultCache[int, Floats] = ResultCache(INSTANTS, revision)

    def _instant(self, antenna: Floats, time: float) -> tuple[PoseArrays, ShadowSectors]:
        """Poses and sectors at `time` [s] for an antenna (3,)."""
        return self._instants.get((time, antenna.tobytes()), lambda: self._at(antenna, time))

    def _at(self, antenna: Floats, time: float) -> tuple[PoseArrays, ShadowSectors]:
        """Computes `_instant`."""
        poses = self._poses.at(np.array([time]))
        centre = poses.map_from_bodies(0, self._kinds.centre, np.arange(len(self.keys)))
        return poses, shadow_sectors(centre, self._kinds.radius, antenna)


def _origins(antenna: Floats, reflection: Floats | None, which: Indices) -> Floats:
    """Where the last straight line to points `which` (W,) begins: the antenna (3,), or the sea (W, 3)."""
    return antenna if reflection is None else reflection.take(which, axis=0)
