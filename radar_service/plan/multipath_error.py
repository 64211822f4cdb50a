"""What it errs to hold the way over the sea while moving echoes are swept over several azimuths together."""

import math

import numpy as np

from radar_service.frames import effective_earth_radius
from radar_service.propagation.multipath import specular_geometry, two_ray_factor
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.scene.body import Body
from radar_service.scene.world import Scene

RAMP = 0.67  # rms of 2 F m dphi over rms of F^2, phases even and m = 1: 2 sqrt(2) / sqrt(6), over sqrt(3) of a ramp
LEAST_DISTANCE = 10.0  # m


def multipath_error_db(scene: Scene, azimuths_per_block: int) -> float:
    """Relative field error [dB] of taking the mirror's phase from the middle of so many azimuths, for the moving body that
    feels it most where it stands at the start; -inf where there is no mirror or nothing moves."""
    if azimuths_per_block == 1 or not scene.environment.multipath:
        return -math.inf
    seconds = (azimuths_per_block - 1) / 2.0 * scene.radar.spoke_period
    worst = max((_turned(body, scene, seconds) for body in scene.bodies), default=0.0)
    return 20.0 * math.log10(worst) if worst > 0.0 else -math.inf


def _turned(body: Body, scene: Scene, seconds: float) -> float:
    """Relative change of F^2 within so many seconds [s], for the highest points of a body coming straight nearer."""
    moved = (scene.own_ship.top_speed + body.motion.top_speed) * seconds
    if moved == 0.0:
        return 0.0
    radar, earth_radius = scene.radar, effective_earth_radius(scene.environment.earth_factor)
    place = body.middle_at(0.0) - scene.antenna(0.0)[0]
    distance = max(LEAST_DISTANCE, math.hypot(place[0], place[1]) - body.radius)
    height = body.motion.position[0, 2] + (0.0 if body.mesh is None else float(body.mesh.vertices[:, 2].max()))
    excess = specular_geometry(np.array([distance, distance + moved]), height, radar.height, earth_radius).excess
    turn = 2.0 * math.pi / radar.wavelength * abs(float(excess[1] - excess[0]))
    wave_height = rms_wave_height(scene.environment.sea_state)
    factor = two_ray_factor(
        distance, height, radar.height, radar.wavelength, earth_radius=earth_radius,
        polarization=radar.polarization, wave_height=wave_height,
    )  # fmt: skip
    return RAMP * min(1.0, abs(complex(factor) - 1.0)) * turn
