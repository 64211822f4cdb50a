"""A small convex body as the antenna has it at many instants, and the triangles of others that may stand before it meanwhile."""

from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.propagation.diffraction import diffraction_height
from radar_service.propagation.radar_equation import radar_two_rays
from radar_service.radar.parameters import Radar, horizon
from radar_service.scattering.model import Instant
from radar_service.scattering.physical_optics.cast_shadows import Onlooker
from radar_service.world.body import Body
from radar_service.world.environment import Environment
from radar_service.world.poses import BodyPose

FEW_TRIANGLES = 64  # of another body, that are not searched for those that may cast a shadow


class Casters(NamedTuple):
    """Other bodies (O,) that may cast shadows: begin (O + 1,) of each among triangles (T, 3, 3) in its own frame [m], and turn
    (S, O, 3, 3) and position (S, O, 3) from there to the map at instants."""

    begin: Indices
    corners: Floats
    turn: Floats
    position: Floats

    def chosen(self, instants: Indices) -> Self:
        """Returns the casters at instants of these indices (N,)."""
        return self._replace(turn=self.turn[instants], position=self.position[instants])


class Sights(NamedTuple):
    """An upright body as the antenna has it at instants (S,): position (S, 3) on the map [m], heading (S,) [rad], antenna (S, 3)
    [m], earth_radius: effective, inf for flat [m]; legs: 1, or 2 with that by the sea."""

    position: Floats
    heading: Floats
    antenna: Floats
    earth_radius: float
    legs: int

    @property
    def antenna_in_frame(self) -> Floats:
        """The antenna (S, 3) in the body's frame [m]."""
        east, north, up = (self.antenna - self.position).T
        cosine, sine = np.cos(self.heading), np.sin(self.heading)
        return np.stack([east * cosine - north * sine, east * sine + north * cosine, up], axis=1)

    def chosen(self, instants: Indices) -> Self:
        """Returns the sights at instants of these indices (N,)."""
        some = self.position[instants], self.heading[instants], self.antenna[instants]
        return self._replace(position=some[0], heading=some[1], antenna=some[2])


def plain_sights(
    body: Body, radar: Radar, environment: Environment, antenna: Floats, times: Floats, instant: Instant
) -> Sights | None:
    """A body at times (S,) [s] as antennas (S, 3) have it, where it is upright and at one height, all of it is in reach, and rays
    alone reach it; None elsewhere. instant: one of them."""
    pose, heights, earth_radius = body.motion.pose(times), antenna[:, 2], instant.line_of_sight.earth_radius
    over_sea = environment.multipath and bool((heights > 0.0).all())
    if pose.rotation is not None or np.ptp(pose.position[:, 2]) or environment.multipath != over_sea:
        return None
    middles = body.middles_at(times) - antenna
    distance = np.linalg.norm(middles, axis=1) + body.diagonal
    top = max(heights.max(), float(pose.position[0, 2] + body.middle[2])) + body.diagonal
    if distance.max() >= instant.max_range:
        return None
    near = distance < horizon(0.0, np.maximum(heights, 0.0), earth_radius)
    if top >= diffraction_height(radar, environment) and not near.all():
        return None
    if over_sea and environment.diffraction:
        along = np.maximum(np.hypot(middles[:, 0], middles[:, 1]), 1.0)
        if (radar_two_rays(radar, environment, along, np.zeros(len(along)), heights).share < 1.0).any():
            return None
    return Sights(pose.position, pose.heading, antenna, earth_radius, 2 if over_sea else 1)


def casters_over(key: int, onlooker: Onlooker, antenna: Floats, times: Floats, instant: Instant) -> Casters:
    """The triangles of other bodies that may stand before body `key` of the scene at any of times (S,) [s], for antennas (S, 3).

    onlooker: the body as it is in the middle of these; instant: one of them.
    """
    scene, middle = instant.line_of_sight, len(times) // 2
    time, span = float(times[middle]), float(np.ptp(times))
    drift = float(np.linalg.norm(antenna - antenna[middle], axis=1).max())
    others = scene.other_occluders(key, antenna[middle], time, True, span, drift / span if span else 0.0)
    present, own_moved = scene.present(time), scene.moved_within(key, time, span) + drift
    corners, turns, positions = [np.zeros((0, 3, 3))], [np.zeros((len(times), 0, 3, 3))], [np.zeros((len(times), 0, 3))]
    for other in others:
        if not present[other]:
            continue
        triangles, position, turn = scene.motion_of(other, times)
        chosen = triangles.corners
        if len(triangles) > FEW_TRIANGLES:
            pose = BodyPose(position[middle], 0.0, turn[middle])
            chosen = onlooker.before(triangles, pose, scene.moved_within(other, time, span) + drift, own_moved)
        corners.append(chosen)
        turns.append(turn[:, None])
        positions.append(position[:, None])
    begin = np.cumsum([len(each) for each in corners])
    return Casters(begin, np.concatenate(corners), np.concatenate(turns, axis=1), np.concatenate(positions, axis=1))
