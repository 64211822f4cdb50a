"""What the antenna sees in its picture: points by bearing and slope, directly or by the sea, and the windows that bodies fill.

A point's virtual position has the height at which it seems to lie along the ray that leaves the antenna for it. So rays are
straight through the antenna: over the curved earth, and by the sea, where points lie as their mirror images do.
"""

from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats
from radar_service.propagation import reflection_distance

NEAREST = 1e-3  # m: distances below it count as this one
AROUND = 1.5  # rad aside of its middle, from which a hull may hold the antenna


class Picture(NamedTuple):
    """antenna: (3,) on the map [m]. earth_radius: effective, inf for flat [m]. by_sea: whether the sea reflects the rays."""

    antenna: Floats
    earth_radius: float
    by_sea: bool

    def virtual(self, position: Floats) -> Floats:
        """Virtual positions (..., 3) about the antenna of points (..., 3) on the map [m], by the sea of those above it."""
        result = position - self.antenna
        distance = np.hypot(result[..., 0], result[..., 1])
        result[..., 2] = self.height(distance, position[..., 2])
        return result

    def height(self, distance: Floats, height: Floats) -> Floats:
        """Virtual heights of points at distances along the earth and heights above the sea, any shape [m]."""
        antenna_height = float(self.antenna[2])
        if not self.by_sea:
            return np.asarray(height - antenna_height - distance**2 / (2.0 * self.earth_radius))
        distance = np.maximum(distance, NEAREST)
        reflection = reflection_distance(distance, np.maximum(height, 0.0), antenna_height, self.earth_radius)
        reflection = np.maximum(reflection, NEAREST * NEAREST)
        return np.asarray(-distance * (antenna_height / reflection + reflection / (2.0 * self.earth_radius)))


class Windows(NamedTuple):
    """Parts (N,) of a picture that hold the convex hulls of points.

    middle, half: bearing of the middle, and half the width [rad].
    low, high: slopes between which they lie.
    nearest, farthest: distances in plan between which they lie [m].
    """

    middle: Floats
    half: Floats
    low: Floats
    high: Floats
    nearest: Floats
    farthest: Floats

    @classmethod
    def of(cls, points: Floats, picture: Picture) -> "Windows":
        """The windows of what of the hulls of points (N, P, 3) on the map [m] rises above the sea; none where nothing does."""
        east, north = points[..., 0] - picture.antenna[0], points[..., 1] - picture.antenna[1]
        to_east, to_north = east.mean(axis=1)[:, None], north.mean(axis=1)[:, None]
        scale = np.maximum(np.hypot(to_east, to_north), NEAREST * NEAREST)
        ahead, aside = (east * to_east + north * to_north) / scale, (east * to_north - north * to_east) / scale
        half = np.abs(np.arctan2(aside, ahead)).max(axis=1)
        around = (half > AROUND) | (scale[:, 0] < NEAREST)
        nearest = np.maximum(np.where(around, 0.0, ahead.min(axis=1)), NEAREST)
        farthest = np.hypot(east, north).max(axis=1)
        low, high = _slopes(points[..., 2].min(axis=1), points[..., 2].max(axis=1), nearest, farthest, picture)
        bearing = np.arctan2(to_east, to_north)[:, 0]
        return cls(bearing, np.where(around, np.pi, half), low, high, nearest, farthest)

    def widened(self, by: float) -> "Windows":
        """Windows that hold the same points wherever these move by up to so many metres."""
        angle = 2.0 * by / self.nearest
        bounds = (self.half + angle, self.low - angle, self.high + angle)
        return Windows(self.middle, *bounds, np.maximum(self.nearest - by, NEAREST), self.farthest + by)


def _slopes(bottom: Floats, top: Floats, nearest: Floats, farthest: Floats, picture: Picture) -> tuple[Floats, Floats]:
    """The lowest and the highest slope (N,) of points above the sea between heights and distances (N,) [m]; inf and -inf where
    none is above it."""
    bottom = np.maximum(bottom, 0.0)
    if picture.by_sea:
        low, high = picture.height(nearest, top) / nearest, picture.height(farthest, bottom) / farthest
    else:
        sunk, raised = picture.height(farthest, bottom), picture.height(nearest, top)
        low = np.where(sunk < 0.0, sunk / nearest, sunk / farthest)
        high = np.where(raised > 0.0, raised / nearest, raised / farthest)
    dry = top > 0.0
    return np.where(dry, low, np.inf), np.where(dry, high, -np.inf)
