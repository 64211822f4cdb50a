"""Ground truth: the state of own ship and of every body at an instant, and whether the antenna has a line of sight to it."""

import numpy as np

from radar_service.echo.second_time_around import apparent_range
from radar_service.frames import map_from_body, polar_from_map, wrap_bearing
from radar_service.records import BodyTruth, Truth
from radar_service.scene.body import Body
from radar_service.scene.geo import geographic_from_map
from radar_service.scene.motion import Pose
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.occluder import beyond_horizon
from radar_service.types import Floats

SURFACE_SAMPLES = 64  # points of a body's surface whose visibility is tested
REASONS = ("beyond range", "below horizon", "blind sector", "shadowed", "")  # by how many tests a body passes, in this order


class GroundTruth:
    """The truth of a scene at any instant. Safe to call from several threads."""

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self.scene, self.line_of_sight, self.earth_radius = scene, line_of_sight, line_of_sight.earth_radius
        self._surface_samples = [_surface_samples(body) for body in scene.bodies]

    def at(self, time: float) -> Truth:
        """Own ship and every body at `time` [s]."""
        scene = self.scene
        antenna = scene.antenna(time)[0]
        own = scene.own_ship.pose(time)
        poses = [body.motion.pose(time) for body in scene.bodies]
        samples = zip(self._surface_samples, poses, strict=True)
        positions = [map_from_body(points, pose.position[0], float(pose.heading[0])) for points, pose in samples]
        reasons = self._why_invisible(positions, antenna, time)
        bodies = tuple(
            self._record(body.name, pose, antenna, reason, body.mmsi, body.arm)
            for body, pose, reason in zip(scene.bodies, poses, reasons, strict=True)
        )
        return Truth(time, self._record("own ship", own, antenna, "", None, 0.0), bodies)

    def _why_invisible(self, positions: list[Floats], antenna: Floats, time: float) -> list[str]:
        """For each body the reason why none of its positions (W, 3) is visible; "" where one is."""
        if not positions:
            return []
        point = np.concatenate(positions)
        polar = polar_from_map(point, antenna, self.earth_radius)
        near = apparent_range(self.scene.radar, polar.range) <= self.scene.radar.range_max
        over = beyond_horizon(polar.distance, point[:, 2], float(antenna[2]), self.earth_radius)
        lit = near & ~over & ~self.scene.blind(np.full(len(point), time), polar.azimuth)
        visible = lit.copy()
        visible[lit] = ~self.line_of_sight.occluded(point[lit], antenna, time)
        first = np.cumsum([0, *(len(own) for own in positions[:-1])])
        passed = [np.logical_or.reduceat(flags, first) for flags in (near, near & ~over, lit, visible)]
        return [REASONS[count] for count in np.sum(passed, axis=0).tolist()]

    def _record(self, name: str, pose: Pose, antenna: Floats, reason: str, mmsi: int | None, extent: float) -> BodyTruth:
        position = pose.position[0]
        polar = polar_from_map(position, antenna, self.earth_radius)
        latitude, longitude = None, None
        if self.scene.origin is not None:
            latitude, longitude = (float(v) for v in geographic_from_map(position, self.scene.origin))
        return BodyTruth(
            name, _triple(position), _triple(pose.velocity[0]),
            float(pose.heading[0]), float(pose.course[0]), float(pose.speed[0]), float(polar.range),
            float(wrap_bearing(polar.azimuth)), float(polar.elevation), not reason, reason, latitude, longitude, mmsi,
            float(extent),
        )  # fmt: skip


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])


def _surface_samples(body: Body) -> Floats:
    """Points (W, 3) on the body, in its own frame [m]: about SURFACE_SAMPLES of the vertices that faces use."""
    if body.mesh is None:
        return np.zeros((1, 3))
    used = np.unique(body.mesh.faces)
    return body.mesh.vertices[used[:: max(1, len(used) // SURFACE_SAMPLES)]]
