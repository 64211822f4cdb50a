"""A quintic spline through points, as `scipy.interpolate.make_interp_spline` with k=5 makes it, to the last bit.

Importing `scipy.interpolate` takes 0.2 s of processor time, which every start of a scene with a nonlinear chirp had to wait for.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from radar_service.numerics.types import Complexes, Floats, Indices

DEGREE = 5


@dataclass(frozen=True)
class QuinticSpline:
    """The spline through points (N,), N >= 6, as a function. knots: (N + 6,), rising; coefficients: (N,)."""

    knots: Floats
    coefficients: Complexes

    @classmethod
    def through(cls, position: Floats, value: Complexes) -> "QuinticSpline":
        """Returns the spline through values (N,) at rising positions (N,), without a knot at the three points next to each end
        (de Boor 1978, chapter XIII)."""
        ends = [np.full(DEGREE + 1, position[end]) for end in (0, -1)]
        knots = np.concatenate([ends[0], position[3:-3], ends[1]])
        first, weights = _weights(knots, position)
        banded = np.zeros((2 * DEGREE + 1, len(position)))
        rows = np.arange(len(position))
        for k in range(DEGREE + 1):
            column = first + k
            banded[DEGREE + rows - column, column] = weights[k]
        return cls(knots, solve_banded((DEGREE, DEGREE), banded, value))

    def __call__(self, position: Floats) -> Complexes:
        """Returns the values at positions (M,) between the first point and the last."""
        first, weights = _weights(self.knots, position)
        value: Complexes = self.coefficients.take(first) * weights[0]
        for k in range(1, DEGREE + 1):
            value += self.coefficients.take(first + k) * weights[k]
        return value


def _weights(knots: Floats, position: Floats) -> tuple[Indices, Floats]:
    """Returns the first of the six B-splines that are not 0 at each position (M,), and the values (6, M) of all six.

    The recurrence of de Boor 1972 and Cox 1972, in the order of Dierckx's FITPACK, which scipy has.
    """
    last = len(knots) - DEGREE - 2
    cell = np.clip(np.searchsorted(knots, position, side="right") - 1, DEGREE, last)
    values = np.zeros((DEGREE + 1, len(position)))
    values[0] = 1.0
    for order in range(1, DEGREE + 1):
        lower = values[:order].copy()
        values[0] = 0.0
        for n in range(1, order + 1):
            above, below = knots.take(cell + n), knots.take(cell + n - order)
            share = lower[n - 1] / (above - below)
            values[n - 1] += share * (above - position)
            values[n] = share * (position - below)
    return cell - DEGREE, values
