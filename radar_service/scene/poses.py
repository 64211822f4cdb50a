"""Where many bodies stand at many instants: those at rest are asked once, those on a straight course all together."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import wrap_bearing
from radar_service.scene.world import Body
from radar_service.trace.occluder import BodyPose

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class PoseArrays(NamedTuple):
    """B bodies at K instants: position (K, B, 3) [m], heading (K, B) [rad]."""

    position: Floats
    heading: Floats


class BodyPoses:
    """The motions of bodies (B,), in order."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._motions = [body.motion for body in bodies]
        self.moving: Indices = np.array([b for b, m in enumerate(self._motions) if not m.at_rest], dtype=np.int64)
        self._bent = {int(b) for b in self.moving if len(self._motions[b].time) > 1}
        self._position = np.array([m.position[0] for m in self._motions]).reshape(-1, 3)
        self._heading = wrap_bearing(np.array([m.heading[0] for m in self._motions])).reshape(-1)
        self._velocity = np.array([self._motions[b].final_velocity for b in self.moving]).reshape(-1, 3)
        self._start = np.array([self._motions[b].time[0] for b in self.moving])

    def stands(self, time: Floats, asked: Indices | None = None) -> PoseArrays:
        """Where bodies stand at each time (K,) [s]: those `asked` for (N,), all by default; the others somewhere."""
        position = np.repeat(self._position[None], len(time), axis=0)
        heading = np.repeat(self._heading[None], len(time), axis=0)
        if len(self.moving):
            since = np.maximum(time[:, None] - self._start, 0.0)
            position[:, self.moving] += since[:, :, None] * self._velocity
        for b in self._bent if asked is None else (b for b in asked if b in self._bent):
            pose = self._motions[b].pose(time)
            position[:, b], heading[:, b] = pose.position, pose.heading
        return PoseArrays(position, heading)

    def poses_at(self, time: float) -> list[BodyPose]:
        """Where each body stands at `time` [s]."""
        stands = self.stands(np.array([time]))
        return [
            BodyPose(place, heading) for place, heading in zip(stands.position[0], stands.heading[0].tolist(), strict=True)
        ]


def pose_at(body: Body, time: float) -> BodyPose:
    """Where one body stands at `time` [s]."""
    pose = body.motion.pose(time)
    return BodyPose(pose.position[0], float(pose.heading[0]))


def placed_at(points: Floats, body: Indices, position: Floats, heading: Floats) -> Floats:
    """Points (E, 3) [m] of bodies' own frames, each of `body` (E,), on the map, for positions (B, 3) [m] and
    headings (B,) [rad] of the bodies."""
    c, s = np.cos(heading)[body], np.sin(heading)[body]
    east, north, up = points.T
    turned = np.stack([c * east + s * north, c * north - s * east, up], axis=-1)
    turned += position[body]
    return turned
