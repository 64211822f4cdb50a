"""The occluders of all bodies that move, and which of them may occlude which points at an instant."""

from collections.abc import Collection, Iterator, Sequence
from copy import copy
from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics.result_cache import STEADY, ResultCache, Revision
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.trace.embree import RayCount
from radar_service.trace.occluder import Occluder
from radar_service.trace.shadow_sectors import ShadowSectors, points_behind, shadow_sectors
from radar_service.world.body import Body
from radar_service.world.poses import BodyPose, BodyPoses, PoseArrays
from radar_service.world.presence import Presences

SLOT = 0.5  # s of motion for which the bodies that may occlude one are first chosen together
INSTANTS = 8  # kept: threads may be some visibility steps apart, and the truth is asked for at instants of its own


class PosedOccluder(NamedTuple):
    """A moving occluder at an instant.

    key: index of the body in the scene.
    occluder: its triangles.
    pose: at the instant.
    points: (W,) indices of the points that it may occlude.
    """

    key: int
    occluder: Occluder
    pose: BodyPose
    points: Indices


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
        self._occluders = {
            i: Occluder(body.mesh, earth_radius, rays)
            for i, body in enumerate(bodies)
            if body.mesh is not None and not body.at_rest and i not in without
        }
        self.keys: Indices = np.array(list(self._occluders), dtype=np.int64)
        self._number = {key: n for n, key in enumerate(self._occluders)}
        self.presences = Presences(bodies)
        self.presence_time: float | None = None  # of presence, where it is not that of the poses
        middles = [bodies[i].middle for i in self._occluders]
        self._middle: Floats = np.array(middles).reshape(-1, 3)
        spheres = [occluder.sphere for occluder in self._occluders.values()]
        self._centre: Floats = np.array([centre for centre, _ in spheres]).reshape(-1, 3)
        self._radius: Floats = np.array([radius for _, radius in spheres])
        self._follow([bodies[i] for i in self._occluders], revision)

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

    def before(self, position: Floats, distance: Floats, antenna: Floats, time: float) -> Iterator[PosedOccluder]:
        """Those that may occlude any of the points (E, 3) on the map [m] from the antenna (3,) at `time` [s], and all that
        any point lies on. distance: of the points along the ground (E,) [m]."""
        if not len(self.keys):
            return
        poses, sectors = self._instants.get((time, antenna.tobytes()), lambda: self._at(antenna, time))
        azimuth = np.arctan2(position[:, 0] - antenna[0], position[:, 1] - antenna[1])
        present = self.present(time)
        for n, points in points_behind(sectors, azimuth, distance):
            key = int(self.keys[n])
            if present[key]:
                yield PosedOccluder(key, self._occluders[key], poses.of_body(0, n), points)

    def occluder(self, key: int, time: float) -> Occluder | None:
        """The occluder of body `key`; None of one that rests, or never occludes, or is absent at `time` [s]."""
        return self._occluders[key] if key in self._number and self.present(time)[key] else None

    def chosen(self, keys: Collection[int], time: float) -> list[tuple[Occluder, BodyPose, int]]:
        """Those of the bodies `keys` that move and are present: occluder, pose at `time` [s], and index of the body."""
        present = self.present(time)
        moving = [key for key in keys if key in self._number and present[key]]
        if not moving:
            return []
        poses = self._poses.at(np.array([time]), np.array([self._number[key] for key in moving]))
        return [(self._occluders[key], poses.of_body(0, self._number[key]), key) for key in moving]

    def sectors(self, antenna: Floats, time: float) -> ShadowSectors:
        """The sectors (N,) that the bodies may occlude from the antenna (3,) at `time` [s], as if all were present."""
        return self._instants.get((time, antenna.tobytes()), lambda: self._at(antenna, time))[1]

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
        other._follow([bodies[i] for i in self._occluders], revision)
        return other

    def _follow(self, bodies: Sequence[Body], revision: Revision) -> None:
        """Follows the motions of those `bodies` (N,) that have occluders; revision: of these motions."""
        self._poses = BodyPoses(bodies)
        swing = 2.0 * np.hypot(self._middle[:, 0], self._middle[:, 1])  # m, by which turns move a middle at most
        self._strays: Floats = np.array([body.top_speed for body in bodies]) * (SLOT / 2.0) + swing
        self._instants: ResultCache[tuple[float, bytes], tuple[PoseArrays, ShadowSectors]] = ResultCache(INSTANTS, revision)
        self._middles: ResultCache[int, Floats] = ResultCache(INSTANTS, revision)

    def _at(self, antenna: Floats, time: float) -> tuple[PoseArrays, ShadowSectors]:
        poses = self._poses.at(np.array([time]))
        centre = poses.map_from_bodies(0, self._centre, np.arange(len(self.keys)))
        return poses, shadow_sectors(centre, self._radius, antenna)
