"""Echoes that cannot be laid once for all azimuths: of what moves relative to the antenna, and of what fluctuates.

Range, phase and beam weight are those of the very instant of each azimuth. What changes slowly is renewed at fixed
instants of simulated time: sight and scattering each `glance`, elevation gain and multipath once per call.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.echoes import elevation_gain, path_factor, received_amplitude, two_way_phase
from radar_service.echo.ensemble import Reflections, Reflectors
from radar_service.echo.fleet import Fleet, Stands, placed_at
from radar_service.echo.fluctuation import Fluctuation
from radar_service.echo.held import Held
from radar_service.echo.sight import Landscape
from radar_service.echo.sweep import (
    TOLERANCE,
    BeamTable,
    Course,
    Parabola,
    SweptEchoes,
    apparent,
    elevation_of,
    exact_course,
    joined,
    parabola,
    smooth_course,
    strays,
    turned_amplitude,
)
from radar_service.frames import polar_from_map, wrap_angle
from radar_service.scene.world import Motion, Scene

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]

NULL = 1e-3  # of boresight: elevation gains below it do not divide
ECHOES = 8192  # at a time: arrays of 16 azimuths by so many stay in the L2 cache


@dataclass(frozen=True)
class Instants:
    """Consecutive azimuths: number of each since the start (K,), boresight (K,) [rad], time (K,) [s]."""

    number: Indices
    boresight: Floats
    time: Floats

    def part(self, start: int, stop: int) -> "Instants":
        """Those from start to stop, exclusive."""
        return Instants(self.number[start:stop], self.boresight[start:stop], self.time[start:stop])

    @property
    def middle(self) -> float:
        """The instant in the middle [s]."""
        return float(self.time[len(self.time) // 2])


@dataclass(frozen=True)
class Glance:
    """What the antenna sees for a while: reflections (M,), and where those of bodies at rest are (M, 3) on the map [m]."""

    seen: Reflections
    place: Floats


class Moment(NamedTuple):
    """Some azimuths (K,), and at three nodes and then at each of them: where bodies and the antenna (3 + K, 3) are, how the
    antenna sways (3 + K, 3, 3). rough: (B,) which bodies do not follow the parabola `over` them."""

    at: Instants
    over: Parabola
    stands: Stands
    antenna: Floats
    upright: Floats | None
    rough: NDArray[np.bool_]


class MovingEchoes:
    """The ensemble of all that moves, ready to be swept. Safe to call from several threads."""

    def __init__(
        self,
        scene: Scene,
        ensemble: Reflectors,
        landscape: Landscape,
        reach: float,
        beam: BeamTable,
        glance: float,
        seed: int,
    ) -> None:
        """reach: range [m] beyond which nothing is heard; beam: as far out as anything is swept; glance: [m]
        that anything may move before sight and scattering are looked at again."""
        self.scene, self.ensemble, self.landscape = scene, ensemble, landscape
        self.reach, self._beam = reach, beam
        self.interval = glance_interval(scene, glance)
        self.fleet = Fleet(ensemble.bodies)
        self._moves = np.zeros(len(ensemble.bodies), dtype=np.bool_)
        self._moves[self.fleet.moving] = True
        self.fluctuation = Fluctuation(ensemble.bodies, ensemble.key, scene.radar.azimuths, seed)
        self._glance = Held(self._looked)

    def __len__(self) -> int:
        return len(self.ensemble)

    def seen(self, number: int) -> Reflections:
        """What the antenna sees of everything during the glance of that number."""
        return self._glance(number).seen

    def swept(self, at: Instants) -> SweptEchoes:
        """Every echo that the beam reaches at any of these azimuths."""
        glance, now = self._glance(int(at.middle // self.interval)), self._moment(at)
        everywhere = self._places(glance, None, now, 1) - now.antenna[1]
        chosen = self._under_beam(everywhere if now.upright is None else everywhere @ now.upright[1].T, at)
        parts = [self._part(glance, chosen[i : i + ECHOES], now) for i in range(0, len(chosen), ECHOES)]
        return joined(parts, len(at.time))

    def _moment(self, at: Instants) -> Moment:
        over = parabola(at.time)
        time = np.concatenate([over.nodes, at.time])
        stands, antenna = self.fleet.stands(time), self.scene.antenna(time)
        rough = self._rough(stands, antenna, over)
        return Moment(at, over, stands, antenna, self.scene.upright_from_map(time), rough)

    def _part(self, glance: Glance, which: Indices, now: Moment) -> SweptEchoes:
        """Some of the echoes, indices into the glance."""
        body, earth = glance.seen.body[which], self.landscape.earth_radius
        nodes = [self._places(glance, which, now, n) - now.antenna[n] for n in range(3)]
        polar = polar_from_map(nodes[1], np.zeros(3), earth)
        seen = nodes if now.upright is None else [apparent(nodes[n], now.upright[n], earth) for n in range(3)]
        azimuth = polar.azimuth if now.upright is None else np.arctan2(seen[1][:, 0], seen[1][:, 1])
        course, near = smooth_course(nodes, seen, polar.range, earth, now.over)
        up = polar.elevation if now.upright is None else elevation_of(seen[1])
        exact = np.union1d(near, np.flatnonzero(now.rough[body]))
        if len(exact):
            nodding = self._exactly(course, exact, self._every(glance, which[exact], now), azimuth, up, now)
        weight = self._weight(course, azimuth, now.at)
        self.fluctuation.apply(weight, now.at.number, azimuth, body)
        radar = self.scene.radar
        if now.upright is not None:
            radar = replace(radar, height=float(now.antenna[1, 2]))
            smooth = self._nodding([elevation_of(seen[0]), up, elevation_of(seen[2])], now.over)
            smooth[exact] = 1.0
            weight *= smooth
        if len(exact):
            weight[exact] *= nodding
        height = nodes[1][:, 2] + now.antenna[1, 2]
        base = glance.seen.amplitude[which] * path_factor(radar, self.scene.environment, polar, height, up - polar.elevation)
        base *= received_amplitude(radar, polar.range) * two_way_phase(polar.range, radar.wavelength)
        return SweptEchoes(polar.range, course.drift, turned_amplitude(base, weight, course.drift, radar.wavelength))

    def _every(self, glance: Glance, which: Indices, now: Moment) -> Floats:
        """Places (K, W, 3) of reflections relative to the antenna at every azimuth."""
        return np.stack([self._places(glance, which, now, n) - now.antenna[n] for n in range(3, len(now.antenna))])

    def _exactly(self, course: Course, which: Indices, places: Floats, azimuth: Floats, up: Floats, now: Moment) -> Singles:
        """Lays the true changes of some echoes into `course`; their elevation gains (W, K) over those of the middle, where
        they stand at `azimuth` (E,) and elevation `up` (E,)."""
        elevation = exact_course(course, which, places, now.upright, azimuth[which], self.landscape.earth_radius)
        middle, gain = (elevation_gain(self.scene.radar, angle) for angle in (up[which], elevation))
        return np.where(middle[:, None] < NULL, 1.0, gain / np.maximum(middle, NULL)[:, None]).astype(np.float32)

    def _weight(self, course: Course, azimuth: Floats, at: Instants) -> Singles:
        """Beam weights (E, K), and how much louder each echo is than at the middle, where it stands at `azimuth` (E,)."""
        middle = at.boresight[len(at.boresight) // 2]
        offset = (at.boresight - middle).astype(np.float32) - course.swing
        offset += wrap_angle(middle - azimuth).astype(np.float32)[:, None]
        weight = self._beam(offset)
        nearest = np.maximum(course.range, self.scene.radar.range_min)
        nearer = course.drift * (1.0 / nearest).astype(np.float32)[:, None]
        nearer += np.float32(1.0)
        weight /= np.square(nearer, out=nearer)
        return weight

    def _nodding(self, elevations: list[Floats], over: Parabola) -> Singles:
        """Elevation gain (E, K) of a swaying beam over that at the middle; 1 about its nulls."""
        first, middle, last = (elevation_gain(self.scene.radar, elevation) for elevation in elevations)
        steady = middle < NULL
        middle[steady] = first[steady] = last[steady] = 1.0
        return over.change(first / middle - 1.0, last / middle - 1.0) + np.float32(1.0)

    def _places(self, glance: Glance, which: Indices | None, now: Moment, instant: int) -> Floats:
        """Where reflections `which` (E,), or all, are on the map (E, 3) [m] at one of the instants of `now`."""
        every = slice(None) if which is None else which
        place, body = glance.place[every], glance.seen.body[every]
        moving = np.flatnonzero(self._moves[body])
        if not len(moving):
            return place
        place = place.copy()
        points = glance.seen.position[every][moving]
        place[moving] = placed_at(points, body[moving], now.stands.position[instant], now.stands.heading[instant])
        return place

    def _rough(self, stands: Stands, antenna: Floats, over: Parabola) -> NDArray[np.bool_]:
        """Which bodies (B,), seen from the antenna, leave their parabola: those at a corner of their track."""
        own = strays(antenna[3:], antenna[:3], over)
        rough = np.full(len(self._moves), bool(own > TOLERANCE))
        moving = self.fleet.moving
        if len(moving) and not own > TOLERANCE:
            position, heading = stands.position[:, moving], np.unwrap(stands.heading[:, moving], axis=0)[..., None]
            length = np.array([max(self.ensemble.bodies[b].length, self.ensemble.bodies[b].beam) for b in moving])
            away = strays(position[3:], position[:3], over) + length * strays(heading[3:], heading[:3], over)
            rough[moving] = away > TOLERANCE
        return rough

    def _under_beam(self, place: Floats, at: Instants) -> Indices:
        """Which places (M, 3) relative to the antenna the beam reaches at any of the azimuths."""
        middle = at.boresight[len(at.boresight) // 2]
        half = self._beam.extent + np.abs(at.boresight - middle).max()
        if half >= np.pi:
            return np.arange(len(place))
        ahead = place[:, 0] * np.sin(middle) + place[:, 1] * np.cos(middle)
        distance = np.sqrt(place[:, 0] ** 2 + place[:, 1] ** 2)
        return np.flatnonzero(ahead >= distance * np.cos(half))

    def _looked(self, number: int) -> Glance:
        """What the antenna sees of everything during the glance of that number."""
        time = (number + 0.5) * self.interval
        seen = self.ensemble.reflections(self.landscape, self.scene.antenna(time)[0], time, self.reach)
        stands = self.fleet.stands(np.array([time]))
        return Glance(seen, placed_at(seen.position, seen.body, stands.position[0], stands.heading[0]))


def glance_interval(scene: Scene, glance: float) -> float:
    """Time [s] in which nothing moves more than `glance` [m] relative to the antenna, at most one revolution."""
    others = max((_top_speed(body.motion) for body in scene.bodies), default=0.0)
    speed = _top_speed(scene.own_ship) + mast_speed(scene) + others
    period = scene.radar.rotation_period
    return period if speed * period <= glance else glance / speed


def _top_speed(motion: Motion) -> float:
    """The highest speed [m/s] of a motion."""
    legs = np.diff(motion.time)
    steps = np.linalg.norm(np.diff(motion.position, axis=0), axis=1)
    fastest = np.divide(steps, legs, out=np.zeros_like(steps), where=legs > 0).max(initial=0.0)
    bent = 0.0 if motion.arcs is None else motion.arcs[:, 1].max()
    return float(max(fastest, bent, np.linalg.norm(motion.final_velocity)))


def mast_speed(scene: Scene) -> float:
    """The highest speed [m/s] at which sway carries the antenna."""
    sway = scene.own_ship.sway
    return 0.0 if sway is None else scene.radar.height * float(np.sum((sway.amplitude * 2.0 * np.pi / sway.period)[:2]))
