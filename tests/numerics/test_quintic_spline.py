"""The quintic spline against scipy's own, and against polynomials that it must reproduce."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from radar_service.numerics.quintic_spline import QuinticSpline


@pytest.mark.parametrize("count", [12, 13, 400])
def test_it_is_scipys_spline(count: int) -> None:
    """At points, between them, and at both ends; of unequal steps. Rounding of values near 1: 1e-14."""
    rng = np.random.default_rng(count)
    at = np.cumsum(rng.uniform(0.5, 1.5, count))
    value = rng.normal(size=count) + 1j * rng.normal(size=count)
    asked = np.concatenate([at, rng.uniform(at[0], at[-1], 500)])
    ours, theirs = QuinticSpline.through(at, value)(asked), make_interp_spline(at, value, k=5)(asked)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())


def test_a_polynomial_of_fifth_degree_is_itself() -> None:
    """Its coefficients are of order 1 and its points within 1, so rounding is some 1e-13."""
    at = np.linspace(-1.0, 1.0, 41)
    polynomial = np.array([0.3, -1.2, 0.7, 1.0, -0.4, 0.9])
    asked = np.linspace(-1.0, 1.0, 333)
    spline = QuinticSpline.through(at, np.polyval(polynomial, at).astype(np.complex128))
    np.testing.assert_allclose(spline(asked), np.polyval(polynomial, asked), atol=1e-12)
