"""Echoes of points by the radar equation, for effects that have such."""

import numpy as np

from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes
from radar_service.echo.second_time_around import max_echo_range
from radar_service.numerics.frames import effective_earth_radius, polar_from_map, wrap_angle
from radar_service.numerics.types import Flags, Floats
from radar_service.propagation.radar_equation import (
    attenuation,
    elevation_gain,
    local_attenuation,
    radar_two_rays,
    received_amplitude,
    two_way_phase,
)
from radar_service.stages.stage import Context
from radar_service.trace.occluder import beyond_horizon
from radar_service.world.environment import SightLines


def point_echoes(context: Context, source: str, azimuths: AzimuthTimes, position: Floats, rcs: Floats) -> BeamWeightedEchoes:
    """Returns the echoes of those points (P,) that are in range and in sight at the middle azimuth.

    source: whose echoes these are. position: (P, K, 3) east, north and height [m] at each azimuth. rcs: (P,) [m^2].
    The sea reflects where the scene has multipath; the antenna stays level, and own ship's structures take nothing.
    """
    scene, radar, half = context.scene, context.scene.radar, len(azimuths.time) // 2
    antenna = scene.antenna(azimuths.time)
    near = np.linalg.norm(position[:, half] - antenna[half], axis=1) < max_echo_range(radar)
    kept = np.flatnonzero(near & _in_sight(context, position[:, half], antenna[half], azimuths.middle))
    places, antennas = position[kept].reshape(-1, 3), np.tile(antenna, (len(kept), 1))
    polar = polar_from_map(places, antennas, effective_earth_radius(scene.environment.earth_factor))
    field = elevation_gain(radar, polar.elevation).astype(np.complex128)
    if scene.environment.multipath:
        rays = radar_two_rays(radar, scene.environment, polar.distance, places[:, 2], antennas[:, 2])
        reflected = 1.0 + rays.ratio * np.exp(-2j * np.pi / radar.wavelength * rays.geometry.excess)
        field = np.where(rays.arrives, rays.gain * reflected**2, 0.0)
    field *= received_amplitude(radar, polar.range) * attenuation(radar, scene.environment, polar.range)
    if scene.environment.attenuators:
        lines = SightLines(antennas, np.tile(azimuths.time, len(kept)), polar.azimuth, polar.range)
        field *= local_attenuation(radar, scene.environment, lines)
    field *= two_way_phase(polar.range, radar.wavelength)
    field *= radar.azimuth_gain(wrap_angle(polar.azimuth - np.tile(azimuths.boresight, len(kept))))
    shape = len(kept), len(azimuths.time)
    distance, amplitude = polar.range.reshape(shape), (field.reshape(shape) * np.sqrt(rcs[kept, None])).astype(np.complex64)
    migration = (distance - distance[:, half, None]).astype(np.float32)
    return BeamWeightedEchoes(distance[:, half], migration, amplitude, np.full(len(kept), context.echo_sources[source]))


def _in_sight(context: Context, position: Floats, antenna: Floats, time: float) -> Flags:
    """Whether nothing hides points (P, 3) [m] from the antenna (3,) [m] at `time` [s]."""
    distance = np.hypot(*(position - antenna)[:, :2].T)
    earth_radius = effective_earth_radius(context.scene.environment.earth_factor)
    hidden = beyond_horizon(distance, position[:, 2], float(antenna[2]), earth_radius)
    hidden |= context.line_of_sight.occluded_by_resting(position, antenna)
    return np.asarray(~(hidden | context.line_of_sight.occluded_by_moving(position, antenna, time)))
