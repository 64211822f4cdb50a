"""Echoes that differ from azimuth to azimuth: of bodies that move relative to the antenna, and of those that fluctuate.

Range, phase and beam weight are exact at each azimuth. Visibility and scattering are renewed once per visibility step
(`echo.visibility`), elevation gain and multipath once per call.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, concatenated
from radar_service.echo.moving_beam import BeamTable, rotated_amplitude
from radar_service.echo.range_history import (
    TOLERANCE,
    Parabola,
    RangeHistory,
    apparent_position,
    elevation_of,
    exact_history,
    interpolated_history,
    interpolation_error,
    parabola,
)
from radar_service.echo.visibility import Visibility, VisibilitySnapshot
from radar_service.frames import polar_from_map, wrap_angle
from radar_service.propagation.radar_equation import elevation_gain, path_factor, received_amplitude, two_way_phase
from radar_service.scattering.swerling import Fluctuation
from radar_service.scene.poses import BodyPoses, PoseArrays, map_from_bodies
from radar_service.scene.world import Scene
from radar_service.types import Flags, Floats, Indices, Singles

ELEVATION_NULL = 1e-3  # of boresight: elevation gains below it do not divide
ECHOES_PER_PART = 8192  # arrays of 16 azimuths by so many echoes stay in the L2 cache


class BlockGeometry(NamedTuple):
    """Geometry of some azimuths (K,), first at the three nodes of their parabola, then at each of them.

    azimuths: the azimuths.
    over: the parabola over their times.
    poses: of the bodies (3 + K, B).
    antenna: (3 + K, 3) on the map [m].
    level: (3 + K, 3, 3) as `Scene.upright_from_map`; None for an antenna that does not sway.
    rough: (B,) which bodies leave their parabola.
    """

    azimuths: AzimuthTimes
    over: Parabola
    poses: PoseArrays
    antenna: Floats
    level: Floats | None
    rough: Flags


class MovingEchoes:
    """All moving echoes of a scene, at any azimuths. Safe to call from several threads."""

    def __init__(self, scene: Scene, visibility: Visibility, beam: BeamTable, seed: int) -> None:
        """beam: its extent is how far off boresight echoes count."""
        self._scene, self.visibility, self._beam = scene, visibility, beam
        self._bodies = visibility.scatterers.bodies
        self._earth_radius = visibility.line_of_sight.earth_radius
        self._poses = BodyPoses(self._bodies)
        self._moves: Flags = np.zeros(len(self._bodies), dtype=np.bool_)
        self._moves[self._poses.moving] = True
        self._fluctuation = Fluctuation(self._bodies, scene.name, scene.radar.azimuths, seed)

    def __len__(self) -> int:
        """How many bodies there are."""
        return len(self._bodies)

    def snapshot(self, number: int) -> VisibilitySnapshot:
        """The visibility snapshot of the step of that number."""
        return self.visibility.snapshot(number, self._beam.extent + self._beam.span)

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """All echoes within the beam's extent of any of these azimuths."""
        snapshot = self.snapshot(int(azimuths.middle // self.visibility.interval))
        middle, half = self._sector(azimuths)
        around = snapshot.around(middle, half + self.visibility.bearing_drift)
        if not len(around):
            return concatenated([], len(azimuths.time))
        geometry = self._geometry(azimuths, np.flatnonzero(np.bincount(snapshot.echoes.body[around])))
        (positions,) = self._positions(snapshot, around, geometry, [1])
        observed = positions if geometry.level is None else positions @ geometry.level[1].T
        chosen = around[_within(observed, middle, half)]
        count = ECHOES_PER_PART
        parts = [self._part(snapshot, chosen[i : i + count], geometry) for i in range(0, len(chosen), count)]
        return concatenated(parts, len(azimuths.time))

    def _sector(self, azimuths: AzimuthTimes) -> tuple[float, float]:
        """The middle boresight, and half the width of all that the beam covers at any of the azimuths [rad]."""
        middle = azimuths.boresight[len(azimuths.boresight) // 2]
        return float(middle), float(self._beam.extent + np.abs(azimuths.boresight - middle).max())

    def _geometry(self, azimuths: AzimuthTimes, bodies: Indices) -> BlockGeometry:
        """The geometry of these azimuths, as far as it concerns `bodies` (N,)."""
        over = parabola(azimuths.time)
        time = np.concatenate([over.nodes, azimuths.time])
        poses, antenna = self._poses.at(time, bodies), self._scene.antenna(time)
        rough = self._rough(poses, antenna, over, bodies[self._moves[bodies]])
        return BlockGeometry(azimuths, over, poses, antenna, self._scene.upright_from_map(time), rough)

    def _part(self, snapshot: VisibilitySnapshot, which: Indices, geometry: BlockGeometry) -> BeamWeightedEchoes:
        """Some of the echoes, indices `which` (E,) into the snapshot."""
        body, earth, level = snapshot.echoes.body[which], self._earth_radius, geometry.level
        nodes = self._positions(snapshot, which, geometry, range(3))
        polar = polar_from_map(nodes[1], np.zeros(3), earth)
        apparent = nodes if level is None else [apparent_position(nodes[n], level[n], earth) for n in range(3)]
        azimuth = polar.azimuth if level is None else np.arctan2(apparent[1][:, 0], apparent[1][:, 1])
        elevation = polar.elevation if level is None else elevation_of(apparent[1])
        history, near = interpolated_history(nodes, apparent, polar.range, earth, geometry.over)
        exact = np.flatnonzero(near | geometry.rough[body])
        exact_gain = self._exact_history(history, exact, snapshot, which, geometry, azimuth, elevation)
        weight = self._beam_weight(history, azimuth, geometry.azimuths)
        self._fluctuation.apply(weight, geometry.azimuths.number, azimuth, body)
        if level is not None:
            ends = elevation_of(apparent[0]), elevation_of(apparent[2])
            relative = self._elevation_change(ends[0], elevation, ends[1], geometry.over)
            relative[exact] = 1.0
            weight *= relative
        weight[exact] *= exact_gain
        radar = self._scene.radar
        if level is not None:
            radar = replace(radar, height=float(geometry.antenna[1, 2]))
        height = nodes[1][:, 2] + geometry.antenna[1, 2]
        path = path_factor(radar, self._scene.environment, polar, height, elevation - polar.elevation)
        middle = snapshot.echoes.amplitude[which] * path
        middle *= received_amplitude(radar, polar.range) * two_way_phase(polar.range, radar.wavelength)
        amplitude = rotated_amplitude(middle, weight, history.range_migration, radar.wavelength)
        return BeamWeightedEchoes(polar.range, history.range_migration, amplitude)

    def _exact_history(
        self,
        history: RangeHistory,
        exact: Indices,
        snapshot: VisibilitySnapshot,
        which: Indices,
        geometry: BlockGeometry,
        azimuth: Floats,
        elevation: Floats,
    ) -> Singles:
        """Writes the exact history of echoes `exact` (W,) and returns their elevation gains (W, K) over those at the middle,
        where they are at `azimuth` and `elevation` (E,) [rad]."""
        if not len(exact):
            return np.ones((0, len(geometry.azimuths.time)), dtype=np.float32)
        positions = np.stack(self._positions(snapshot, which[exact], geometry, range(3, len(geometry.antenna))))
        level = None if geometry.level is None else geometry.level[3:]
        each = exact_history(history, exact, positions, level, azimuth[exact], self._earth_radius)
        middle, gain = (elevation_gain(self._scene.radar, angle) for angle in (elevation[exact], each))
        relative = np.where(middle[:, None] < ELEVATION_NULL, 1.0, gain / np.maximum(middle, ELEVATION_NULL)[:, None])
        return relative.astype(np.float32)

    def _beam_weight(self, history: RangeHistory, azimuth: Floats, azimuths: AzimuthTimes) -> Singles:
        """Beam weights (E, K) by the change of range loss since the middle, where echoes are at `azimuth` (E,) [rad]."""
        middle = azimuths.boresight[len(azimuths.boresight) // 2]
        offset = (azimuths.boresight - middle).astype(np.float32) - history.azimuth_change
        offset += wrap_angle(middle - azimuth).astype(np.float32)[:, None]
        weight = self._beam(offset)
        nearest = np.maximum(history.range, self._scene.radar.range_min)
        relative = history.range_migration * (1.0 / nearest).astype(np.float32)[:, None]
        relative += np.float32(1.0)
        weight /= np.square(relative, out=relative)
        return weight

    def _elevation_change(self, first: Floats, middle: Floats, last: Floats, over: Parabola) -> Singles:
        """Elevation gain (E, K) of an antenna that sways over that at the middle, by elevations (E,) [rad]; 1 about nulls."""
        gains = [elevation_gain(self._scene.radar, elevation) for elevation in (first, middle, last)]
        null = gains[1] < ELEVATION_NULL
        for gain in gains:
            gain[null] = 1.0
        return over.change(gains[0] / gains[1] - 1.0, gains[2] / gains[1] - 1.0) + np.float32(1.0)

    def _positions(
        self, snapshot: VisibilitySnapshot, which: Indices, geometry: BlockGeometry, instants: Iterable[int]
    ) -> list[Floats]:
        """Positions (E, 3) of echoes `which` relative to the antenna, along the map's axes [m], at some instants of a block."""
        position, body = snapshot.position[which], snapshot.echoes.body[which]
        moving = np.flatnonzero(self._moves[body])
        points, mover = snapshot.echoes.position[which[moving]], body[moving]
        positions = []
        for n in instants:
            positions.append(position - geometry.antenna[n])
            if len(moving):
                moved = map_from_bodies(points, mover, geometry.poses.position[n], geometry.poses.heading[n])
                positions[-1][moving] = moved - geometry.antenna[n]
        return positions

    def _rough(self, poses: PoseArrays, antenna: Floats, over: Parabola, moving: Indices) -> Flags:
        """Which bodies (B,) leave their parabola as the antenna observes them: those of `moving` (N,) at a corner of a track."""
        own = interpolation_error(antenna[3:], antenna[:3], over)
        rough = np.full(len(self._moves), bool(own > TOLERANCE))
        if len(moving) and not own > TOLERANCE:
            position, heading = poses.position[:, moving], np.unwrap(poses.heading[:, moving], axis=0)[..., None]
            arm = np.array([self._bodies[b].arm for b in moving])
            away = interpolation_error(position[3:], position[:3], over)
            away = away + arm * interpolation_error(heading[3:], heading[:3], over)
            rough[moving] = away > TOLERANCE
        return rough


def _within(position: Floats, middle: float, half: float) -> Flags:
    """Which positions (M, 3) relative to the antenna lie within `half` of the bearing `middle` [rad]."""
    if half >= np.pi:
        return np.ones(len(position), dtype=np.bool_)
    ahead = position[:, 0] * np.sin(middle) + position[:, 1] * np.cos(middle)
    distance = np.sqrt(position[:, 0] ** 2 + position[:, 1] ** 2)
    return np.asarray(ahead >= distance * np.cos(half))
