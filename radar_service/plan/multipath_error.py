"""The error of holding the phase of sea reflection over a block of azimuths, for moving echoes."""

import math

import numpy as np

from radar_service.frames import effective_earth_radius
from radar_service.propagation.multipath import specular_geometry, two_ray_factor
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.scene.body import Body
from radar_service.scene.world import Scene

RAMP = 0.67  # rms of 2 F m dphi over rms of F^2, phases even and m = 1: 2 sqrt(2) / sqrt(6), over sqrt(3) of a ramp
MIN_DISTANCE = 10.0  # m


def multipath_error_db(scene: Scene, azimuths_per_block: int) -> float:
    """Relative field error [dB] of taking the phase of sea reflection from the middle of each block of azimuths.

    It is the maximum over all moving bodies, each at its position at time 0. It is -inf without multipath or motion.
    """
    if azimuths_per_block == 1 or not scene.environment.multipath:
        return -math.inf
    seconds = (azimuths_per_block - 1) / 2.0 * scene.radar.spoke_period
    maximum = max((_relative_change(body, scene, seconds) for body in scene.bodies), default=0.0)
    return 20.0 * math.log10(maximum) if maximum > 0.0 else -math.inf


def _relative_change(body: Body, scene: Scene, seconds: float) -> float:
    """Relative change of F^2 within some seconds [s], for the highest points of a body that approaches radially."""
    moved = (scene.own_ship.top_speed + body.motion.top_speed) * seconds
    if moved == 0.0:
        return 0.0
    radar, earth_radius = scene.radar, effective_earth_radius(scene.environment.earth_factor)
    offset = body.middle_at(0.0) - scene.antenna(0.0)[0]
    distance = max(MIN_DISTANCE, math.hypot(offset[0], offset[1]) - body.radius)
    height = body.motion.position[0, 2] + (0.0 if body.mesh is None else float(body.mesh.vertices[:, 2].max()))
    excess = specular_geometry(np.array([distance, distance + moved]), height, radar.height, earth_radius).excess
    phase_change = 2.0 * math.pi / radar.wavelength * abs(float(excess[1] - excess[0]))
    wave_height = rms_wave_height(scene.environment.sea_state)
    factor = two_ray_factor(
        distance, height, radar.height, radar.wavelength, earth_radius=earth_radius,
        polarization=radar.polarization, wave_height=wave_height,
    )  # fmt: skip
    return RAMP * min(1.0, abs(complex(factor) - 1.0)) * phase_change
