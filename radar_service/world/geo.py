"""Converts latitude and longitude to east and north of the scene's origin, and back: azimuthal equidistant, WGS 84.

The map keeps geodesic distance and bearing from the origin (Karney 2013, through pyproj). Only input and output use
degrees; positions inside the program are metres on the map, and bearings count from the map's north. Elsewhere than on the
origin's meridian true north is another direction: by about the sine of the latitude times the difference of longitude.
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from radar_service.numerics import EARTH_RADIUS, Floats, wrap_bearing

if TYPE_CHECKING:
    from pyproj import Geod

Origin = tuple[float, float]  # latitude, longitude [degrees]


def map_from_geographic(latitude_deg: Floats | float, longitude_deg: Floats | float, origin: Origin) -> Floats:
    """Returns east and north (..., 2) [m] from `origin` of latitude and longitude (...) [degrees, WGS 84]."""
    latitude, longitude = np.broadcast_arrays(
        np.asarray(latitude_deg, dtype=np.float64), np.asarray(longitude_deg, dtype=np.float64)
    )
    shape = latitude.shape
    flat = latitude.ravel(), longitude.ravel()
    home = np.full(flat[0].shape, origin[0]), np.full(flat[0].shape, origin[1])
    bearing_deg, _, distance = _earth().inv(home[1], home[0], flat[1], flat[0])
    bearing = np.deg2rad(np.asarray(bearing_deg))
    positions = np.stack([distance * np.sin(bearing), distance * np.cos(bearing)], axis=-1)
    return positions.reshape(*shape, 2)


def geographic_from_map(positions: Floats, origin: Origin) -> Floats:
    """Returns latitude and longitude (..., 2) [degrees, WGS 84] of positions (..., 2 or more) [m] on the map of `origin`."""
    flat = np.asarray(positions, dtype=np.float64)
    east, north = flat[..., 0].ravel(), flat[..., 1].ravel()
    bearing_deg = np.rad2deg(np.arctan2(east, north))
    home = np.full(east.shape, origin[0]), np.full(east.shape, origin[1])
    longitude, latitude, _ = _earth().fwd(home[1], home[0], bearing_deg, np.hypot(east, north))
    return np.stack([latitude, longitude], axis=-1).reshape(*flat.shape[:-1], 2)


def true_bearing(bearing: Floats | float, position: Floats, origin: Origin) -> Floats:
    """Returns bearings (...) [rad, 0 to 2 pi) from true north of directions (...) [rad] from the map's north at positions
    (..., 2 or more) [m] on the map of `origin`.

    Directions away from the origin are geodesics; those across are on the map `_stretch` times as long as on the earth.
    """
    from_origin, outward = _outward(position, origin)
    off = bearing - from_origin
    return wrap_bearing(outward + np.arctan2(np.sin(off), _stretch(position) * np.cos(off)))


def map_bearing(bearing: Floats | float, position: Floats, origin: Origin) -> Floats:
    """Returns the directions that `true_bearing` returns as these bearings."""
    from_origin, outward = _outward(position, origin)
    off = bearing - outward
    return wrap_bearing(from_origin + np.arctan2(_stretch(position) * np.sin(off), np.cos(off)))


def _outward(position: Floats, origin: Origin) -> tuple[Floats, Floats]:
    """Bearings (...) [rad] of positions (..., 2 or more) from the origin: there, and where the geodesic arrives."""
    flat = np.asarray(position, dtype=np.float64)
    east, north = flat[..., 0], flat[..., 1]
    bearing = np.arctan2(east, north)
    home = np.full(bearing.size, origin[0]), np.full(bearing.size, origin[1])
    _, _, back_deg = _earth().fwd(home[1], home[0], np.rad2deg(bearing).ravel(), np.hypot(east, north).ravel())
    return bearing, np.deg2rad(np.asarray(back_deg)).reshape(bearing.shape) + np.pi


def _stretch(position: Floats) -> Floats:
    """How many times as long directions across the way from the origin are on the map: c / sin(c), on a sphere."""
    angle = np.hypot(position[..., 0], position[..., 1]) / EARTH_RADIUS
    return np.asarray(1.0 / np.sinc(angle / np.pi))


@cache
def _earth() -> "Geod":
    from pyproj import Geod  # here: few scenes have an origin, and it would slow every start

    return Geod(ellps="WGS84")
