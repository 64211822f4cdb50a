"""Points for effects: echoes by the radar equation, lines of sight, and when the beam crosses them."""

import math
from collections.abc import Callable

import numpy as np

from radar_service.echo import AzimuthTimes, BeamWeightedEchoes, apparent_position, max_echo_range
from radar_service.numerics import Flags, Floats, Indices, effective_earth_radius, polar_from_map, wrap_angle
from radar_service.propagation import (
    attenuation,
    elevation_gain,
    local_attenuation,
    radar_two_rays,
    received_amplitude,
    two_way_phase,
)
from radar_service.radar import STEPS, CrossingSearch
from radar_service.stages.stage import Context
from radar_service.trace import OcclusionScene, beyond_horizon
from radar_service.world import Scene, SightLines

STEPS_PER_SWAY = 16  # search steps in the shortest period of the antenna's sway: a sine turns by 0.4 rad in one


def point_echoes(context: Context, source: str, azimuths: AzimuthTimes, position: Floats, rcs: Floats) -> BeamWeightedEchoes:
    """Returns the echoes of those points (P,) that are in range and in sight at the middle azimuth.

    source: whose echoes these are. position: (P, K, 3) east, north and height [m] at each azimuth. rcs: (P,) [m^2].
    The sea reflects where the scene has multipath; the antenna stays level, and own ship's structures take nothing.
    """
    scene, radar, half = context.scene, context.scene.radar, len(azimuths.time) // 2
    antenna = scene.antenna(azimuths.time)
    near = np.linalg.norm(position[:, half] - antenna[half], axis=1) < max_echo_range(radar)
    kept = np.flatnonzero(near & in_sight(scene, context.line_of_sight, position[:, half], azimuths.middle))
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


def in_sight(scene: Scene, line_of_sight: OcclusionScene, position: Floats, time: float, over_horizon: float = 0.0) -> Flags:
    """Returns whether neither the sea nor a body hides points (P, 3) [m] on the map from the antenna at `time` [s].

    over_horizon: height up to which fields reach beyond the horizon [m].
    """
    antenna, earth_radius = scene.antenna(time)[0], effective_earth_radius(scene.environment.earth_factor)
    distance = np.hypot(*(position - antenna)[:, :2].T)
    hidden = beyond_horizon(distance, position[:, 2], float(antenna[2]), earth_radius, over_horizon)
    hidden |= line_of_sight.occluded_by_resting(position, antenna)
    return np.asarray(~(hidden | line_of_sight.occluded_by_moving(position, antenna, time)))


def crossing_search(scene: Scene, position: Callable[[Indices, Floats], Floats], count: int) -> CrossingSearch:
    """Returns what finds when the beam crosses points: its `within(scan)`, as the antenna observes them, which may sway.

    position: on the map (E, 3) [m], of points (E,) by index at times (E,) [s]; count: number of points.
    """
    radar, sway, steps = scene.radar, scene.own_ship.sway, STEPS
    if sway is not None:
        steps = max(steps, min(radar.azimuths, math.ceil(STEPS_PER_SWAY * radar.rotation_period / sway.shortest_period)))

    def offsets(points: Indices, time: Floats) -> Floats:
        return observed_offset(scene, position(points, time) - scene.antenna(time), time)[:, :2]

    return CrossingSearch(offsets, count, radar.rotation_period, radar.azimuths, steps)


def observed_offset(scene: Scene, offset: Floats, time: Floats) -> Floats:
    """Returns offsets (W, 3) from the antenna [m] as it observes them at times (W,) [s], rolling and pitching with own ship."""
    level, earth_radius = scene.upright_from_map(time), effective_earth_radius(scene.environment.earth_factor)
    return offset if level is None else apparent_position(offset[:, None], level, earth_radius)[:, 0]
