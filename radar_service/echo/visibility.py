"""Visibility of moving bodies: what the antenna has a line of sight to, renewed at fixed instants of simulated time."""

from dataclasses import dataclass, field, replace

import numpy as np

from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.numerics import Floats, Indices, ResultCache, wrap_angle
from radar_service.scattering import BearingWedge, BodyEchoes, Instant, ScattererSet
from radar_service.trace import OcclusionScene
from radar_service.world import BodyPoses, Scene

MAX_BEARING_DRIFT = 0.05  # rad that echoes which are not near may leave their bearing of the middle of a step
PER_PERIOD = 32  # visibility steps in the shortest period of a body's sway
SNAPSHOTS = 4  # kept: threads may be this many steps apart before one is computed again


@dataclass(frozen=True)
class VisibilitySnapshot(ObservedEchoes):
    """All visible echoes (M,) of moving bodies for one visibility step; positions are those of the middle of the step.

    Bodies whose echoes depend on aspect are evaluated as the beam passes instead (`echo.beam_passage`).

    order: indices of the echoes that are not near, by rising azimuth.
    azimuth: their azimuths, in that order [rad].
    near: indices of the others, which may have any azimuth.
    nearest: ground distance of the nearest echo [m].
    """

    order: Indices = field(kw_only=True)
    azimuth: Floats = field(kw_only=True)
    near: Indices = field(kw_only=True)
    nearest: float = field(kw_only=True)

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
        self._scene, self.step = scene, step
        self._poses = BodyPoses(scatterers.bodies)
        self._movers = len(line_of_sight.moving_shadow_sectors(scene.antenna(0.0)[0], 0.0).middle) > 0
        sway = scene.own_ship.sway
        self.bearing_drift = MAX_BEARING_DRIFT + (0.0 if sway is None else sway.max_tilt)
        self._snapshots: ResultCache[tuple[int, bytes], VisibilitySnapshot] = ResultCache(SNAPSHOTS, scene.revision)

    def snapshot(self, number: int, half: float, time: float | None = None) -> VisibilitySnapshot:
        """The snapshot of the visibility step of that number, within `half` [rad] of all boresights meanwhile.

        time: when those bodies are present that it shows [s]; None: the middle of the step.
        """
        time = self._middle(number) if time is None else time
        state = self.line_of_sight.presences.state(time)
        return self._snapshots.get((number, state), lambda: self._computed(number, half, time))

    def all_round(self, number: int) -> BodyEchoes:
        """All visible echoes in the middle of the step of that number, wherever the beam points, those by aspect among them."""
        return self.scatterers.echoes(*self.observed_at(number))

    def observed_at(self, number: int) -> tuple[Floats, Instant]:
        """The antenna (3,) on the map [m] and the instant in the middle of the step of that number."""
        time = self._middle(number)
        return self._scene.antenna(time)[0], Instant(time, self.line_of_sight, self.max_range, self._movers)

    def _middle(self, number: int) -> float:
        return (number + 0.5) * self.interval

    def _computed(self, number: int, half: float, presence_time: float) -> VisibilitySnapshot:
        antenna, instant = self.observed_at(number)
        time, line_of_sight = instant.time, self.line_of_sight.as_of(presence_time)
        rate = 2.0 * np.pi / self._scene.radar.rotation_period
        width = half + rate * self.interval / 2.0 + self.bearing_drift
        boresight = rate * time % (2.0 * np.pi)
        wedge = BearingWedge(antenna, boresight, width, self.step / MAX_BEARING_DRIFT)
        echoes = self.scatterers.steady.echoes(antenna, replace(instant, wedge=wedge, line_of_sight=line_of_sight))
        present = line_of_sight.present(time)[self.scatterers.key]
        if not present.all():
            echoes = echoes.chosen(np.flatnonzero(present[echoes.body]))
        poses = self._poses.at(np.array([time]))
        position = poses.map_from_bodies(0, echoes.position, echoes.body)
        east, north, _ = (position - antenna).T
        azimuth = np.arctan2(east, north)
        distance = np.hypot(east, north)
        near = distance * MAX_BEARING_DRIFT < self.step
        far = np.flatnonzero(~near)
        order = far[np.argsort(azimuth[far])]
        return VisibilitySnapshot(
            echoes,
            position,
            order=order,
            azimuth=azimuth[order],
            near=np.flatnonzero(near),
            nearest=float(distance.min(initial=np.inf)),
        )


def visibility_interval(scene: Scene, step: float) -> float:
    """Time [s] in which nothing moves more than `step` [m] relative to the antenna, at most one scan, and no body sways by more
    than a fifth of its amplitude."""
    others = max((body.top_speed for body in scene.bodies), default=0.0)
    speed = scene.own_ship.top_speed + mast_speed(scene) + others
    sways = (body.motion.sway for body in scene.bodies)
    period = min([scene.radar.rotation_period, *(sway.shortest_period / PER_PERIOD for sway in sways if sway is not None)])
    return period if speed * period <= step else step / speed


def mast_speed(scene: Scene) -> float:
    """The highest speed [m/s] at which sway moves the antenna."""
    sway = scene.own_ship.sway
    return 0.0 if sway is None else scene.radar.height * float(np.sum(sway.max_rates[:2])) + float(sway.max_rates[3])
