"""Aspects rounded so that a body far off has the same one for many scans: a function of the aspect alone."""

import math
from typing import NamedTuple, Self

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.world.poses import BodyPose

ELEVATION = math.radians(0.05)  # between rounded elevations: what is traced is off by half of it
PER_OCTAVE = 8  # rounded distances, where elevations would let them be farther apart


class RoundedAspect(NamedTuple):
    """An upright body as an antenna has it from a rounded bearing and distance.

    bearing: of the antenna, from the body's heading [rad]. distance: along the earth [m].
    height, level: of the antenna and of the body's origin above the sea [m].
    """

    bearing: float
    distance: float
    height: float
    level: float

    @classmethod
    def of(cls, antenna: Floats, pose: BodyPose, step: float) -> Self:
        """The one nearest to that of a body in a pose for an antenna (3,) on the map [m]; step: between bearings [rad]."""
        east, north, _ = (antenna - pose.position).tolist()
        bearing = round((math.atan2(east, north) - pose.heading) / step) * step
        height = float(antenna[2])
        return cls(
            bearing % (2.0 * math.pi), rounded_distance(math.hypot(east, north), height), height, float(pose.position[2])
        )

    @property
    def pose(self) -> BodyPose:
        """The body at the middle of a map, ahead to the north."""
        return BodyPose(np.array([0.0, 0.0, self.level]), 0.0)

    @property
    def antenna(self) -> Floats:
        """The antenna (3,) on that map [m]."""
        aside, ahead = math.sin(self.bearing), math.cos(self.bearing)
        return np.array([self.distance * aside, self.distance * ahead, self.height])


def rounded_distance(distance: float, height: float) -> float:
    """A distance [m] from which an antenna at a height [m] has nearly the same elevation."""
    octaves = math.log2(max(distance, 1.0))
    elevation = height / max(distance, 1.0)
    if elevation * (2.0 ** (1.0 / PER_OCTAVE) - 1.0) < ELEVATION:
        return float(2.0 ** (round(octaves * PER_OCTAVE) / PER_OCTAVE))
    return height / (round(elevation / ELEVATION) * ELEVATION)
