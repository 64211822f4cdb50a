"""Dead reckoning: where something is at another time if it keeps its velocity."""

from collections.abc import Sequence

import numpy as np

from radar_service.numerics.types import Floats

Vector = Floats | Sequence[float]


def moved_on(position: Vector, velocity: Vector, time: float) -> Floats:
    """Returns a position (2,) [m] after a time [s] at a velocity (2,) [m/s]; a negative time goes back."""
    return np.asarray(position, dtype=np.float64) + time * np.asarray(velocity, dtype=np.float64)


def distance_at(position: Vector, time: float, true: Vector, velocity: Vector, true_time: float) -> float:
    """Returns the distance [m] of a position (2,) [m] of a time [s] from a truth, moved on from its own time to that time.

    true, velocity: (2,) [m], [m/s], of the truth at true_time [s].
    """
    apart = np.asarray(position, dtype=np.float64) - moved_on(true, velocity, time - true_time)
    return float(np.hypot(apart[0], apart[1]))
