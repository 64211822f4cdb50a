"""Echoes of bodies whose echoes depend on aspect: evaluated at instants, the nodes, along each passage of the beam.

A passage is counted from the opposite bearing. Nodes lie on both sides of the crossing, the spoke nearest to where the boresight
points at the body. Between nodes the field is a sum of those of the nearest ones, each with its own exact range histories. A body
that hardly changes has one node. Where its course, or that of own ship, has a corner, a passage has parts, and no azimuth takes a
node of another part. Where a shadow moves over a body, nodes are as `ShadowRates` asks.

Echoes on a lattice follow the phases at their ends (`echo.aspect_rates`) to first order: a field held over the phase theta
errs by theta^2 / 3, one between two nodes theta apart by theta^2 / 12, of four nodes by theta^4 / 64.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from radar_service.echo.aspect_rates import AspectRates
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.passage_nodes import CUBIC_PHASE, MAIN_BEAM, Part, part_nodes, sidelobe_envelope, stretches
from radar_service.echo.shadow_nodes import Fields, ShadowRates, by_centre, by_range, telling_nodes
from radar_service.echo.visibility import mast_speed
from radar_service.numerics import Floats, Indices, ResultCache, wrap_angle
from radar_service.scattering import NEAREST, AspectModel, BodyEchoes, Caster, Instant, ScattererSet
from radar_service.trace import OcclusionScene
from radar_service.world import BodyPoses, Scene, pose_at

FAINT = 0.007  # one-way gain: an aspect that is wrong there errs by at most root 2 of it, -40 dB; the outer nodes are held
SHADOW_GAIN = 0.01  # one-way gain, below which shadows stay as they are: what they change is then 1 % of the field at most
NODES_PER_BODY = 48  # kept: those in use, and those of threads that are ahead
SLOTS = 2  # of a scan, at whose ends sectors of bodies are computed
MAIN_SLACK = 5.0  # times CHANGE that a field may be off at the edge of the main beam: 10 %, where 12 % are 1 dB
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
        self, scene: Scene, scatterers: ScattererSet, line_of_sight: OcclusionScene, max_range: float, extent: float,
        at_rest: bool = False,
    ) -> None:  # fmt: skip
        """max_range: beyond it no echo is received [m]; extent: offset from boresight beyond which echoes are left out [rad];
        at_rest: the bodies and the antenna rest; the echoes are what shadows of moving bodies add to what is seen without."""
        self._scene, self._line_of_sight, self._max_range = scene, line_of_sight, max_range
        self._aspects = [
            Aspect(model, local, int(body))
            for model in scatterers.aspect_models
            for local, body in enumerate(np.searchsorted(scatterers.key, model.key))
        ]
        bodies = [scatterers.bodies[aspect.body] for aspect in self._aspects]
        self.key = scatterers.key[[aspect.body for aspect in self._aspects]]  # in the scene
        self._bodies, self._poses = bodies, BodyPoses(bodies)
        self._middle = np.array([body.middle for body in bodies]).reshape(-1, 3)
        self._radius = np.array([body.radius for body in bodies])
        self._rates = [
            AspectRates(
                scene, body, body.radius, body.diagonal, partial(model.coherence, local), partial(model.upright, local)
            )
            for (model, local, _), body in zip(self._aspects, bodies, strict=True)
        ]
        self._shadows = [ShadowRates(scene, body) for body in bodies]
        self._own_speed = scene.own_ship.top_speed + mast_speed(scene)
        self._sway = 0.0 if scene.own_ship.sway is None else scene.own_ship.sway.max_tilt
        self._at_rest, self._moving = at_rest, set(line_of_sight.moving.keys.tolist())
        self._extent, self._envelope = extent, sidelobe_envelope(scene.radar)
        received = np.count_nonzero(self._envelope > FAINT) / len(self._envelope) * np.pi
        self._reach = extent if extent >= np.pi else min(extent, received)
        count = max(1, len(bodies))
        self._nodes: ResultCache[tuple[int, int, bytes], ObservedEchoes] = ResultCache(
            NODES_PER_BODY * count, scene.revision
        )
        self._schedules: ResultCache[tuple[int, int, bytes], tuple[Part, ...]] = ResultCache(4 * count, scene.revision)
        self._speed = np.array([body.top_speed for body in bodies]) + self._own_speed
        self._swing = 2.0 * np.hypot(self._middle[:, 0], self._middle[:, 1])  # m, by which turns move a middle at most
        self._alone: ResultCache[int, BodyEchoes] = ResultCache(count)  # at rest, as no mover shades them
        self._sectors: ResultCache[int, tuple[Floats, Floats]] = ResultCache(SLOTS, scene.revision)
        self._crossings: ResultCache[tuple[int, int], int] = ResultCache(8 * count, scene.revision)

    def __len__(self) -> int:
        return len(self._aspects)

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> list[ObservedEchoes]:
        """Echoes of all bodies that may lie within `half` of the bearing `middle` [rad] at these azimuths."""
        if not len(self):
            return []
        spoke, parts = self._scene.radar.spokes_at(azimuths.time), list[ObservedEchoes]()
        present = self._line_of_sight.present(azimuths.middle)[self.key]
        for n, crossing in self.passing(azimuths.middle, middle, half):
            for part in self.parts(n, crossing, azimuths.middle) if present[n] else ():
                weights = part.weights(spoke)
                if not weights.any():
                    continue
                for node, fade in zip(part.nodes.tolist(), weights, strict=True):
                    if fade.any():
                        observed = self.node(n, node, azimuths.middle)
                        parts.append(replace(observed, fade=np.broadcast_to(fade, (len(observed.echoes), len(spoke)))))
        return ObservedEchoes.joined(parts)

    def _placed(self, n: int, evaluated: Sequence[BodyEchoes], time: float) -> list[Floats]:
        """Positions (M, 3) of each of the echoes of body n on the map at `time` [s]."""
        pose = pose_at(self._bodies[n], time)
        return [pose.map_from_frame(echoes.position) for echoes in evaluated]

    def node(self, n: int, spoke: int, time: float) -> ObservedEchoes:
        """The echoes of body n as it is at a spoke, kept for all azimuths that need them; those bodies occlude that are present
        at `time` [s]."""
        key = n, spoke, self._line_of_sight.presences.state(time)
        return self._nodes.get(key, lambda: self.evaluated(n, spoke, time))

    def _observed(self, spoke: int, presence_time: float) -> tuple[Floats, Instant]:
        """The antenna (3,) and the instant of a spoke, with the bodies that are present at `presence_time` [s]."""
        time = self._scene.radar.time_of_spokes(float(spoke))
        instant = Instant(time, self._line_of_sight.as_of(presence_time), self._max_range)
        return self._scene.antenna(time)[0], instant

    def crossing(self, n: int, turns: float) -> int:
        """The spoke, numbered from the start, at which the beam points at body n, within a quarter of a scan of `turns` scans.

        A body that outruns the beam has no crossing: it gets a spoke that points north.
        """
        eighth = round(turns * 8.0)
        return self._crossings.get((n, eighth), lambda: self._found_crossing(n, eighth / 8.0))

    def parts(self, n: int, crossing: int, time: float | None = None) -> tuple[Part, ...]:
        """The parts of the passage of body n around a crossing, with the spokes at which it is evaluated; those bodies shade it
        that are present at `time` [s], None: at the crossing."""
        key, time = self._passage(n, crossing, time)
        return self._schedules.get(key, lambda: self._scheduled(n, crossing, time))

    def _passage(self, n: int, crossing: int, time: float | None) -> tuple[tuple[int, int, bytes], float]:
        """What a passage of body n depends on, and the time at which bodies are present [s]: `time`, None for the crossing's."""
        time = self._scene.radar.time_of_spokes(float(crossing)) if time is None else time
        return (n, crossing, self._line_of_sight.presences.state(time)), time

    def nodes(self, n: int, crossing: int, time: float | None = None) -> Indices:
        """Spokes (M,), numbered from the start and rising, at which body n is evaluated around a crossing. time: when
        bodies that shade it are present [s], None: at the crossing."""
        return np.concatenate([part.nodes for part in self.parts(n, crossing, time)])

    def passing(self, time: float, middle: float, half: float) -> list[tuple[int, int]]:
        """Bodies that the beam may cover within `half` of the bearing `middle` [rad], each with its crossing."""
        if not self._aspects or not len(some := self._may_pass(time, middle, half)):
            return []
        bearing, distance = self._bearings(time, some)
        off = wrap_angle(bearing - middle)
        near = np.abs(off) <= half + self._sway + _aside(self._radius[some], distance)
        turns = self._scene.radar.turns_at(time) + off / (2.0 * np.pi)
        return [(int(some[k]), self.crossing(int(some[k]), float(turns[k]))) for k in np.flatnonzero(near)]

    def _may_pass(self, time: float, middle: float, half: float) -> Indices:
        """A quick test for `passing`: which bodies (M,) may be there, wherever they are during the slot of time."""
        number = int(time * SLOTS // self._scene.radar.rotation_period)
        bearing, aside = self._sectors.get(number, lambda: self._slot_sectors(number))
        near = np.abs(wrap_angle(bearing - middle)) <= half + self._sway + aside
        return np.flatnonzero(near.reshape(2, -1).any(axis=0))

    def _slot_sectors(self, number: int) -> tuple[Floats, Floats]:
        """Sectors (2 N,) that no body leaves during a slot: bearings of its middle at both ends, and half the widths [rad]."""
        slot = self._scene.radar.rotation_period / SLOTS
        ends = [self._bearings(max(end, 0) * slot) for end in (number, number + 1)]
        bearing, distance = (np.concatenate(parts) for parts in zip(*ends, strict=True))
        return bearing, _aside(np.tile(self._radius + self._speed * slot + self._swing, 2), distance)

    def _found_crossing(self, n: int, start: float) -> int:
        """Computes `crossing` from a start [turns].

        A body may jump across the beam, as its heading has a corner: its crossing is between the spokes before and after."""
        turns, ahead, before, radar = start, np.inf, np.inf, self._scene.radar
        for _ in range(MAX_ITERATIONS):
            (position,), _ = self._rates[n].track(np.array([radar.time_of_turns(turns)]))
            before = ahead
            ahead = float(wrap_angle(np.arctan2(position[0], position[1]) - 2.0 * np.pi * turns) / (2.0 * np.pi))
            turns += ahead
            if abs(ahead) < CONVERGED:
                break
        if abs(ahead + before) * radar.azimuths < 1.0:
            turns, ahead = turns - ahead / 2.0, 0.0
        lost = abs(ahead) * radar.azimuths > 1.0 or abs(turns - start) > 1.0
        return round(start) * radar.azimuths if lost else round(turns * radar.azimuths)

    def _scheduled(self, n: int, crossing: int, time: float) -> tuple[Part, ...]:
        """Computes `parts` anew."""
        radar, rates, aside = self._scene.radar, self._rates[n], self._half_angle(n, crossing)
        reach = min(MARGIN * (self._reach + self._sway + aside), np.pi) / radar.azimuth_step
        around = np.arange(-int(reach) - 2, int(reach) + 3)
        corners = around[rates.corners(radar.time_of_spokes(crossing + around.astype(np.float64)), reach)]

        def away(offset: Floats) -> Floats:
            return np.abs(offset) * radar.azimuth_step - aside

        def gain(offset: Floats) -> Floats:
            return self._gain(away(offset))

        casters = self._casters(n, crossing, aside)
        if self._at_rest and not casters:
            return ()

        def motion(offset: Floats) -> Floats:
            return rates.phase_rate(radar.time_of_spokes(crossing + offset)) * radar.spoke_period

        def rate(offset: Floats) -> Floats:
            shadow = self._shadows[n].rate(casters, radar.time_of_spokes(crossing + offset)) * radar.spoke_period
            return motion(offset) + CUBIC_PHASE * shadow * np.minimum(self._envelope_gain(away(offset)) / MAIN_BEAM, 1.0)

        def slack(nodes: Indices) -> Floats:
            beam = np.maximum(gain((nodes - crossing).astype(np.float64)), FAINT)
            return np.minimum(1.0 / beam, MAIN_SLACK * np.maximum(MAIN_BEAM / beam, 1.0))

        def evaluate(spokes: Sequence[int], at: int) -> list[Fields]:
            evaluated = [self.node(n, spoke, time).echoes for spoke in spokes]
            if self._bodies[n].motion.sway is None:
                return [by_centre(echoes) for echoes in evaluated]
            then = radar.time_of_spokes(float(at))
            antenna, placed = self._scene.antenna(then), self._placed(n, evaluated, then)
            return [
                by_range(echoes, np.linalg.norm(position - antenna, axis=1), radar)
                for echoes, position in zip(evaluated, placed, strict=True)
            ]

        parts = []
        for stretch in stretches(corners.tolist(), reach):
            first, last = (
                crossing + stretch.first if stretch.begins else -np.inf,
                crossing + stretch.last if stretch.ends else np.inf,
            )
            nodes = crossing + part_nodes(stretch, gain, rate, self._extent >= np.pi)
            if casters and len(nodes) > 1:
                unshaded = crossing + part_nodes(stretch, gain, motion, self._extent >= np.pi)
                nodes = telling_nodes(nodes, unshaded, slack, evaluate, self._shadows[n].skipped)
            parts.append(Part(first, last, nodes))
        return tuple(parts)

    def _half_angle(self, n: int, crossing: int) -> float:
        """Half the angle that body n fills at a crossing [rad]."""
        (position,), _ = self._rates[n].track(np.array([self._scene.radar.time_of_spokes(float(crossing))]))
        return float(_aside(self._radius[n], np.hypot(position[0], position[1])))

    def _casters(self, n: int, crossing: int, aside: float, resting: bool = False) -> list[Caster]:
        """The bodies whose shadows may move over body n around a crossing, while its gain is above SHADOW_GAIN anywhere; aside:
        half the angle that it fills [rad]; resting: of moving bodies alone, as over one that rests."""
        radar, aspect = self._scene.radar, self._aspects[n]
        reach = np.count_nonzero(self._envelope > SHADOW_GAIN) / len(self._envelope) * np.pi + aside
        span = min(reach / radar.azimuth_step, radar.azimuths / 2.0) * radar.spoke_period
        time = radar.time_of_spokes(float(crossing))
        antenna = self._scene.antenna(time)[0]
        others = self._line_of_sight.other_occluders(int(self.key[n]), antenna, time, True, span, self._own_speed)
        if self._at_rest or resting:
            others = [other for other in others if other in self._moving]
        else:
            others = self._shadows[n].moving(others, time + span * np.array([-1.0, 0.0, 1.0]))
        if not others:
            return []
        among = {key: self._scene.bodies[key].moved_within(time, span) + span * self._own_speed for key in others}
        instant = Instant(time, self._line_of_sight, self._max_range)
        return aspect.model.casters(aspect.local, among, antenna, instant, self._bodies[n].moved_within(time, span))

    def _gain(self, offset: Floats) -> Floats:
        """The highest one-way gain (K,) beyond offsets from boresight [rad]; 1 where the full circle of the beam counts."""
        return np.ones_like(offset) if self._extent >= np.pi else self._envelope_gain(offset)

    def _envelope_gain(self, offset: Floats) -> Floats:
        return np.interp(offset, np.linspace(0.0, np.pi, len(self._envelope)), self._envelope)

    def evaluated(self, n: int, spoke: int, presence_time: float) -> ObservedEchoes:
        """The echoes of body n as it is at a spoke, shadowed by bodies that are present at `presence_time` [s]."""
        model, local, body = self._aspects[n]
        antenna, instant = self._observed(spoke, presence_time)
        echoes = model.body_echoes(local, antenna, instant)
        if self._at_rest:
            alone = self._alone.get(n, lambda: model.body_echoes(local, antenna, replace(instant, movers=False)))
            echoes = BodyEchoes.joined([echoes, replace(alone, amplitude=-alone.amplitude)])
        (position,) = self._placed(n, [echoes], instant.time)
        return ObservedEchoes(replace(echoes, body=np.full(len(echoes), body)), position)

    def _bearings(self, time: float, some: Indices | None = None) -> tuple[Floats, Floats]:
        """Bearings (M,) [rad] and ground distances (M,) [m] of the middles of some bodies (M,), None: of all."""
        poses, which = self._poses.at(np.array([time]), some), np.arange(len(self)) if some is None else some
        middle = poses.map_from_bodies(0, self._middle[which], which)
        east, north, _ = (middle - self._scene.antenna(time)[0]).T
        return np.arctan2(east, north), np.hypot(east, north)


def _aside(radius: Floats, distance: Floats) -> Floats:
    """Half the angles that bodies of some radii fill at ground distances (N,) [rad]; all round for an antenna near one."""
    angle = np.arcsin(np.minimum(1.0, radius / np.maximum(distance, NEAREST)))
    return np.where(distance <= radius + NEAREST, np.pi, angle)
