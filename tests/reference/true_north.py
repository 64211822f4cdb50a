"""True bearings by a slower way than `world.geo`: the inverse geodesic between positions a little astern and ahead on the map."""

import math
from collections.abc import Sequence

import numpy as np
from pyproj import Geod

from radar_service.world.geo import geographic_from_map

STEP = 1.0  # m


def true_deg(bearing: float, position: Sequence[float], origin: tuple[float, float]) -> float:
    """The bearing [degrees] from true north of a direction [rad] from the map's north at a position [m]."""
    here = np.array(position[:2])
    step = STEP * np.array([math.sin(bearing), math.cos(bearing)])
    (latitude, longitude), astern, ahead = geographic_from_map(np.array([here, here - step, here + step]), origin).tolist()
    earth = Geod(ellps="WGS84")
    to, back = (earth.inv(longitude, latitude, each[1], each[0])[0] for each in (ahead, astern))
    return (to + math.remainder(back + 180.0 - to, 360.0) / 2.0) % 360.0
