"""Echoes that cannot be laid once for all azimuths: of what moves relative to the antenna, and of what fluctuates.

Range, phase and beam weight are those of the very instant of each azimuth. What changes slowly is renewed at fixed
instants of simulated time: sight and scattering each `visibility_step`, elevation gain and multipath once per call.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.block_cache import BlockCache
from radar_service.echo.range_history import (
    TOLERANCE,
    BeamTable,
    BeamWeightedEchoes,
    Parabola,
    RangeHistory,
    apparent,
    elevation_of,
    exact_history,
    interpolated_history,
    interpolation_error,
    joined,
    parabola,
    turned_amplitude,
)
from radar_service.frames import polar_from_map, wrap_angle
from radar_service.propagation.radar_equation import elevation_gain, path_factor, received_amplitude, two_way_phase
from radar_service.scattering.fluctuation import Fluctuation
from radar_service.scattering.scatterer_set import BodyEchoes, ScattererSource, Sector
from radar_service.scene.poses import BodyPoses, PoseArrays, placed_at
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]

LEEWAY = 0.05  # rad that what is not close may leave its bearing of the middle of a glance
NULL = 1e-3  # of boresight: elevation gains below it do not divide
ECHOES = 8192  # at a time: arrays of 16 azimuths by so many stay in the L2 cache


@dataclass(frozen=True)
class AzimuthTimes:
    """Consecutive azimuths: number of each since the start (K,), boresight (K,) [rad], time (K,) [s]."""

    number: Indices
    boresight: Floats
    time: Floats

    def part(self, start: int, stop: int) -> "AzimuthTimes":
        """Those from start to stop, exclusive."""
        return AzimuthTimes(self.number[start:stop], self.boresight[start:stop], self.time[start:stop])

    @property
    def middle(self) -> float:
        """The instant in the middle [s]."""
        return float(self.time[len(self.time) // 2])


@dataclass(frozen=True)
class VisibilitySnapshot:
    """What the antenna sees for a while: reflections (M,), and where those of bodies at rest are (M, 3) on the map [m]; which
    of them are not close, by rising azimuth (F,) [rad] at its middle, and which are (C,), whose azimuth may be any."""

    seen: BodyEchoes
    place: Floats
    order: Indices
    azimuth: Floats
    close: Indices

    def about(self, boresight: float, half: float) -> Indices:
        """Indices of all that may be met within `half` of `boresight` [rad]."""
        if half >= np.pi:
            return np.arange(len(self.place))
        edges = wrap_angle(np.array([boresight - half, boresight + half]))
        first, last = np.searchsorted(self.azimuth, edges)
        met = [self.order[first:last]] if edges[0] <= edges[1] else [self.order[first:], self.order[:last]]
        return np.concatenate([self.close, *met])


class BlockGeometry(NamedTuple):
    """Some azimuths (K,), and at three nodes and then at each of them: where bodies and the antenna (3 + K, 3) are, how the
    antenna sways (3 + K, 3, 3). rough: (B,) which bodies do not follow the parabola `over` them."""

    at: AzimuthTimes
    over: Parabola
    stands: PoseArrays
    antenna: Floats
    upright: Floats | None
    rough: NDArray[np.bool_]


class MovingEchoes:
    """The ensemble of all that moves, ready to be swept. Safe to call from several threads."""

    def __init__(
        self,
        scene: Scene,
        ensemble: ScattererSource,
        occlusion: OcclusionScene,
        reach: float,
        beam: BeamTable,
        visibility_step: float,
        seed: int,
    ) -> None:
        """reach: range [m] beyond which nothing is heard; beam: as far out as anything is swept; glance: [m]
        that anything may move before sight and scattering are looked at again."""
        self.scene, self.ensemble, self.occlusion = scene, ensemble, occlusion
        self.reach, self._beam = reach, beam
        self.interval = visibility_interval(scene, visibility_step)
        sway = scene.own_ship.sway
        self._moved, self._leeway = visibility_step, LEEWAY + (0.0 if sway is None else float(sway.amplitude[:2].sum()))
        self.fleet = BodyPoses(ensemble.bodies)
        self._moves = np.zeros(len(ensemble.bodies), dtype=np.bool_)
        self._moves[self.fleet.moving] = True
        self.fluctuation = Fluctuation(ensemble.bodies, ensemble.key, scene.radar.azimuths, seed)
        self._glance = BlockCache(self._looked)

    def __len__(self) -> int:
        return len(self.ensemble)

    def seen(self, number: int) -> BodyEchoes:
        """What the antenna sees of everything during the glance of that number."""
        return self._glance(number).seen

    def swept(self, at: AzimuthTimes) -> BeamWeightedEchoes:
        """Every echo that the beam reaches at any of these azimuths."""
        visibility_step = self._glance(int(at.middle // self.interval))
        middle, half = self._sector(at)
        about = visibility_step.about(middle, half + self._leeway)
        if not len(about):
            return joined([], len(at.time))
        now = self._moment(at, np.flatnonzero(np.bincount(visibility_step.seen.body[about])))
        (places,) = self._places(visibility_step, about, now, [1])
        chosen = about[_within(places if now.upright is None else places @ now.upright[1].T, middle, half)]
        parts = [self._part(visibility_step, chosen[i : i + ECHOES], now) for i in range(0, len(chosen), ECHOES)]
        return joined(parts, len(at.time))

    def _sector(self, at: AzimuthTimes) -> tuple[float, float]:
        """Boresight in the middle and half the width of all that the beam reaches at any of the azimuths [rad]."""
        middle = at.boresight[len(at.boresight) // 2]
        return float(middle), float(self._beam.extent + np.abs(at.boresight - middle).max())

    def _moment(self, at: AzimuthTimes, bodies: Indices) -> BlockGeometry:
        """The moment of these azimuths, as far as it concerns some bodies (N,) of the ensemble."""
        over = parabola(at.time)
        time = np.concatenate([over.nodes, at.time])
        stands, antenna = self.fleet.stands(time, bodies), self.scene.antenna(time)
        rough = self._rough(stands, antenna, over, bodies[self._moves[bodies]])
        return BlockGeometry(at, over, stands, antenna, self.scene.upright_from_map(time), rough)

    def _part(self, visibility_step: VisibilitySnapshot, which: Indices, now: BlockGeometry) -> BeamWeightedEchoes:
        """Some of the echoes, indices into the glance."""
        body, earth = visibility_step.seen.body[which], self.occlusion.earth_radius
        nodes = self._places(visibility_step, which, now, range(3))
        polar = polar_from_map(nodes[1], np.zeros(3), earth)
        seen = nodes if now.upright is None else [apparent(nodes[n], now.upright[n], earth) for n in range(3)]
        azimuth = polar.azimuth if now.upright is None else np.arctan2(seen[1][:, 0], seen[1][:, 1])
        course, near = interpolated_history(nodes, seen, polar.range, earth, now.over)
        up = polar.elevation if now.upright is None else elevation_of(seen[1])
        exact = np.flatnonzero(near | now.rough[body])
        if len(exact):
            every = np.stack(self._places(visibility_step, which[exact], now, range(3, len(now.antenna))))
            nodding = self._exactly(course, exact, every, azimuth, up, now)
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
        base = visibility_step.seen.amplitude[which] * path_factor(
            radar, self.scene.environment, polar, height, up - polar.elevation
        )
        base *= received_amplitude(radar, polar.range) * two_way_phase(polar.range, radar.wavelength)
        return BeamWeightedEchoes(
            polar.range, course.range_migration, turned_amplitude(base, weight, course.range_migration, radar.wavelength)
        )

    def _exactly(
        self, course: RangeHistory, which: Indices, places: Floats, azimuth: Floats, up: Floats, now: BlockGeometry
    ) -> Singles:
        """Lays the true changes of some echoes into `course`; their elevation gains (W, K) over those of the middle, where
        they stand at `azimuth` (E,) and elevation `up` (E,)."""
        elevation = exact_history(course, which, places, now.upright, azimuth[which], self.occlusion.earth_radius)
        middle, gain = (elevation_gain(self.scene.radar, angle) for angle in (up[which], elevation))
        return np.where(middle[:, None] < NULL, 1.0, gain / np.maximum(middle, NULL)[:, None]).astype(np.float32)

    def _weight(self, course: RangeHistory, azimuth: Floats, at: AzimuthTimes) -> Singles:
        """Beam weights (E, K), and how much louder each echo is than at the middle, where it stands at `azimuth` (E,)."""
        middle = at.boresight[len(at.boresight) // 2]
        offset = (at.boresight - middle).astype(np.float32) - course.azimuth_change
        offset += wrap_angle(middle - azimuth).astype(np.float32)[:, None]
        weight = self._beam(offset)
        nearest = np.maximum(course.range, self.scene.radar.range_min)
        nearer = course.range_migration * (1.0 / nearest).astype(np.float32)[:, None]
        nearer += np.float32(1.0)
        weight /= np.square(nearer, out=nearer)
        return weight

    def _nodding(self, elevations: list[Floats], over: Parabola) -> Singles:
        """Elevation gain (E, K) of a swaying beam over that at the middle; 1 about its nulls."""
        first, middle, last = (elevation_gain(self.scene.radar, elevation) for elevation in elevations)
        steady = middle < NULL
        middle[steady] = first[steady] = last[steady] = 1.0
        return over.change(first / middle - 1.0, last / middle - 1.0) + np.float32(1.0)

    def _places(
        self, visibility_step: VisibilitySnapshot, which: Indices, now: BlockGeometry, instants: Iterable[int]
    ) -> list[Floats]:
        """Where reflections `which` (E,) are from the antenna, on the map (E, 3) [m], at some of the instants of `now`."""
        place, body = visibility_step.place[which], visibility_step.seen.body[which]
        moving = np.flatnonzero(self._moves[body])
        points, mover = visibility_step.seen.position[which[moving]], body[moving]
        places = []
        for n in instants:
            places.append(place - now.antenna[n])
            if len(moving):
                there = placed_at(points, mover, now.stands.position[n], now.stands.heading[n])
                places[-1][moving] = there - now.antenna[n]
        return places

    def _rough(self, stands: PoseArrays, antenna: Floats, over: Parabola, moving: Indices) -> NDArray[np.bool_]:
        """Which bodies (B,), seen from the antenna, leave their parabola: those of `moving` (N,) at a corner of their track."""
        own = interpolation_error(antenna[3:], antenna[:3], over)
        rough = np.full(len(self._moves), bool(own > TOLERANCE))
        if len(moving) and not own > TOLERANCE:
            position, heading = stands.position[:, moving], np.unwrap(stands.heading[:, moving], axis=0)[..., None]
            arm = np.array([self.ensemble.bodies[b].arm for b in moving])
            away = interpolation_error(position[3:], position[:3], over) + arm * interpolation_error(
                heading[3:], heading[:3], over
            )
            rough[moving] = away > TOLERANCE
        return rough

    def _passed(self, number: int) -> tuple[float, float]:
        """Middle and half width [rad] of the sector that the beam sees during the glance of that number, and a tile more."""
        rate = 2.0 * np.pi / self.scene.radar.rotation_period
        turned = rate * self.interval / 2.0 + self._beam.span
        return rate * (number + 0.5) * self.interval % (2.0 * np.pi), self._beam.extent + turned + self._leeway

    def _looked(self, number: int) -> VisibilitySnapshot:
        """What the antenna sees of all that the beam reaches during the glance of that number."""
        time = (number + 0.5) * self.interval
        antenna = self.scene.antenna(time)[0]
        sector = Sector(antenna, *self._passed(number), self._moved / LEEWAY)
        seen = self.ensemble.reflections(self.occlusion, antenna, time, self.reach, sector=sector)
        stands = self.fleet.stands(np.array([time]))
        place = placed_at(seen.position, seen.body, stands.position[0], stands.heading[0])
        east, north, _ = (place - antenna).T
        azimuth = np.arctan2(east, north)
        close = np.hypot(east, north) * LEEWAY < self._moved
        far = np.flatnonzero(~close)
        order = far[np.argsort(azimuth[far])]
        return VisibilitySnapshot(seen, place, order, azimuth[order], np.flatnonzero(close))


def _within(place: Floats, middle: float, half: float) -> NDArray[np.bool_]:
    """Which places (M, 3) relative to the antenna lie within `half` of the bearing `middle` [rad]."""
    if half >= np.pi:
        return np.ones(len(place), dtype=np.bool_)
    ahead = place[:, 0] * np.sin(middle) + place[:, 1] * np.cos(middle)
    distance = np.sqrt(place[:, 0] ** 2 + place[:, 1] ** 2)
    return np.asarray(ahead >= distance * np.cos(half))


def visibility_interval(scene: Scene, visibility_step: float) -> float:
    """Time [s] in which nothing moves more than `visibility_step` [m] relative to the antenna, at most one revolution."""
    others = max((body.motion.top_speed for body in scene.bodies), default=0.0)
    speed = scene.own_ship.top_speed + mast_speed(scene) + others
    period = scene.radar.rotation_period
    return period if speed * period <= visibility_step else visibility_step / speed


def mast_speed(scene: Scene) -> float:
    """The highest speed [m/s] at which sway carries the antenna."""
    sway = scene.own_ship.sway
    return 0.0 if sway is None else scene.radar.height * float(np.sum((sway.amplitude * 2.0 * np.pi / sway.period)[:2]))
