"""Legs: how a wave travels between the antenna and points of a body, directly or by a reflection at the sea: what kernels do.

Lengths are those of `polar_from_map` and of `specular_geometry`, so a field that is summed with them is consistent with the
ranges of its echoes. By Fermat's principle the direction at the body is the gradient of the length.
"""

from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Flags, Floats
from radar_service.propagation.multipath import reflection_distance

_TINY = 1e-12  # m; keeps directions finite at the antenna's own plan position


class Leg(NamedTuple):
    """One way between the antenna and points (M,).

    length: of the way [m].
    level: (M, 2) east and north components of the horizontal unit vector away from the antenna.
    rise: (M,) sine of the elevation of travel at the points, positive upward.
    """

    length: Floats
    level: Floats
    rise: Floats


def direct_leg(position: Floats, antenna: Floats, earth_radius: float) -> Leg:
    """The straight way to positions (M, 3) on the map [m] from the antenna (3,); earth_radius: effective, inf for flat [m]."""
    distance, level = _plan(position, antenna)
    z = position[:, 2] - antenna[2] - distance**2 / (2.0 * earth_radius)
    length = np.maximum(np.sqrt(distance * distance + z * z), _TINY)
    return Leg(length, level, z / length)


def sea_leg(position: Floats, antenna: Floats, earth_radius: float) -> Leg:
    """The way by the sea to positions (M, 3), arguments as `direct_leg`."""
    distance, level = _plan(position, antenna)
    ray = reflected_ray(distance, position[:, 2], float(antenna[2]), earth_radius)
    rise = ray.rise / np.maximum(ray.second, _TINY)
    return Leg(ray.first + ray.second, level, rise)


def sea_divergence(position: Floats, antenna: Floats, earth_radius: float) -> Floats:
    """By what the curved sea lowers the fields (M,) that it reflects to positions (M, 3), arguments as `direct_leg`.

    From 1 at the sea itself to 0 at the horizon: the factor of `divergence` (Kerr 1951, ch. 5).
    """
    distance, _ = _plan(position, antenna)
    ray = reflected_ray(distance, position[:, 2], float(antenna[2]), earth_radius)
    fall = earth_radius * (ray.first + ray.second) * np.maximum(ray.grazing_sine, _TINY)
    return np.asarray(np.where(ray.grazing_sine > 0.0, 1.0 / np.sqrt(1.0 + 2.0 * ray.first * ray.second / fall), 0.0))


def leg_length(position: Floats, antenna: Floats, earth_radius: float, by_sea: bool) -> Floats:
    """Lengths (M,) [m] of the direct ways or of those by the sea, arguments as `direct_leg`."""
    east, north = position[:, 0] - antenna[0], position[:, 1] - antenna[1]
    distance2 = east * east + north * north
    if not by_sea:
        return np.asarray(np.sqrt(distance2 + (position[:, 2] - antenna[2] - distance2 / (2.0 * earth_radius)) ** 2))
    ray = reflected_ray(np.sqrt(distance2), position[:, 2], float(antenna[2]), earth_radius)
    return ray.first + ray.second


def _plan(position: Floats, antenna: Floats) -> tuple[Floats, Floats]:
    """Distances along the earth (M,) [m] and horizontal unit vectors (M, 2) from the antenna."""
    offset = position[:, :2] - antenna[:2]
    distance = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
    return distance, offset / np.maximum(distance, _TINY)[:, None]


def reflection_points(position: Floats, antenna: Floats, earth_radius: float) -> tuple[Floats, Flags]:
    """Where the ways by the sea to positions (M, 3) meet it, (M, 3) at height 0 on the map [m], and whether they do (M,)."""
    offset = position[:, :2] - antenna[:2]
    distance = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
    ray = reflected_ray(distance, position[:, 2], float(antenna[2]), earth_radius)
    level = (
        offset / np.maximum(distance, 1e-12)[:, None]
    )  # 1e-12 m keeps directions finite at the antenna's own plan position
    points = np.zeros((len(distance), 3))
    points[:, :2] = antenna[:2] + level * ray.reflection[:, None]
    return points, np.asarray(ray.grazing_sine > 0.0)


class ReflectedRay(NamedTuple):
    """The ray by the sea, arrays of one shape.

    reflection: distance of the reflection point from the antenna, along the earth [m].
    first, second: lengths from antenna to sea, and from sea to target [m].
    rise: of the target over the reflection point, from horizontal at the antenna [m].
    grazing_sine: sine of the grazing angle, not positive below the horizon.
    """

    reflection: Floats
    first: Floats
    second: Floats
    rise: Floats
    grazing_sine: Floats


def reflected_ray(distance: Floats, height: Floats, antenna_height: float, earth_radius: float) -> ReflectedRay:
    """The part of `specular_geometry` that is the ray by the sea, without its angles: a third of the time."""
    height = np.maximum(height, 0.0)
    x = reflection_distance(distance, height, antenna_height, earth_radius)
    bulge = x * x / (2.0 * earth_radius)
    rise, fall = height - distance * distance / (2.0 * earth_radius) + bulge, antenna_height - bulge
    first, second = np.sqrt(x * x + (antenna_height + bulge) ** 2), np.sqrt((distance - x) ** 2 + rise * rise)
    return ReflectedRay(x, first, second, rise, fall / np.sqrt(x * x + fall * fall))
