"""The truth: where own ship and every body are at an instant, and whether the antenna can see them."""

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.second_time_around import apparent_range
from radar_service.frames import map_from_body, polar_from_map, wrap_bearing
from radar_service.records import BodyTruth, Truth
from radar_service.scene.geo import geographic_from_map
from radar_service.scene.world import Body, Pose, Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.occluder import beyond_horizon

Floats = NDArray[np.float64]
WITNESSES = 64  # points of a body's surface that are looked for


class GroundTruth:
    """Answers for any instant, from any thread."""

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self.scene, self.line_of_sight, self.earth_radius = scene, line_of_sight, line_of_sight.earth_radius
        self._surface_samples = [_surface_samples(body) for body in scene.bodies]

    def at(self, time: float) -> Truth:
        """Own ship and every body at `time` [s]."""
        scene = self.scene
        antenna = scene.antenna(time)[0]
        own = scene.own_ship.pose(time)
        bodies = tuple(
            self._body(body, witnesses, antenna, time)
            for body, witnesses in zip(scene.bodies, self._surface_samples, strict=True)
        )
        return Truth(time, self._record("own ship", own, antenna, "", None), bodies)

    def _body(self, body: Body, witnesses: Floats, antenna: Floats, time: float) -> BodyTruth:
        pose = body.motion.pose(time)
        places = map_from_body(witnesses, pose.position[0], float(pose.heading[0]))
        return self._record(body.name, pose, antenna, self._why_unseen(places, antenna, time), body.mmsi)

    def _why_unseen(self, places: Floats, antenna: Floats, time: float) -> str:
        """Why none of the places (W, 3) is seen from the antenna; "" where one is."""
        polar = polar_from_map(places, antenna, self.earth_radius)
        near = apparent_range(self.scene.radar, polar.range) <= self.scene.radar.range_max
        if not near.any():
            return "beyond range"
        over = beyond_horizon(polar.distance, places[:, 2], float(antenna[2]), self.earth_radius)
        if not (near & ~over).any():
            return "below horizon"
        lit = ~self.scene.blind(np.full(len(places), time), polar.azimuth)
        if not (near & ~over & lit).any():
            return "blind sector"
        candidates = places[near & ~over & lit]
        return "shadowed" if self.line_of_sight.occluded(candidates, antenna, time).all() else ""

    def _record(self, name: str, pose: Pose, antenna: Floats, reason: str, mmsi: int | None) -> BodyTruth:
        position = pose.position[0]
        polar = polar_from_map(position, antenna, self.earth_radius)
        latitude, longitude = None, None
        if self.scene.origin is not None:
            latitude, longitude = (float(v) for v in geographic_from_map(position, self.scene.origin))
        return BodyTruth(
            name, _triple(position), _triple(pose.velocity[0]),
            float(pose.heading[0]), float(pose.course[0]), float(pose.speed[0]), float(polar.range),
            float(wrap_bearing(polar.azimuth)), float(polar.elevation), not reason, reason, latitude, longitude, mmsi,
        )  # fmt: skip


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])


def _surface_samples(body: Body) -> Floats:
    """Points (W, 3) on the body, in its own frame [m]: every so many-th vertex that a face uses."""
    if body.mesh is None:
        return np.zeros((1, 3))
    used = np.unique(body.mesh.faces)
    return body.mesh.vertices[used[:: max(1, len(used) // WITNESSES)]]
