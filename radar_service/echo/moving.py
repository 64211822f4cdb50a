"""Echoes that differ from azimuth to azimuth: of bodies that move relative to the antenna, and of those that fluctuate.

Range, phase, sea reflection and beam weight are exact at each azimuth. Visibility is renewed once per visibility step
(`echo.visibility`), physical optics as the beam passes (`echo.beam_passage`).
"""

from collections.abc import Sequence

import numpy as np

from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.beam_paths import BeamPath, Sights
from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes, PartGeometry
from radar_service.echo.echoes import AzimuthTimes, BeamTable, BeamWeightedEchoes, concatenated, received_field
from radar_service.echo.range_history import (
    TOLERANCE,
    Parabola,
    RangeHistory,
    elevation_above,
    exact_history,
    interpolated_history,
    interpolation_error,
    parabola,
)
from radar_service.echo.sea_paths import Paths, SeaHistory, sea_paths
from radar_service.echo.visibility import Visibility, VisibilitySnapshot
from radar_service.numerics import Flags, Floats, Indices, Singles, wrap_angle
from radar_service.propagation import (
    LandBefore,
    Site,
    attenuation,
    elevation_gain,
    local_attenuation,
    radar_two_rays,
    received_amplitude,
)
from radar_service.scattering import BearingWedge, Fluctuation
from radar_service.world import BodyPoses, PoseArrays, Scene, SightLines

ELEVATION_NULL = 1e-3  # of boresight: elevation gains below it do not divide
FEW_ECHOES = 512  # around a tile: a block of their own takes longer than to compute them at twice as many azimuths
FAR = 400.0  # times the way within a block
ECHOES_PER_PART = 8192  # arrays of 16 azimuths by so many echoes stay in the L2 cache


class MovingEchoes:
    """All moving echoes of a scene, at any azimuths. Safe to call from several threads."""

    def __init__(
        self, scene: Scene, visibility: Visibility, beam: BeamTable, seed: int, at_rest: bool = False,
        paths: Sequence[BeamPath] = (), passages: BeamPassages | None = None,
    ) -> None:  # fmt: skip
        """beam: its extent is how far off boresight echoes count; at_rest: bodies and antenna rest; paths: by which echoes are
        received, with a beam of gain 1; none: directly, with that of the beam; passages: of the bodies by aspect; None: made
        here."""
        self._paths, self.separate = paths, False  # True: each echo has the bytes that it has alone
        self._scene, self.visibility, self._beam, self._seed, self._at_rest = scene, visibility, beam, seed, at_rest
        self._bodies = visibility.scatterers.bodies
        self._earth_radius = visibility.line_of_sight.earth_radius
        self._poses = BodyPoses(self._bodies)
        self._moves: Flags = np.zeros(len(self._bodies), dtype=np.bool_)
        self._moves[self._poses.moving] = True
        self._sways = any(motion.sway is not None for motion in (scene.own_ship, *(body.motion for body in self._bodies)))
        self._fluctuation = Fluctuation(self._bodies, scene.name, scene.radar.azimuths, seed, scene.own_id)
        self.passages = passages or BeamPassages(
            scene, visibility.scatterers, visibility.line_of_sight, visibility.max_range, beam.extent, at_rest
        )

    def __len__(self) -> int:
        """How many bodies there are."""
        return len(self._bodies)

    def snapshot(self, number: int, time: float | None = None) -> VisibilitySnapshot:
        """The visibility snapshot of a step; time: when those bodies are present that it shows [s], None: its middle.

        Blocks lie within a step, but those of earlier pulses begin before it.
        """
        before = self._beam.span if self._scene.radar.second_time_around else 0.0
        return self.visibility.snapshot(number, self._beam.extent + before, time)

    def drawn_power(self, body: int, number: int, azimuth: float) -> float | None:
        """The power factor drawn for a body, by its index in the scene, at an azimuth numbered from the start; None for one that
        does not fluctuate. azimuth: bearing of the body [rad]."""
        local = np.flatnonzero(self.visibility.scatterers.key == body)
        if not len(local) or not self._bodies[local[0]].swerling:
            return None
        weight = np.ones((1, 1), dtype=np.float32)
        self._fluctuation.apply(weight, np.array([number]), np.array([azimuth]), local)
        return float(weight[0, 0]) ** 2

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """All echoes within the beam's extent of any of these azimuths, over which no body comes or goes."""
        middle, half = self._sector(azimuths)
        observed_echoes: list[tuple[ObservedEchoes, Indices]] = []
        if not self._at_rest:
            snapshot, around = self._around(azimuths, middle, half)
            observed_echoes += [(snapshot, around)] if len(around) else []
        observed_echoes += [(passing, np.arange(len(passing.echoes))) for passing in self.passing(azimuths)]
        return self._weighted(azimuths, observed_echoes)

    def of_resting(self, azimuths: AzimuthTimes, observed: ObservedEchoes) -> BeamWeightedEchoes:
        """The echoes of `observed` at rest on the map that lie within the beam's extent of any of these azimuths."""
        return self._weighted(azimuths, [(observed, np.arange(len(observed.echoes)))])

    def _weighted(self, azimuths: AzimuthTimes, observed_echoes: list[tuple[ObservedEchoes, Indices]]) -> BeamWeightedEchoes:
        """The observed echoes, each with indices (M,), that lie within the beam's extent of any of these azimuths."""
        if not sum(len(which) for _, which in observed_echoes):
            return concatenated([], len(azimuths.time))
        middle, half = self._sector(azimuths)
        bodies = np.concatenate([observed.echoes.body[which] for observed, which in observed_echoes])
        geometry = self._geometry(azimuths, np.flatnonzero(np.bincount(bodies)))
        parts = [part for observed_part in observed_echoes for part in self._parts(*observed_part, geometry, middle, half)]
        echoes = concatenated([part for part, _ in parts], len(azimuths.time))
        if not self._paths or not parts:
            return echoes
        heading = self._scene.platform.heading(azimuths.time)
        sights = Sights(np.concatenate([bearing for _, bearing in parts]), azimuths.boresight, heading)
        return concatenated([path.received(echoes, sights) for path in self._paths], len(azimuths.time))

    def block_size(self, azimuths: AzimuthTimes, usual: int) -> int:
        """How many of these azimuths, all of one visibility step, to compute together: all where the beam meets few echoes.

        usual: where it meets many, as each is computed at all azimuths of a block; in a seaway and for bodies by aspect, which
        change faster; and within FAR times the way in a block, beyond which errors are less than in usual blocks nearer by.
        """
        if usual == 1 or len(azimuths.time) <= usual or self._sways or not len(self):
            return usual
        middle, half = self._sector(azimuths)
        snapshot, around = self._around(azimuths, middle, half)
        way = self.visibility.step * float(azimuths.time[-1] - azimuths.time[0]) / self.visibility.interval
        few = len(around) <= FEW_ECHOES and snapshot.nearest > FAR * way
        return len(azimuths.time) if few and not self.passages.passing(azimuths.middle, middle, half) else usual

    def passing(self, azimuths: AzimuthTimes) -> list[ObservedEchoes]:
        """Echoes of bodies by aspect that the beam passes at these azimuths."""
        return self.passages.echoes(azimuths, *self._sector(azimuths))

    def _parts(
        self, observed: ObservedEchoes, around: Indices, geometry: BlockGeometry, middle: float, half: float
    ) -> list[tuple[BeamWeightedEchoes, Floats]]:
        """The echoes `around` (M,) within `half` of the bearing `middle` [rad], in parts, with their bearings (E, K) [rad]."""
        (positions,) = geometry.positions(observed, around, [1])
        apparent = positions if geometry.level is None else positions @ geometry.level[1].T
        chosen = around[BearingWedge(np.zeros(3), middle, half, 0.0).contains(apparent)]
        count = ECHOES_PER_PART
        return [self._part(observed, chosen[i : i + count], geometry) for i in range(0, len(chosen), count)]

    def _around(self, azimuths: AzimuthTimes, middle: float, half: float) -> tuple[VisibilitySnapshot, Indices]:
        """The snapshot of these azimuths, and its echoes that may lie within `half` of the bearing `middle` [rad]."""
        snapshot = self.snapshot(int(azimuths.middle // self.visibility.interval), azimuths.middle)
        return snapshot, snapshot.around(middle, half + self.visibility.bearing_drift)

    def _sector(self, azimuths: AzimuthTimes) -> tuple[float, float]:
        """The middle boresight, and half the width of all that the beam covers at any of the azimuths [rad]."""
        first, middle, last = azimuths.boresight[[0, len(azimuths.boresight) // 2, -1]].tolist()
        return middle, self._beam.extent + max(abs(middle - first), abs(last - middle))

    def _geometry(self, azimuths: AzimuthTimes, bodies: Indices) -> BlockGeometry:
        """The geometry of these azimuths, as far as it concerns `bodies` (N,)."""
        over = parabola(azimuths.time, self.separate)
        time = np.concatenate([over.nodes, azimuths.time])
        antenna, uneven = self._scene.antenna(time), self._poses.uneven(time, bodies)
        own = 0.0 if self._scene.own_ship.is_even(time) else float(interpolation_error(antenna[3:], antenna[:3], over))
        poses = self._poses.at(time if len(uneven) else over.nodes, bodies)
        rough = self._rough(poses, own > TOLERANCE, over, uneven)
        return BlockGeometry(azimuths, over, poses, antenna, self._scene.upright_from_map(time), rough, self._moves)

    def _part(self, observed: ObservedEchoes, which: Indices, block: BlockGeometry) -> tuple[BeamWeightedEchoes, Floats]:
        """Some of the echoes, indices `which` (E,) into those observed, and for paths their bearings (E, K) [rad]."""
        radar, earth = self._scene.radar, self._earth_radius
        part = PartGeometry.of(observed, which, block, earth)
        distance = part.polar.range
        history, near = interpolated_history(part.nodes, part.apparent, distance, earth, block.over)
        sea = self._sea_history(observed, which, part, block)
        if sea is not None:
            near |= sea.middle.steep(radar, history.range_migration, distance) | sea.rising
        exact = np.flatnonzero(near | block.rough[observed.echoes.body[which]])
        exact_gain = self._exact_history(history, sea, observed, which, exact, part, block) if len(exact) else None
        weight = self._beam_weight(history, part.azimuth, block.azimuths)
        self._fluctuation.apply(weight, block.azimuths.number, part.azimuth, observed.echoes.body[which])
        if observed.fade is not None and observed.fade.dtype == weight.dtype:
            weight *= observed.fade[which].real
        if block.level is not None:
            relative = self._elevation_change(part.elevations(), block.over)
            relative[exact] = 1.0
            weight *= relative
        if exact_gain is not None:
            weight[exact] *= exact_gain
        middle = observed.echoes.amplitude[which] * received_amplitude(radar, distance)
        middle *= attenuation(radar, self._scene.environment, distance)
        if self._scene.environment.attenuators:
            lines = SightLines(block.antenna[1], float(block.over.nodes[1]), part.azimuth, distance)
            middle *= local_attenuation(radar, self._scene.environment, lines)
        middle *= elevation_gain(radar, part.elevation) if sea is None else sea.held_factor()
        if sea is not None:
            distance = sea.add_excess(distance, history.range_migration)
        amplitude = received_field(middle, distance, weight, history.range_migration, radar.wavelength)
        if observed.fade is not None and observed.fade.dtype == amplitude.dtype:
            amplitude *= observed.fade[which]
        if sea is not None:
            sea.apply(amplitude)
        body = self.visibility.scatterers.key[observed.echoes.body[which]]
        echoes = BeamWeightedEchoes(distance, history.range_migration, amplitude, body)
        return echoes, part.azimuth[:, None] + history.azimuth_change if self._paths else part.azimuth

    def _sea_history(
        self, observed: ObservedEchoes, which: Indices, part: PartGeometry, block: BlockGeometry
    ) -> SeaHistory | None:
        """The interpolated paths by the sea of echoes `which` (E,); None where the sea does not reflect."""
        radar, environment, earth = self._scene.radar, self._scene.environment, self._earth_radius
        if not environment.multipath:
            return None
        tilt_error = 0.0 if block.level is None else part.elevation - part.polar.elevation
        paths = Paths(observed.echoes.path[which], observed.echoes.height_span[which])
        sites = [_site(node, height) for node, height in zip(part.nodes, block.antenna[:3, 2], strict=True)]
        body = self.visibility.scatterers.key[observed.echoes.body[which]]
        land = LandBefore(self.visibility.line_of_sight, block.antenna[1], part.nodes[1], body)
        middle = sea_paths(radar, environment, sites[1], paths, tilt_error, land)
        sea = SeaHistory.interpolated(middle, sites, earth, block.over)
        if block.level is not None:
            errors = [
                angle - elevation_above(node, earth) for angle, node in zip(part.elevations(), part.nodes, strict=True)
            ]
            sea.sway(radar, errors, block.over)
        return sea

    def _exact_history(
        self,
        history: RangeHistory,
        sea: SeaHistory | None,
        observed: ObservedEchoes,
        which: Indices,
        exact: Indices,
        part: PartGeometry,
        block: BlockGeometry,
    ) -> Singles:
        """Writes the exact history of echoes which[exact] (W,) and returns their elevation gains (W, K) over the middle's."""
        radar, earth = self._scene.radar, self._earth_radius
        if len(block.poses.position) < len(block.antenna):  # at the nodes alone
            time, bodies = np.concatenate([block.over.nodes, block.azimuths.time]), observed.echoes.body[which[exact]]
            block = block._replace(poses=self._poses.at(time, np.flatnonzero(np.bincount(bodies))))
        positions = np.stack(block.positions(observed, which[exact], range(3, len(block.antenna))))
        level = None if block.level is None else block.level[3:]
        each = exact_history(history, exact, positions, level, part.azimuth[exact], earth)
        if sea is not None:
            tilt_error = each.T - elevation_above(positions, earth)
            site = _site(positions, block.antenna[3:, 2, None])
            body = self.visibility.scatterers.key[observed.echoes.body[which[exact]]]
            land = LandBefore(self.visibility.line_of_sight, block.antenna[3:, None], positions, body)
            return sea.replace(exact, radar_two_rays(radar, self._scene.environment, *site, tilt_error, land))
        middle, gain = (elevation_gain(radar, angle) for angle in (part.elevation[exact], each))
        relative = np.where(middle[:, None] < ELEVATION_NULL, 1.0, gain / np.maximum(middle, ELEVATION_NULL)[:, None])
        return relative.astype(np.float32)

    def _beam_weight(self, history: RangeHistory, azimuth: Floats, azimuths: AzimuthTimes) -> Singles:
        """Beam weights (E, K) by the change of range loss since the middle, where echoes are at `azimuth` (E,) [rad]."""
        middle = azimuths.boresight[len(azimuths.boresight) // 2]
        boresight, before = (azimuths.boresight - middle).astype(np.float32), wrap_angle(middle - azimuth).astype(np.float32)
        nearness = (1.0 / np.maximum(history.range, self._scene.radar.range_min)).astype(np.float32)
        return self._beam.weights(boresight, before, history.azimuth_change, nearness, history.range_migration)

    def _elevation_change(self, elevations: list[Floats], over: Parabola) -> Singles:
        """Elevation gain (E, K) over that at the middle, by elevations (E,) at the three nodes [rad]; 1 about nulls."""
        gains = [elevation_gain(self._scene.radar, elevation) for elevation in elevations]
        null = gains[1] < ELEVATION_NULL
        for gain in gains:
            gain[null] = 1.0
        return over.change(gains[0] / gains[1] - 1.0, gains[2] / gains[1] - 1.0) + np.float32(1.0)

    def _rough(self, poses: PoseArrays, own: bool, over: Parabola, uneven: Indices) -> Flags:
        """Which bodies (B,) leave their parabola as the antenna observes them: those of `uneven` (N,) at a corner of a track,
        or all where own ship is at one."""
        rough = np.full(len(self._moves), own)
        if len(uneven) and not own:
            position, heading = poses.position[:, uneven], np.unwrap(poses.heading[:, uneven], axis=0)[..., None]
            arm = np.array([self._bodies[b].arm for b in uneven])
            away = interpolation_error(position[3:], position[:3], over)
            away = away + arm * interpolation_error(heading[3:], heading[:3], over)
            for n, b in enumerate(uneven.tolist()):
                if b in poses.rotation:
                    entries = poses.rotation[b].reshape(-1, 1, 9)
                    away[n] += 3.0 * arm[n] * interpolation_error(entries[3:], entries[:3], over)[0]
            rough[uneven] = away > TOLERANCE
        return rough


def _site(position: Floats, antenna_height: Floats) -> Site:
    """Positions (..., 3) relative to the antenna as `specular_geometry` takes them."""
    return np.hypot(position[..., 0], position[..., 1]), position[..., 2] + antenna_height, antenna_height
