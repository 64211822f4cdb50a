"""Converts latitude and longitude to east and north of the scene's origin, and back: azimuthal equidistant, WGS 84.

The map keeps geodesic distance and bearing from the origin (Karney 2013, through pyproj). Only input and output use
degrees; positions inside the program are metres on the map.
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from radar_service.numerics.types import Floats

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


@cache
def _earth() -> "Geod":
    from pyproj import Geod  # here: few scenes have an origin, and it would slow every start

    return Geod(ellps="WGS84")
