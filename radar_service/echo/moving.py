"""Echoes that cannot be laid once for all azimuths: of what moves relative to the antenna, and of what fluctuates.

Range, phase and beam weight are those of the very instant of each azimuth. What changes slowly is renewed at fixed
instants of simulated time: sight and scattering each `glance`, elevation gain and multipath once per call.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.echoes import SweptEchoes, path_factor, received_amplitude, two_way_phase
from radar_service.echo.ensemble import Reflections, Reflectors, placed
from radar_service.echo.scattering import per_azimuth, swerling_factor
from radar_service.echo.sight import Landscape
from radar_service.frames import body_rotation, polar_from_map, wrap_angle
from radar_service.random import FLUCTUATION, generator
from radar_service.scene.world import Motion, Scene
from radar_service.trace.visibility import Stand

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]
Pattern = Callable[[Floats], Floats]  # offset from boresight [rad] to gain relative to it

GLANCE = 5.0  # m that anything may move before sight and scattering are looked at again: a fraction of a ship
PAIRS = 100_000  # echoes x azimuths at a time: some 20 MB of temporaries


@dataclass(frozen=True)
class Instants:
    """Consecutive azimuths: number of each since the start (K,), boresight (K,) [rad], time (K,) [s]."""

    number: Indices
    boresight: Floats
    time: Floats

    @property
    def middle(self) -> float:
        """The instant in the middle [s]."""
        return float(self.time[len(self.time) // 2])


class MovingEchoes:
    """The ensemble of all that moves, ready to be swept."""

    def __init__(
        self, scene: Scene, ensemble: Reflectors, landscape: Landscape, reach: float, extent: float, seed: int
    ) -> None:
        self.scene, self.ensemble, self.landscape = scene, ensemble, landscape
        self.reach, self.extent, self.seed = reach, extent, seed
        self.interval = glance_interval(scene)
        self._seen: tuple[int, Reflections] | None = None

    def __len__(self) -> int:
        return len(self.ensemble)

    def swept(self, at: Instants, pattern: Pattern) -> SweptEchoes:
        """Every echo that the beam reaches at each azimuth; rows count from the first azimuth."""
        seen = self._reflections(int(at.middle // self.interval))
        middle = len(at.time) // 2
        position, heading = self._poses(at.time)
        antenna = self.scene.antenna(at.time)
        stands = [Stand(p, float(h)) for p, h in zip(position[middle], heading[middle], strict=True)]
        everywhere = placed(seen.position, seen.body, stands)
        chosen = self._under_beam(everywhere, antenna[middle], at)
        place, body, points = everywhere[chosen], seen.body[chosen], seen.position[chosen]
        polar = polar_from_map(place, antenna[middle], self.landscape.earth_radius)
        slow = seen.amplitude[chosen] * path_factor(self.scene.radar, self.scene.environment, polar, place[:, 2])
        shift = (position - position[middle]) - (antenna - antenna[middle])[:, None, :]
        parts = []
        step = max(1, PAIRS // max(1, len(chosen)))
        for first in range(0, len(at.time), step):
            k = slice(first, first + step)
            relative = (place - antenna[middle]) + shift[k][:, body]
            relative += _turned(points, body, heading[k], heading[middle])
            parts.append(self._sweep(relative, slow, body, at, first, pattern))
        return SweptEchoes(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _sweep(
        self, relative: Floats, slow: Complexes, body: Indices, at: Instants, first: int, pattern: Pattern
    ) -> tuple[Indices, Floats, Complexes]:
        """Row, range and amplitude of echoes at places (k, C, 3) relative to the antenna, for azimuths from `first` on."""
        polar = polar_from_map(relative, np.zeros(3), self.landscape.earth_radius)
        rows = np.arange(first, first + len(relative))
        offset = wrap_angle(at.boresight[rows, None] - polar.azimuth)
        weight = pattern(offset) * received_amplitude(self.scene.radar, polar.range)
        weight *= self._fluctuation(at.number[rows], polar.azimuth, body)
        value = slow * weight * two_way_phase(polar.range, self.scene.radar.wavelength)
        return np.repeat(rows, len(body)), polar.range.ravel(), value.ravel()

    def _poses(self, time: Floats) -> tuple[Floats, Floats]:
        """Positions (K, B, 3) [m] and headings (K, B) [rad] of the bodies."""
        poses = [body.motion.pose(time) for body in self.ensemble.bodies]
        return np.stack([p.position for p in poses], axis=1), np.stack([p.heading for p in poses], axis=1)

    def _under_beam(self, place: Floats, antenna: Floats, at: Instants) -> Indices:
        """Which places (M, 3) the beam reaches at any of the azimuths."""
        azimuth = np.arctan2(place[:, 0] - antenna[0], place[:, 1] - antenna[1])
        middle = at.boresight[len(at.boresight) // 2]
        span = np.abs(at.boresight - middle).max()
        return np.flatnonzero(np.abs(wrap_angle(azimuth - middle)) <= self.extent + span)

    def _reflections(self, glance: int) -> Reflections:
        """What the antenna sees of everything during a glance."""
        if self._seen is None or self._seen[0] != glance:
            time = (glance + 0.5) * self.interval
            antenna = self.scene.antenna(time)[0]
            self._seen = (glance, self.ensemble.reflections(self.landscape, antenna, time, self.reach))
        return self._seen[1]

    def _fluctuation(self, number: Indices, azimuth: Floats, body: Indices) -> Floats | float:
        """Amplitude factors (k, C) of fluctuating bodies. Slow cases are drawn once per crossing of the beam, which is
        counted from where the beam looks the other way, so that no target changes under it."""
        bodies = self.ensemble.bodies
        fluctuating = [b for b in np.unique(body) if bodies[b].swerling]
        if not fluctuating:
            return 1.0
        factor = np.ones((len(number), len(body)))
        turns = self.scene.radar.azimuths
        for b in fluctuating:
            case, key = bodies[b].swerling, int(self.ensemble.key[b])
            mine = np.flatnonzero(body == b)
            crossing = np.floor(number / turns - azimuth[:, mine[0]] % (2 * np.pi) / (2 * np.pi) + 1.5).astype(np.int64)
            for k, draw in enumerate(number if per_azimuth(case) else crossing):
                power = swerling_factor(case, generator(self.seed, FLUCTUATION, key, int(draw)))
                factor[k, mine] = np.sqrt(power)
        return factor


def _turned(points: Floats, body: Indices, heading: Floats, reference: Floats) -> Floats | float:
    """How far (k, C, 3) [m] points (C, 3) of bodies lie from where they would if headings (k, B) were `reference` (B,)."""
    turning = np.flatnonzero((heading != reference).any(axis=0))
    if not len(turning):
        return 0.0
    moved = np.zeros((len(heading), len(points), 3))
    for b in turning:
        mine = np.flatnonzero(body == b)
        before = points[mine] @ body_rotation(float(reference[b])).T
        for k, angle in enumerate(heading[:, b]):
            moved[k, mine] = points[mine] @ body_rotation(float(angle)).T - before
    return moved


def glance_interval(scene: Scene) -> float:
    """Time [s] in which nothing moves more than GLANCE relative to the antenna, at most one revolution."""
    own, others = _top_speed(scene.own_ship), max((_top_speed(body.motion) for body in scene.bodies), default=0.0)
    speed = own + others
    period = scene.radar.rotation_period
    return period if speed * period <= GLANCE else GLANCE / speed


def _top_speed(motion: Motion) -> float:
    """The highest speed [m/s] of a motion."""
    legs = np.diff(motion.time)
    steps = np.linalg.norm(np.diff(motion.position, axis=0), axis=1)
    fastest = np.divide(steps, legs, out=np.zeros_like(steps), where=legs > 0).max(initial=0.0)
    return float(max(fastest, np.linalg.norm(motion.final_velocity)))
