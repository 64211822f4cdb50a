"""The one-way link between a radar's antenna and the beacon on a body: power falls as R^-2 there, and as R^-2 back.

Both ways have the same gain, loss, multipath and attenuation. Half of the radar's loss in dB counts each way.
"""

from typing import NamedTuple

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Flags, Floats, effective_earth_radius, polar_from_map, turned, wrap_angle
from radar_service.propagation import (
    LandBefore,
    attenuation,
    diffraction_height,
    elevation_gain,
    local_attenuation,
    radar_two_rays,
)
from radar_service.stages.beacons.beacon import Beacon
from radar_service.stages.points import in_sight
from radar_service.stages.registry import changed_pattern
from radar_service.trace import OcclusionScene
from radar_service.world import Scene, SightLines


class Link(NamedTuple):
    """The link at times (K,).

    range: slant range [m].
    azimuth: at which the antenna observes the beacon [rad], swaying with own ship.
    transfer: power at the radar's receiver, with boresight at the beacon in azimuth, over the isotropic power of the beacon; and
        power at an isotropic antenna there over that of the radar's transmitter.
    """

    range: Floats
    azimuth: Floats
    transfer: Floats


class BeaconLink:
    """The link of a scene's radar to the beacon of one of its bodies. Safe to call from several threads."""

    def __init__(self, scene: Scene, key: int, line_of_sight: OcclusionScene) -> None:
        """key: index of the body in the scene."""
        self.beacon: Beacon = scene.bodies[key].effects["beacon"]
        self._scene, self._body, self._line_of_sight = scene, scene.bodies[key], line_of_sight
        self._earth_radius = effective_earth_radius(scene.environment.earth_factor)
        self._rests = self._body.motion.at_rest and scene.own_ship.at_rest
        self._receives = self.beacon.receives(scene.radar.frequency, scene.radar.pulse)

    def position(self, time: Floats) -> Floats:
        """The beacon's antenna (K, 3) on the map [m] at times (K,) [s]."""
        pose, offset = self._body.motion.pose(time), np.array(self.beacon.offset)
        if pose.rotation is not None:
            return np.asarray(pose.position + pose.rotation @ offset)
        return np.asarray(pose.position + turned(offset, np.cos(pose.heading), np.sin(pose.heading)))

    def at(self, time: Floats) -> Link:
        """The link at times (K,) [s], whatever hides one end from the other but the sea in `multipath`."""
        if not self._rests:
            return self._at(time)
        return Link(*(np.repeat(column, len(time)) for column in self._at(time[:1])))

    def _at(self, time: Floats) -> Link:
        scene, radar = self._scene, self._scene.radar
        position, antenna = self.position(time), scene.antenna(time)
        polar = polar_from_map(position, antenna, self._earth_radius)
        azimuth, elevation = self._observed(position - antenna, time, polar.azimuth, polar.elevation)
        gain = elevation_gain(radar, elevation)
        if scene.environment.multipath:
            tilt_error = elevation - polar.elevation
            land = LandBefore(self._line_of_sight, antenna, position - antenna)
            rays = radar_two_rays(radar, scene.environment, polar.distance, position[:, 2], antenna[:, 2], tilt_error, land)
            phase = np.exp(-2j * np.pi / radar.wavelength * rays.geometry.excess)
            gain = np.where(rays.arrives, rays.gain * np.abs(1.0 + rays.ratio * phase) ** 2, 0.0)
        spread = radar.gain * (radar.wavelength / (4.0 * np.pi * np.maximum(polar.range, radar.range_min))) ** 2
        weather = attenuation(radar, scene.environment, polar.range)  # in amplitude both ways, in power one way
        if scene.environment.attenuators:
            lines = SightLines(antenna, time, polar.azimuth, polar.range)
            weather *= local_attenuation(radar, scene.environment, lines)
        return Link(polar.range, azimuth, spread * gain * weather / np.sqrt(radar.loss))

    def _observed(self, offset: Floats, time: Floats, azimuth: Floats, elevation: Floats) -> tuple[Floats, Floats]:
        """Azimuth and elevation (K,) [rad] of offsets (K, 3) [m] as the antenna observes them, which may sway."""
        level = self._scene.upright_from_map(time)
        if level is None:
            return azimuth, elevation
        curved = offset.copy()
        curved[:, 2] -= (offset[:, 0] ** 2 + offset[:, 1] ** 2) / (2.0 * self._earth_radius)
        east, north, up = np.einsum("kij,kj->ik", level, curved)
        return np.arctan2(east, north), np.arctan2(up, np.hypot(east, north))

    def azimuth_gain(self, link: Link, boresight: Floats, time: Floats) -> Floats:
        """One-way power gain (K,) of the antenna toward the beacon at boresights (K,) [rad] and times (K,) [s], over that on
        boresight: sidelobes and what stands before it included."""
        offset = link.azimuth - boresight
        if (pattern := changed_pattern(self._scene.radar)) is None:
            return self._scene.radar.azimuth_gain(wrap_angle(offset))
        return np.abs(pattern.one_way(link.azimuth - self._scene.platform.heading(time), offset)) ** 2

    def triggers(self, link: Link, gain: Floats, time: Floats) -> Flags:
        """Whether pulses at times (K,) [s] trigger the beacon, by azimuth gains (K,): in its band, strong enough, while it is
        there and switched on."""
        if not self._receives:
            return np.zeros(len(time), dtype=np.bool_)
        strong = self._scene.radar.power * link.transfer * gain >= self.beacon.sensitivity
        return np.asarray(strong & self.beacon.active(time) & self._body.presence.at(time))

    def delay(self, link: Link) -> Floats:
        """Delay (K,) [s] of the beginning of an answer, from the middle of the transmitted pulse on, as the delays of echoes: the
        leading edge of the pulse triggers it."""
        return 2.0 * link.range / SPEED_OF_LIGHT + self.beacon.delay - 0.5 * self._scene.radar.pulse

    def visible(self, time: float) -> bool:
        """Whether the antenna has a line of sight to the beacon at `time` [s]."""
        over = diffraction_height(self._scene.radar, self._scene.environment)
        return bool(in_sight(self._scene, self._line_of_sight, self.position(np.array([time])), time, over)[0])
