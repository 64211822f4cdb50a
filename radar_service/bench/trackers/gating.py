"""How the reference tracker is tuned, and how far plots are from its tracks: those in a gate may belong together.

The distances of all pairs are computed at once, as Stone Soup's extended Kalman filter has them.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal

import numpy as np

from radar_service.numerics import Floats, wrap_angle

EPOCH = datetime(2000, 1, 1)


@dataclass(frozen=True)
class Tuning:
    """How the reference tracker is tuned.

    association: "gnn" or "jpda".
    range_error, bearing_error: standard deviation of plots [m], [rad].
    glint: standard deviation of the echo along a ship [m], whose course is not known yet.
    acceleration: spectral density of the white acceleration of targets [m^2/s^3].
    speed_error: standard deviation of a target's speed before anything is known of it [m/s].
    gate: normalised distance within which a plot may belong to a track.
    confirm: plots that confirm a track.
    delete: scans without a plot after which a track ends.
    detection, clutter: probability of detection, and false plots per m^2, for JPDA.
    """

    association: Literal["gnn", "jpda"] = "gnn"
    range_error: float = 5.0
    bearing_error: float = float(np.radians(0.1))
    glint: float = 0.0
    acceleration: float = 0.0002
    speed_error: float = 20.0
    gate: float = 3.5
    confirm: int = 4
    delete: int = 8
    detection: float = 0.9
    clutter: float = 1e-7

    def errors_at(self, distance: Floats | float) -> tuple[Floats, Floats]:
        """Returns the standard deviations of range [m] and bearing [rad] of plots at a range [m]."""
        glint = np.asarray(self.glint)
        return np.hypot(self.range_error, glint), np.hypot(self.bearing_error, glint / np.maximum(distance, 1.0))


def pair_distances(tracks: Iterable[Any], plots: Iterable[Any], tuning: Tuning) -> tuple[Floats, Floats]:
    """Returns the distance (T, D) [m] of each plot from each track at the time of the plot, and the Mahalanobis distance (T, D).

    Source: Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2 (white acceleration), 10.3.3 (extended Kalman filter).
    """
    mean = np.reshape([track.state.mean for track in tracks], (-1, 4, 1)).swapaxes(0, 1).astype(np.float64)
    p = np.moveaxis(np.reshape([track.state.covar for track in tracks], (-1, 1, 4, 4)), (2, 3), (0, 1))
    angle, reach = np.reshape([plot.state_vector for plot in plots], (-1, 2)).T.astype(np.float64)
    own = np.reshape([plot.measurement_model.translation_offset for plot in plots], (-1, 2)).T[:, None]
    later = _seconds(plots) - _seconds([track.state for track in tracks])[:, None]
    east, north = mean[::2] + later * mean[1::2] - own
    noise = tuning.acceleration * abs(later) ** 3 / 3.0
    p_east = p[0, 0] + 2.0 * later * p[0, 1] + later**2 * p[1, 1] + noise
    p_north = p[2, 2] + 2.0 * later * p[2, 3] + later**2 * p[3, 3] + noise
    p_mixed = p[0, 2] + later * (p[0, 3] + p[1, 2]) + later**2 * p[1, 3]
    distance = np.maximum(np.hypot(east, north), 1.0)  # m: at own ship there is no bearing
    x, y = east / distance, north / distance
    range_error, bearing_error = tuning.errors_at(reach)
    along = x**2 * p_east + 2.0 * x * y * p_mixed + y**2 * p_north + range_error**2
    across = (y**2 * p_east - 2.0 * x * y * p_mixed + x**2 * p_north) / distance**2 + bearing_error**2
    mixed = (x * y * (p_north - p_east) + (x**2 - y**2) * p_mixed) / distance
    turn, beyond = wrap_angle(angle - np.arctan2(north, east)), reach - distance
    square = (across * beyond**2 - 2.0 * mixed * beyond * turn + along * turn**2) / (along * across - mixed**2)
    return np.hypot(east - reach * np.cos(angle), north - reach * np.sin(angle)), np.sqrt(np.maximum(square, 0.0))


def _seconds(dated: Iterable[Any]) -> Floats:
    return np.array([(each.timestamp - EPOCH).total_seconds() for each in dated])
