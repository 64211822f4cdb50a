"""Aspects rounded so that a body far off has the same one for many scans: a function of the aspect alone."""

import math
from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics.frames import map_from_body
from radar_service.numerics.types import Floats
from radar_service.world.poses import BodyPose

ELEVATION = math.radians(0.05)  # between rounded distances, by which elevation and parts of a body turn: half of it at most
PER_OCTAVE = 8  # rounded distances, where these would let them be farther apart


class RoundedAspect(NamedTuple):
    """An upright body as an antenna has it from a rounded bearing and distance.

    bearing, distance: of the antenna along the earth, from the middle of the body's plan and its heading [rad, m].
    height, level: of the antenna and of the body's origin above the sea [m].
    middle: of the plan, aside and ahead in the body's frame [m].
    """

    bearing: float
    distance: float
    height: float
    level: float
    middle: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, antenna: Floats, pose: BodyPose, step: float, middle: Floats, radius: float) -> Self:
        """The one nearest to that of a body in a pose for an antenna (3,) on the map [m].

        step: between bearings [rad]; middle: of the body's plan in its frame (3,), radius: of the plan about it [m].
        """
        east, north, _ = (antenna - map_from_body(middle, pose.position, pose.heading)).tolist()
        bearing = round((math.atan2(east, north) - pose.heading) / step) * step
        height = float(antenna[2])
        distance = rounded_distance(math.hypot(east, north), max(height, radius))
        aside, ahead, _ = middle.tolist()
        return cls(bearing % (2.0 * math.pi), distance, height, float(pose.position[2]), (aside, ahead))

    @property
    def pose(self) -> BodyPose:
        """The body with its plan about the middle of a map, ahead to the north."""
        aside, ahead = self.middle
        return BodyPose(np.array([-aside, -ahead, self.level]), 0.0)

    @property
    def antenna(self) -> Floats:
        """The antenna (3,) on that map [m]."""
        aside, ahead = math.sin(self.bearing), math.cos(self.bearing)
        return np.array([self.distance * aside, self.distance * ahead, self.height])


def rounded_distance(distance: float, lever: float) -> float:
    """A distance [m] from which what is aside by a lever [m], the height of an antenna or a part of a body, has nearly the same
    angle."""
    octaves = math.log2(max(distance, 1.0))
    angle = lever / max(distance, 1.0)
    if angle * (2.0 ** (1.0 / PER_OCTAVE) - 1.0) < ELEVATION:
        return float(2.0 ** (round(octaves * PER_OCTAVE) / PER_OCTAVE))
    return lever / (round(angle / ELEVATION) * ELEVATION)
