"""Echoes of bodies whose echoes depend on aspect: evaluated at instants, the nodes, along each passage of the beam.

A passage is counted from the opposite bearing, so an azimuth never takes the aspect of an older or a later one. Nodes lie on both
sides of the crossing, which is the spoke nearest to where the boresight points at the body. Between nodes the field is a sum of
those of the nearest ones, each with its own exact range histories. Weights are cubic in time between four nodes, linear between
two. A body that hardly changes has one node.

An echo stands for `coherence` metres of the body. Their ends change their phase against its middle at the rate omega, which is
k coherence x (rate of the line of sight in the body's frame). Echoes on a lattice follow that to first order: a field held
over the phase theta errs by theta^2 / 3, one between two nodes theta apart by theta^2 / 12, of four nodes by theta^4 / 64.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.block_cache import BlockCache
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.passage_nodes import CUBIC, node_weights, outward_nodes, waterline_rise
from radar_service.echo.visibility import mast_speed
from radar_service.frames import wrap_angle
from radar_service.radar.parameters import Radar
from radar_service.scattering.model import AspectModel, BodyEchoes, Instant
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.scene.poses import BodyPoses
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Floats, Indices

MAX_PHASE = 0.4  # rad between nodes: on the way from one to the next, cells lose up to theta^2 / 12, 1.3 % or 0.12 dB
CUBIC_PHASE = 0.8  # rad between nodes of these: up to 3 theta^4 / 128 is lost on the way, 1 %, in the outer intervals 1.7 %
HELD_PHASE = 0.33  # rad times gain, or rms over the beam: up to it a node is held; 3 times as much errs no more (tests)
EDGE_PHASE = 0.25  # rad at the edge of the main beam: one node errs by 4 %, at 0.5 rad by 12 % (tests/echo)
MAIN_BEAM = 0.1  # one-way gain: 20 dB of two-way power, down to which each spoke keeps its aspect to 1 dB
FAINT = 0.007  # one-way gain: an aspect that is wrong there errs by at most root 2 of it, -40 dB; the outer nodes are held
NEAREST = 16.0  # m: parts of a body are taken as no nearer, like the far field of its facets
SAMPLES = 33  # instants of a passage at which rates are taken
GAINS_PER_BEAMWIDTH = 32  # of the envelope of sidelobes
NODES_PER_BODY = 16  # kept: those in use, and those of threads that are ahead
SLOTS = 2  # of a scan, at whose ends sectors of bodies are computed
MAX_ITERATIONS = 30  # towards the crossing; a body at 500 m and 40 kn takes 5
CONVERGED = 1e-9  # turns: the crossing is rounded to a spoke, some 1e-4 of a turn
MARGIN = 1.2  # nodes cover so much more than the beam's extent: bodies move meanwhile


class Aspect(NamedTuple):
    """One body whose echoes depend on aspect: its model, its index there, and its index in the set."""

    model: AspectModel
    local: int
    body: int


class BeamPassages:
    """The echoes of all bodies (N,) of a set whose echoes depend on aspect. Safe to call from several threads."""

    def __init__(
        self, scene: Scene, scatterers: ScattererSet, line_of_sight: OcclusionScene, max_range: float, extent: float
    ) -> None:
        """max_range: beyond it no echo is received [m]; extent: offset from boresight beyond which echoes are left out [rad]."""
        self._scene, self._line_of_sight, self._max_range = scene, line_of_sight, max_range
        self._aspects = [
            Aspect(model, local, int(body))
            for model in scatterers.aspect_models
            for local, body in enumerate(np.searchsorted(scatterers.key, model.key))
        ]
        bodies = [scatterers.bodies[aspect.body] for aspect in self._aspects]
        self._key = scatterers.key[[aspect.body for aspect in self._aspects]]  # in the scene
        self._bodies, self._poses = bodies, BodyPoses(bodies)
        self._middle = np.array([body.middle for body in bodies]).reshape(-1, 3)
        self._radius = np.array([body.radius for body in bodies])
        self._size = [body.diagonal for body in bodies]
        self._sway = 0.0 if scene.own_ship.sway is None else scene.own_ship.sway.max_tilt
        self._extent, self._envelope = extent, _sidelobe_envelope(scene.radar)
        received = np.count_nonzero(self._envelope > FAINT) / len(self._envelope) * np.pi
        self._reach = extent if extent >= np.pi else min(extent, received)
        self._nodes: BlockCache[tuple[int, int, bytes], ObservedEchoes] = BlockCache(NODES_PER_BODY * max(1, len(bodies)))
        self._schedules: BlockCache[tuple[int, int], Indices] = BlockCache(4 * max(1, len(bodies)))
        self._speed = np.array([body.top_speed for body in bodies]) + scene.own_ship.top_speed + mast_speed(scene)
        self._swing = 2.0 * np.hypot(self._middle[:, 0], self._middle[:, 1])  # m, by which turns move a middle at most
        self._sectors: BlockCache[int, tuple[Floats, Floats]] = BlockCache(SLOTS)
        self._crossings: BlockCache[tuple[int, int], int] = BlockCache(8 * max(1, len(bodies)))

    def __len__(self) -> int:
        return len(self._aspects)

    def motions_changed(self) -> None:
        """Drops what has been computed from the motions before."""
        for cache in (self._nodes, self._schedules, self._sectors, self._crossings):
            cache.clear()

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> ObservedEchoes | None:
        """Echoes of all bodies that may lie within `half` of the bearing `middle` [rad] at these azimuths; None where none do."""
        if not self._aspects:
            return None
        spoke = self._scene.radar.spokes_at(azimuths.time)
        parts, fades = [], []
        present = self._line_of_sight.present(azimuths.middle)[self._key]
        for n, crossing in self.passing(azimuths.middle, middle, half):
            if not present[n]:
                continue
            nodes = self.nodes(n, crossing)
            for node, fade in zip(nodes, node_weights(nodes, spoke), strict=True):
                if fade.any():
                    parts.append(self._node(n, int(node), azimuths.middle))
                    fades.append(np.broadcast_to(fade, (len(parts[-1].echoes), len(spoke))))
        if not parts:
            return None
        echoes = BodyEchoes.joined([part.echoes for part in parts])
        return ObservedEchoes(echoes, np.concatenate([part.position for part in parts]), np.concatenate(fades))

    def _node(self, n: int, spoke: int, time: float) -> ObservedEchoes:
        """The echoes of body n as it is at a spoke, where those bodies occlude that are present at `time` [s]."""
        state = self._line_of_sight.presences.state(time)
        return self._nodes.get((n, spoke, state), lambda: self.evaluated(n, spoke, time))

    def crossing(self, n: int, turns: float) -> int:
        """The spoke, numbered from the start, at which the beam points at body n, within a quarter of a scan of `turns` scans.

        A body that outruns the beam has no crossing: it gets a spoke that points north.
        """
        eighth = round(turns * 8.0)
        return self._crossings.get((n, eighth), lambda: self._found_crossing(n, eighth / 8.0))

    def nodes(self, n: int, crossing: int) -> Indices:
        """Spokes (M,), numbered from the start and rising, at which body n is evaluated around a crossing."""
        return self._schedules.get((n, crossing), lambda: self._scheduled(n, crossing))

    def first_nodes(self) -> list[Indices]:
        """The nodes of each body about its first crossing."""
        origin = self._scene.radar.origin
        turns = origin.scan + self._bearings(origin.time)[0] / (2.0 * np.pi) % 1.0
        return [self.nodes(n, self.crossing(n, float(turns[n]))) for n in range(len(self))]

    def passing(self, time: float, middle: float, half: float) -> list[tuple[int, int]]:
        """Bodies that the beam may cover within `half` of the bearing `middle` [rad], each with its crossing."""
        if not self._may_pass(time, middle, half):
            return []
        bearing, distance = self._bearings(time)
        off = wrap_angle(bearing - middle)
        near = np.abs(off) <= half + self._sway + _aside(self._radius, distance)
        turns = self._scene.radar.turns_at(time) + off / (2.0 * np.pi)
        return [(int(n), self.crossing(int(n), float(turns[n]))) for n in np.flatnonzero(near)]

    def _may_pass(self, time: float, middle: float, half: float) -> bool:
        """A quick test for `passing`: whether any body may be there, wherever it is during the slot of time."""
        number = int(time * SLOTS // self._scene.radar.rotation_period)
        bearing, aside = self._sectors.get(number, lambda: self._slot_sectors(number))
        return bool((np.abs(wrap_angle(bearing - middle)) <= half + self._sway + aside).any())

    def _slot_sectors(self, number: int) -> tuple[Floats, Floats]:
        """Sectors (2 N,) that no body leaves during a slot: bearings of its middle at both ends, and half the widths [rad]."""
        slot = self._scene.radar.rotation_period / SLOTS
        ends = [self._bearings(max(each, 0) * slot) for each in (number, number + 1)]
        bearing, distance = (np.concatenate(parts) for parts in zip(*ends, strict=True))
        return bearing, _aside(np.tile(self._radius + self._speed * slot + self._swing, 2), distance)

    def _found_crossing(self, n: int, start: float) -> int:
        """As `crossing`, from a start [turns]."""
        turns, ahead, radar = start, np.inf, self._scene.radar
        for _ in range(MAX_ITERATIONS):
            (position,), _ = self._track(n, np.array([radar.time_of_turns(turns)]))
            ahead = float(wrap_angle(np.arctan2(position[0], position[1]) - 2.0 * np.pi * turns) / (2.0 * np.pi))
            turns += ahead
            if abs(ahead) < CONVERGED:
                break
        lost = abs(ahead) * radar.azimuths > 1.0 or abs(turns - start) > 1.0
        return round(start) * radar.azimuths if lost else round(turns * radar.azimuths)

    def _scheduled(self, n: int, crossing: int) -> Indices:
        """As `nodes`, computed anew."""
        radar = self._scene.radar
        (position,), _ = self._track(n, np.array([radar.time_of_spokes(float(crossing))]))
        aside = float(_aside(self._radius[n], np.hypot(position[0], position[1])))
        reach = min(MARGIN * (self._reach + self._sway + aside), np.pi) / radar.azimuth_step
        offset = np.linspace(-reach, reach, SAMPLES)
        rate = self._phase_rate(n, radar.time_of_spokes(crossing + offset)) * radar.spoke_period  # rad per spoke
        if float(np.max(rate)) * self._held_spokes(reach, aside) <= 1.0:
            return np.array([crossing])
        gain, half = self._gain(np.abs(offset) * radar.azimuth_step - aside), SAMPLES // 2
        held = rate * (reach - np.abs(offset)) * gain <= HELD_PHASE
        for phase, power in ((CUBIC_PHASE, 4), (MAX_PHASE, 2)):
            spacing = np.maximum(1.0, MAIN_BEAM / gain) ** (1.0 / power) * phase / np.maximum(rate, phase / reach / 2.0)
            first = max(1, int(spacing[half - 1 : half + 2].min()))
            before = outward_nodes(offset[half:], spacing[half::-1], held[half::-1], first // 2)
            after = outward_nodes(offset[half:], spacing[half:], held[half:], first - first // 2)
            if len(before) + len(after) >= CUBIC:
                break
        return crossing + np.concatenate([-before[::-1], after])

    def _held_spokes(self, reach: float, aside: float) -> float:
        """The inverse of the rate [spokes/rad] up to which one node serves a whole passage.

        reach: half its length [spokes]; aside: half the angle that the body fills [rad].
        """
        spoke = np.linspace(0.0, reach, 16 * SAMPLES)
        gain = self._gain(spoke * self._scene.radar.azimuth_step - aside)
        spread = np.sqrt(np.sum((spoke * gain) ** 2) / np.sum(gain**2))
        return float(max(spread / HELD_PHASE, spoke[gain >= MAIN_BEAM].max() / EDGE_PHASE))

    def _phase_rate(self, n: int, time: Floats) -> Floats:
        """Rates (K,) [rad/s] at which the ends of what an echo of body n stands for change their phase against its middle."""
        aspect, radar = self._aspects[n], self._scene.radar
        position, heading = self._track(n, time)
        distance = np.linalg.norm(position, axis=1)
        velocity = np.gradient(position, time, axis=0)
        radial = np.einsum("ij,ij->i", velocity, position) / np.maximum(distance, 1e-9)
        speed = np.linalg.norm(velocity, axis=1)
        across = np.sqrt(np.maximum(speed**2 - radial**2, 0.0)) + np.abs(radial) * np.minimum(
            1.0, self._radius[n] / distance
        )
        nearest = np.maximum(distance - self._radius[n], NEAREST)
        rate = np.abs(np.gradient(np.unwrap(heading), time)) + np.minimum(across, speed) / nearest
        sway = self._bodies[n].motion.sway
        if sway is not None:
            rate += self._tilt_rate(n, position, heading, nearest)
        if self._scene.environment.multipath:
            rate += 2.0 * radar.height * np.abs(radial) / nearest**2  # of the reflected ray against the direct one
        coherence = min(self._size[n], aspect.model.coherence(aspect.local, float(distance[len(distance) // 2])))
        wavenumber = 2.0 * np.pi / radar.wavelength
        if sway is None:
            return np.asarray(wavenumber * coherence * rate)
        return np.asarray(wavenumber * (coherence * rate + 4.0 * waterline_rise(self._bodies[n]) * radar.height / nearest))

    def _tilt_rate(self, n: int, position: Floats, heading: Floats, nearest: Floats) -> Floats:
        """Rates (K,) [rad/s] at which roll and pitch turn body n against the line of sight, at most: aspects are no farther apart
        where it rests a moment. A rotation about the line of sight changes no phase.

        position: (K, 3) relative to the antenna [m]; nearest: distance of the nearest part (K,) [m].
        """
        sway = self._bodies[n].motion.sway
        assert sway is not None
        roll, pitch, _, _ = sway.max_rates
        off_bow = np.arctan2(position[:, 0], position[:, 1]) - heading
        spread = (self._radius[n] + np.abs(position[:, 2]) + self._scene.radar.height) / nearest + np.sin(sway.max_tilt)
        about_bow, about_beam = (np.minimum(np.abs(part) + spread, 1.0) for part in (np.sin(off_bow), np.cos(off_bow)))
        return np.asarray(roll * about_bow + pitch * about_beam)

    def _gain(self, offset: Floats) -> Floats:
        """The highest one-way gain (K,) beyond offsets from boresight [rad]; 1 where the full circle of the beam counts."""
        if self._extent >= np.pi:
            return np.ones_like(offset)
        return np.interp(offset, np.linspace(0.0, np.pi, len(self._envelope)), self._envelope)

    def evaluated(self, n: int, spoke: int, presence_time: float) -> ObservedEchoes:
        """The echoes of body n as it is at a spoke, computed anew; presence_time: as of `_node`."""
        model, local, body = self._aspects[n]
        time = self._scene.radar.time_of_spokes(float(spoke))
        instant = Instant(time, self._line_of_sight.as_of(presence_time), self._max_range)
        echoes = model.body_echoes(local, self._scene.antenna(time)[0], instant)
        poses = self._poses.at(np.array([time]))
        position = poses.map_from_bodies(0, echoes.position, np.full(len(echoes), n))
        return ObservedEchoes(replace(echoes, body=np.full(len(echoes), body)), position)

    def _bearings(self, time: float) -> tuple[Floats, Floats]:
        """Bearings (N,) [rad] and ground distances (N,) [m] of the middles of all bodies."""
        poses = self._poses.at(np.array([time]))
        middle = poses.map_from_bodies(0, self._middle, np.arange(len(self)))
        east, north, _ = (middle - self._scene.antenna(time)[0]).T
        return np.arctan2(east, north), np.hypot(east, north)

    def _track(self, n: int, time: Floats) -> tuple[Floats, Floats]:
        """Middle of body n relative to the antenna (K, 3) [m] and its heading (K,) [rad] at each time (K,) [s]."""
        body = self._bodies[n]
        return body.middles_at(time) - self._scene.antenna(time), body.motion.pose(time).heading


def _aside(radius: Floats, distance: Floats) -> Floats:
    """Half the angles that bodies of some radii fill at ground distances (N,) [rad]; all round for an antenna near one."""
    angle = np.arcsin(np.minimum(1.0, radius / np.maximum(distance, NEAREST)))
    return np.where(distance <= radius + NEAREST, np.pi, angle)


def _sidelobe_envelope(radar: Radar) -> Floats:
    """The highest one-way gain from each offset on, evenly from 0 to half a circle."""
    count = int(np.pi / radar.beamwidth * GAINS_PER_BEAMWIDTH) + 2
    gain = radar.azimuth_gain(np.linspace(0.0, np.pi, count))
    return np.asarray(np.maximum.accumulate(gain[::-1])[::-1])
