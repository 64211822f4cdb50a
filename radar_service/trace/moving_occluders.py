"""The occluders of all bodies that move, and which of them may occlude which points at an instant."""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from radar_service.block_cache import BlockCache
from radar_service.scene.body import Body
from radar_service.scene.poses import BodyPose, BodyPoses, PoseArrays, map_from_bodies
from radar_service.trace.embree import RayCount
from radar_service.trace.occluder import Occluder
from radar_service.trace.shadow_sectors import ShadowSectors, points_behind, shadow_sectors
from radar_service.types import Floats, Indices

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
    """One occluder for each mesh that moves. Safe to call from several threads."""

    def __init__(
        self, bodies: Sequence[Body], earth_radius: float, without: Collection[int] = (), rays: RayCount | None = None
    ) -> None:
        """Arguments as `OcclusionScene`."""
        self._occluders = {
            i: Occluder(body.mesh, earth_radius, rays)
            for i, body in enumerate(bodies)
            if body.mesh is not None and not body.motion.at_rest and i not in without
        }
        self._keys = list(self._occluders)
        self._poses = BodyPoses([bodies[i] for i in self._keys])
        spheres = [occluder.sphere for occluder in self._occluders.values()]
        self._centre: Floats = np.array([centre for centre, _ in spheres]).reshape(-1, 3)
        self._radius: Floats = np.array([radius for _, radius in spheres])
        self._instants: BlockCache[tuple[float, bytes], tuple[PoseArrays, ShadowSectors]] = BlockCache(INSTANTS)

    def before(self, position: Floats, distance: Floats, antenna: Floats, time: float) -> Iterator[PosedOccluder]:
        """Those that may occlude any of the points (E, 3) on the map [m] from the antenna (3,) at `time` [s], and all that
        any point lies on. distance: of the points along the ground (E,) [m]."""
        if not self._keys:
            return
        poses, sectors = self._instants.get((time, antenna.tobytes()), lambda: self._at(antenna, time))
        azimuth = np.arctan2(position[:, 0] - antenna[0], position[:, 1] - antenna[1])
        for n, points in points_behind(sectors, azimuth, distance):
            key, pose = self._keys[n], BodyPose(poses.position[0, n], float(poses.heading[0, n]))
            yield PosedOccluder(key, self._occluders[key], pose, points)

    def _at(self, antenna: Floats, time: float) -> tuple[PoseArrays, ShadowSectors]:
        poses = self._poses.at(np.array([time]))
        centre = map_from_bodies(self._centre, np.arange(len(self._keys)), poses.position[0], poses.heading[0])
        return poses, shadow_sectors(centre, self._radius, antenna)
