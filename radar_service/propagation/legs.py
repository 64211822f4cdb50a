"""Where the ways by the sea to points of a body meet it. The ways themselves are traced by kernels (`leg_rays.c`)."""

import numpy as np

from radar_service.numerics.types import Flags, Floats
from radar_service.propagation.multipath import reflected_ray

_TINY = 1e-12  # m; keeps directions finite at the antenna's own plan position


def reflection_points(position: Floats, antenna: Floats, earth_radius: float) -> tuple[Floats, Flags]:
    """Where the ways by the sea to positions (M, 3) meet it, (M, 3) at height 0 on the map [m], and whether they do (M,)."""
    distance, level = _plan(position, antenna)
    ray = reflected_ray(distance, position[:, 2], float(antenna[2]), earth_radius)
    points = np.zeros((len(distance), 3))
    points[:, :2] = antenna[:2] + level * ray.reflection[:, None]
    return points, np.asarray(ray.grazing_sine > 0.0)


def _plan(position: Floats, antenna: Floats) -> tuple[Floats, Floats]:
    """Distances along the earth (M,) [m] and horizontal unit vectors (M, 2) from the antenna."""
    offset = position[:, :2] - antenna[:2]
    distance = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
    return distance, offset / np.maximum(distance, _TINY)[:, None]
