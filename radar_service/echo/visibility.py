"""Visibility of moving bodies: what the antenna has a line of sight to, renewed at fixed instants of simulated time."""

from dataclasses import dataclass, field, replace

import numpy as np

from radar_service.block_cache import BlockCache
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.frames import wrap_angle
from radar_service.scattering.model import BodyEchoes, Instant, Sector
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.scene.poses import BodyPoses, map_from_bodies
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Floats, Indices

MAX_BEARING_DRIFT = 0.05  # rad that echoes which are not near may leave their bearing of the middle of a step
SNAPSHOTS = 4  # kept: threads may be this many steps apart before one is computed again


@dataclass(frozen=True)
class VisibilitySnapshot(ObservedEchoes):
    """All visible echoes (M,) of moving bodies for one visibility step; positions are those of the middle of the step.

    Bodies whose echoes depend on aspect are evaluated as the beam passes instead (`echo.beam_passage`).

    order: indices of the echoes that are not near, by rising azimuth.
    azimuth: their azimuths, in that order [rad].
    near: indices of the others, which may have any azimuth.
    """

    order: Indices = field(kw_only=True)
    azimuth: Floats = field(kw_only=True)
    near: Indices = field(kw_only=True)

    def around(self, boresight: float, half: float) -> Indices:
        """Indices of all echoes that may lie within `half` of `boresight` [rad]."""
        if half >= np.pi:
            return np.arange(len(self.position))
        edges = wrap_angle(np.array([boresight - half, boresight + half]))
        first, last = np.searchsorted(self.azimuth, edges)
        inside = [self.order[first:last]] if edges[0] <= edges[1] else [self.order[first:], self.order[:last]]
        return np.concatenate([self.near, *inside])


class Visibility:
    """The visibility snapshots of a scene's moving bodies. Safe to call from several threads."""

    def __init__(
        self, scene: Scene, scatterers: ScattererSet, line_of_sight: OcclusionScene, max_range: float, step: float
    ) -> None:
        """max_range: beyond it no echo is received [m]; step: how far anything may move before visibility and scattering are
        renewed [m]."""
        self.scatterers, self.line_of_sight, self.max_range = scatterers, line_of_sight, max_range
        self.interval = visibility_interval(scene, step)
        self._scene, self._step = scene, step
        self._poses = BodyPoses(scatterers.bodies)
        self._movers = len(line_of_sight.moving_shadow_sectors(scene.antenna(0.0)[0], 0.0).middle) > 0
        sway = scene.own_ship.sway
        self.bearing_drift = MAX_BEARING_DRIFT + (0.0 if sway is None else float(sway.amplitude[:2].sum()))
        self._snapshots: BlockCache[int, VisibilitySnapshot] = BlockCache(SNAPSHOTS)

    def snapshot(self, number: int, half: float) -> VisibilitySnapshot:
        """The snapshot of the visibility step of that number, within `half` [rad] of all boresights meanwhile."""
        return self._snapshots.get(number, lambda: self._computed(number, half))

    def all_round(self, number: int) -> BodyEchoes:
        """All visible echoes in the middle of the step of that number, wherever the beam points, those by aspect among them."""
        return self.scatterers.echoes(*self.observed_at(number))

    def observed_at(self, number: int) -> tuple[Floats, Instant]:
        """The antenna (3,) on the map [m] and the instant in the middle of the step of that number."""
        time = self._middle(number)
        return self._scene.antenna(time)[0], Instant(time, self.line_of_sight, self.max_range, self._movers)

    def _middle(self, number: int) -> float:
        return (number + 0.5) * self.interval

    def _computed(self, number: int, half: float) -> VisibilitySnapshot:
        antenna, instant = self.observed_at(number)
        time = instant.time
        rate = 2.0 * np.pi / self._scene.radar.rotation_period
        width = half + rate * self.interval / 2.0 + self.bearing_drift
        boresight = rate * (time - self._scene.radar.origin.time) % (2.0 * np.pi)
        sector = Sector(antenna, boresight, width, self._step / MAX_BEARING_DRIFT)
        echoes = self.scatterers.steady.echoes(antenna, replace(instant, sector=sector))
        poses = self._poses.at(np.array([time]))
        position = map_from_bodies(echoes.position, echoes.body, poses.position[0], poses.heading[0])
        east, north, _ = (position - antenna).T
        azimuth = np.arctan2(east, north)
        near = np.hypot(east, north) * MAX_BEARING_DRIFT < self._step
        far = np.flatnonzero(~near)
        order = far[np.argsort(azimuth[far])]
        return VisibilitySnapshot(echoes, position, order=order, azimuth=azimuth[order], near=np.flatnonzero(near))


def visibility_interval(scene: Scene, step: float) -> float:
    """Time [s] in which nothing moves more than `step` [m] relative to the antenna, at most one scan."""
    others = max((body.motion.top_speed for body in scene.bodies), default=0.0)
    speed = scene.own_ship.top_speed + mast_speed(scene) + others
    period = scene.radar.rotation_period
    return period if speed * period <= step else step / speed


def mast_speed(scene: Scene) -> float:
    """The highest speed [m/s] at which sway moves the antenna."""
    sway = scene.own_ship.sway
    return 0.0 if sway is None else scene.radar.height * float(np.sum((sway.amplitude * 2.0 * np.pi / sway.period)[:2]))
