"""Latitude and longitude to east and north of the scene's origin, and back: geodesic azimuthal equidistant, WGS 84.

A place keeps its geodesic distance and bearing from the origin (the inverse problem as Karney 2013 solves it, through
pyproj). Only edges of the program use these: inside, places are metres on the map.
"""

import numpy as np
from numpy.typing import NDArray
from pyproj import Geod

Floats = NDArray[np.float64]
Origin = tuple[float, float]  # latitude, longitude [degrees]

_EARTH = Geod(ellps="WGS84")


def map_from_geographic(latitude_deg: Floats | float, longitude_deg: Floats | float, origin: Origin) -> Floats:
    """East and north (..., 2) [m] of places at latitude and longitude (...) [degrees, WGS 84], seen from `origin`."""
    latitude, longitude = np.broadcast_arrays(
        np.asarray(latitude_deg, dtype=np.float64), np.asarray(longitude_deg, dtype=np.float64)
    )
    shape = latitude.shape
    flat = latitude.ravel(), longitude.ravel()
    home = np.full(flat[0].shape, origin[0]), np.full(flat[0].shape, origin[1])
    bearing_deg, _, distance = _EARTH.inv(home[1], home[0], flat[1], flat[0])
    bearing = np.deg2rad(np.asarray(bearing_deg))
    places = np.stack([distance * np.sin(bearing), distance * np.cos(bearing)], axis=-1)
    return places.reshape(*shape, 2)


def geographic_from_map(places: Floats, origin: Origin) -> Floats:
    """Latitude and longitude (..., 2) [degrees, WGS 84] of places (..., 2 or more): east, north [m] from `origin`."""
    flat = np.asarray(places, dtype=np.float64)
    east, north = flat[..., 0].ravel(), flat[..., 1].ravel()
    bearing_deg = np.rad2deg(np.arctan2(east, north))
    home = np.full(east.shape, origin[0]), np.full(east.shape, origin[1])
    longitude, latitude, _ = _EARTH.fwd(home[1], home[0], bearing_deg, np.hypot(east, north))
    return np.stack([latitude, longitude], axis=-1).reshape(*flat.shape[:-1], 2)
