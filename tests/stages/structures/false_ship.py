"""Indirect echoes of a ship by a funnel abeam of it, with one aspect a scan as the engine has them, or with every aspect."""

import math
from dataclasses import replace

import numpy as np

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.beam_paths import Beam
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes, BeamTable
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.second_time_around import max_echo_range
from radar_service.echo.visibility import Visibility
from radar_service.numerics.frames import effective_earth_radius
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import ScatteringContext
from radar_service.scattering.scatterer_set import build_scatterers
from radar_service.stages.registry import changed_pattern
from radar_service.stages.structures.reflection import HeldPassages, IndirectPaths
from radar_service.stages.structures.stage import SPAN
from radar_service.stages.structures.structure import Structure
from radar_service.trace.line_of_sight import OcclusionScene

BALANCED = PRESETS["balanced"]
DISTANCE, WIDTH = 10.0, 3.0  # m


class EveryAspect(BeamPassages):
    """Bodies evaluated anew at each azimuth, which is computed alone."""

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> list[ObservedEchoes]:
        (number,) = azimuths.number.tolist()
        return [self.evaluated(n, number, azimuths.middle) for n, _ in self.passing(azimuths.middle, middle, half)]


class FalseShip:
    """The indirect echoes of the only ship of a scene."""

    def __init__(self, ship: rs.Scene) -> None:
        offset = ship.bodies[0].middle_at(0.0) - ship.antenna(0.0)[0]
        self.bearing = math.atan2(offset[0], offset[1]) + 0.5 * math.pi  # of the funnel, as own ship heads north
        funnel = Structure("funnel", math.remainder(self.bearing, 2.0 * math.pi), DISTANCE, WIDTH / 2.0)
        radar, earth_radius = (
            replace(ship.radar, effects={"structures": (funnel,)}),
            effective_earth_radius(ship.environment.earth_factor),
        )
        self.scene = scene = replace(ship, radar=radar)
        context = ScatteringContext(radar, BALANCED, 0, scene.antenna(0.0)[0], scene.environment, scene.bodies, earth_radius)
        scatterers, occlusion = build_scatterers(scene.bodies, [0], context), OcclusionScene(scene.bodies, earth_radius)
        reach, self._extent = max_echo_range(radar), min(math.pi, BALANCED.beam_extent * radar.beamwidth)
        self._visibility = Visibility(scene, scatterers, occlusion, reach, BALANCED.visibility_step)
        direct = BeamPassages(scene, scatterers, occlusion, reach, self._extent)
        self.held = HeldPassages(scene, self._visibility, direct)
        self.every_aspect = EveryAspect(scene, scatterers, occlusion, reach, math.pi)

    def power(self, passages: BeamPassages, number: int) -> float:
        """The power at an azimuth: fields in cells of range, squared and summed."""
        radar, azimuth = self.scene.radar, np.array([number])
        beam = BeamTable(np.ones_like, radar.beamwidth, math.pi, SPAN)
        paths = [IndirectPaths(radar, Beam(radar, changed_pattern(radar, self._extent)), -2)]
        moving = MovingEchoes(self.scene, self._visibility, beam, 0, paths=paths, passages=passages)
        echoes = moving.echoes(AzimuthTimes(azimuth, *radar.schedule(azimuth)))
        cell = ((echoes.range[:, None] + echoes.range_migration) / radar.range_resolution).astype(np.int64).ravel()
        amplitude = echoes.amplitude.ravel()
        field = np.bincount(cell, amplitude.real) + 1j * np.bincount(cell, amplitude.imag)
        return float(np.sum(np.abs(field) ** 2))
