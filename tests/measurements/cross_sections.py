"""Effective cross-sections of a metal body at instants, in process: no beam, no receiver, no noise.

The sum of the body's echoes with the phase of their paths, over what 1 m^2 in free space at the body's range would return.
"""

from collections.abc import Sequence

import numpy as np

import radar_service as rs
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.numerics.frames import effective_earth_radius, polar_from_map
from radar_service.numerics.types import Complexes, Floats
from radar_service.propagation.radar_equation import attenuation
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.scattering.model import Instant, ScatteringContext
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.poses import pose_at


def fields(scene: rs.Scene, times: Sequence[float] | Floats, fidelity: Fidelity = PRESETS["balanced"]) -> Complexes:
    """Roots of the effective cross-sections [m] of the first body at times (K,) [s], with the phase about its origin."""
    earth = effective_earth_radius(scene.environment.earth_factor)
    context = ScatteringContext(scene.radar, fidelity, 0, scene.antenna(0.0)[0], scene.environment, scene.bodies, earth)
    model, line_of_sight = PhysicalOptics.build(scene.bodies[:1], np.arange(1), context), OcclusionScene(scene.bodies, earth)
    return np.array([_field(scene, model, line_of_sight, float(time)) for time in times])


def _field(scene: rs.Scene, model: PhysicalOptics, line_of_sight: OcclusionScene, time: float) -> complex:
    (antenna,) = scene.antenna(time)
    echoes = model.body_echoes(0, antenna, Instant(time, line_of_sight, 1e6))
    pose, earth = pose_at(scene.bodies[0], time), line_of_sight.earth_radius
    position = pose.map_from_frame(echoes.position)
    heights = np.full(len(position), antenna[2])
    paths = Paths(echoes.path, echoes.height_span)
    distance, factor = range_and_factor(
        scene.radar, scene.environment, polar_from_map(position, antenna, earth), position[:, 2], heights, paths
    )
    own = polar_from_map(np.atleast_2d(pose.position), antenna, earth).range
    phase = np.exp(-4j * np.pi / scene.radar.wavelength * (distance - own))
    free = attenuation(scene.radar, scene.environment, own)
    return complex(np.sum(echoes.amplitude * factor / free * (own / distance) ** 2 * phase))


def sections_dbsm(scene: rs.Scene, times: Sequence[float] | Floats) -> Floats:
    """Effective cross-sections (K,) [dBsm] of the first body at times (K,) [s]."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(fields(scene, times)), 1e-6)))
