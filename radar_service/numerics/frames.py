"""Positions relative to the antenna, and rotations. Bearings run clockwise from true north; all angles are in radians."""

import math
from typing import NamedTuple

import numpy as np

from radar_service.numerics.constants import EARTH_RADIUS
from radar_service.numerics.types import Floats


class Polar(NamedTuple):
    """Positions relative to the antenna, arrays of one shape.

    range: slant range [m].
    azimuth: from north [rad].
    elevation: from horizontal [rad].
    distance: along the ground [m].
    """

    range: Floats
    azimuth: Floats
    elevation: Floats
    distance: Floats


def effective_earth_radius(factor: float) -> float:
    """Radius of the earth [m] over which rays are straight; `factor` 4/3 is the standard atmosphere, inf a flat earth."""
    return factor * EARTH_RADIUS


def polar_from_map(position: Floats, antenna: Floats, earth_radius: float) -> Polar:
    """Slant range and angles of positions relative to the antenna.

    position: (..., 3) east, north, height above mean sea level [m]; distance is measured along the earth.
    antenna: (3,) or broadcastable (..., 3), in the same coordinates [m].
    earth_radius: effective radius ae [m]; inf for a flat earth.

    d = hypot(east, north), z = up - d^2 / (2 ae) - antenna height, R = hypot(d, z) by definition (docs/conventions.md).
    """
    offset = position - antenna
    east, north = offset[..., 0], offset[..., 1]
    distance = np.hypot(east, north)
    drop = distance**2 / (2.0 * earth_radius)
    z = offset[..., 2] - drop
    return Polar(np.hypot(distance, z), np.arctan2(east, north), np.arctan2(z, distance), distance)


def distances_from_map(position: Floats, antenna: Floats, earth_radius: float) -> tuple[Floats, Floats]:
    """Ground distance and slant range (...) [m]; arguments as `polar_from_map`."""
    offset = position - antenna
    ground2 = offset[..., 0] ** 2 + offset[..., 1] ** 2
    z = offset[..., 2] - ground2 / (2.0 * earth_radius)
    return np.sqrt(ground2), np.sqrt(ground2 + z * z)


def direction(azimuth: Floats, elevation: Floats) -> Floats:
    """Unit vectors (..., 3) east, north, up for a bearing and an elevation [rad] (corrects docs/specification.md eq. 6,
    errata row 8)."""
    level = np.cos(elevation)
    return np.stack([np.sin(azimuth) * level, np.cos(azimuth) * level, np.sin(elevation)], axis=-1)


def wrap_angle(angle: Floats) -> Floats:
    """The same angle in [-pi, pi] [rad]; rounding may give either end for half a circle."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def wrap_bearing(angle: Floats | float) -> Floats:
    """The same angle in [0, 2 pi) [rad]: never 2 pi itself, to which the remainder of -1e-17 rounds."""
    wrapped = np.asarray(angle) % (2.0 * np.pi)
    return np.where(wrapped < 2.0 * np.pi, wrapped, 0.0)


def bearing_text(angle: float) -> str:
    """Returns a bearing [rad] in degrees, 000.0 to 359.9."""
    return f"{round(math.degrees(angle), 1) % 360.0:05.1f}"


def map_from_body(points: Floats, position: Floats, heading: float) -> Floats:
    """Points (..., 3) [m] of a body's own frame (at heading 0: x east, y north, z up) on the map [m].

    position: (3,) east, north, up of the body's origin [m]; heading: [rad] clockwise from north.
    """
    return points @ body_rotation(heading).T + position


def turned(points: Floats, cosine: Floats, sine: Floats) -> Floats:
    """Points (3,) or (K, 3) [m] of bodies' own frames along the map's axes (K, 3) [m]; cosine, sine: (K,) or (1,) of headings.

    Each coordinate is contiguous in memory, because callers go on with one coordinate at a time.
    """
    east, north, up = points[..., 0], points[..., 1], points[..., 2]
    along = np.empty((3, *np.broadcast_shapes(east.shape, cosine.shape)))
    along[0], along[1], along[2] = cosine * east + sine * north, cosine * north - sine * east, up
    return along.T


def map_from_deck(heading: Floats, roll: Floats, pitch: Floats) -> Floats:
    """Matrices (..., 3, 3) from a ship's deck (x starboard, y bow, z mast) to the map, for angles (...) [rad]: roll with the
    starboard side down, then pitch with the bow up, then heading."""
    cr, sr, cp, sp, c, s = (f(a) for a in (roll, pitch, heading) for f in (np.cos, np.sin))
    entries = (
        *(c * cr + s * sp * sr, s * cp, c * sr - s * sp * cr),
        *(-s * cr + c * sp * sr, c * cp, -s * sr - c * sp * cr),
        *(-cp * sr, sp, cp * cr),
    )
    matrices = np.empty((*np.shape(entries[0]), 9), np.result_type(*entries))
    for number, entry in enumerate(entries):
        matrices[..., number] = entry
    return matrices.reshape(*matrices.shape[:-1], 3, 3)


def body_rotation(heading: float) -> Floats:
    """The (3, 3) matrix map_from_body for a heading [rad] clockwise from north: the bow (+y) points along it."""
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
