"""Legs: how a wave travels between the antenna and points of a body, directly or by a reflection at the sea.

Lengths are those of `polar_from_map` and of `specular_geometry`, so a field that is summed with them is consistent with the
ranges of its echoes. By Fermat's principle the direction at the body is the gradient of the length.
"""

from typing import NamedTuple

import numpy as np

from radar_service.propagation.multipath import SpecularGeometry, specular_geometry
from radar_service.types import Flags, Floats

_TINY = 1e-12  # m; keeps directions finite at the antenna's own plan position


class Leg(NamedTuple):
    """One way between the antenna and points (M,).

    length: of the way [m].
    level: (M, 2) east and north components of the horizontal unit vector away from the antenna.
    rise: (M,) sine of the elevation of travel at the points, positive upward.
    curvature: (M,) of the wavefront in the vertical plane [1/m]; in the horizontal plane it is 1 / length.
    elevation: (M,) of the ray at the antenna, from horizontal [rad].
    grazing: (M,) angle at the sea [rad]; 0 for the direct leg.
    divergence: (M,) factor of the curved sea; 1 for the direct leg.
    tilt: (M,) of the earth's surface there against the antenna's [rad]; rays rise there by that much more.
    arrives: (M,) whether a ray reaches the point at all over the curved earth.
    """

    length: Floats
    level: Floats
    rise: Floats
    curvature: Floats
    elevation: Floats
    grazing: Floats
    divergence: Floats
    tilt: Floats
    arrives: Flags


def direct_leg(position: Floats, antenna: Floats, earth_radius: float) -> Leg:
    """The straight way to positions (M, 3) on the map [m] from the antenna (3,); earth_radius: effective, inf for flat [m]."""
    distance, level = _plan(position, antenna)
    z = position[:, 2] - antenna[2] - distance**2 / (2.0 * earth_radius)
    length = np.maximum(np.hypot(distance, z), _TINY)
    none, everywhere = np.zeros(len(length)), np.ones(len(length), dtype=np.bool_)
    elevation = np.arctan2(z, distance)
    return Leg(length, level, z / length, 1.0 / length, elevation, none, none + 1.0, distance / earth_radius, everywhere)


def sea_leg(position: Floats, antenna: Floats, earth_radius: float) -> Leg:
    """The way by the sea to positions (M, 3), arguments as `direct_leg`.

    The sea is convex, so beyond the reflection point the rays of a vertical plane diverge faster: 1 / D^2 times the plain
    spreading, D the factor of `divergence` (Kerr 1951, ch. 5).
    """
    distance, level = _plan(position, antenna)
    geometry = specular_geometry(distance, position[:, 2], float(antenna[2]), earth_radius)
    ground = _reflection_distance(geometry)
    height = np.maximum(position[:, 2], 0.0)
    rise = np.sin(np.arctan2(height - (distance**2 - ground**2) / (2.0 * earth_radius), distance - ground))
    sine = np.maximum(np.sin(geometry.grazing), _TINY)
    spreading = 1.0 + 2.0 * geometry.first / (earth_radius * sine)
    curvature = spreading / np.maximum(geometry.first + geometry.second * spreading, _TINY)
    return Leg(
        geometry.first + geometry.second, level, rise, curvature, geometry.elevation_reflected, geometry.grazing,
        geometry.divergence, distance / earth_radius, geometry.grazing > 0.0,
    )  # fmt: skip


def reflection_points(position: Floats, antenna: Floats, earth_radius: float) -> tuple[Floats, Flags]:
    """Where the ways by the sea to positions (M, 3) meet it, (M, 3) at height 0 on the map [m], and whether they do (M,)."""
    distance, level = _plan(position, antenna)
    geometry = specular_geometry(distance, position[:, 2], float(antenna[2]), earth_radius)
    plan = antenna[:2] + level * _reflection_distance(geometry)[:, None]
    return np.concatenate([plan, np.zeros((len(plan), 1))], axis=1), np.asarray(geometry.grazing > 0.0)


def _plan(position: Floats, antenna: Floats) -> tuple[Floats, Floats]:
    """Distances along the earth (M,) [m] and horizontal unit vectors (M, 2) from the antenna."""
    offset = position[:, :2] - antenna[:2]
    distance = np.hypot(offset[:, 0], offset[:, 1])
    return distance, offset / np.maximum(distance, _TINY)[:, None]


def _reflection_distance(geometry: SpecularGeometry) -> Floats:
    """Distance (M,) from the antenna to the reflection point along the earth [m]."""
    return np.asarray(geometry.first * np.cos(geometry.elevation_reflected))
