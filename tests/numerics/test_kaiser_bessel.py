"""The Kaiser-Bessel kernel: its transform against the integral of its definition."""

import numpy as np
import pytest
from scipy.integrate import quad

from radar_service.numerics.kaiser_bessel import MIN_OVERSAMPLING, kernel_transform, shape_parameter


@pytest.mark.parametrize(("width", "oversampling"), [(4, 1.5), (6, 2.0), (8, 1.0)])
def test_the_transform_is_the_integral_of_the_kernel(width: int, oversampling: float) -> None:
    """Quadrature is good to 1e-8 of the peak."""
    beta = shape_parameter(width, oversampling)
    for frequency in (0.0, 0.3, 0.9, 2.2):

        def integrand(x: float, frequency: float = frequency) -> float:
            return float(
                np.i0(beta * np.sqrt(1.0 - (2.0 * x / width) ** 2)) / np.i0(beta) * np.cos(2 * np.pi * frequency * x)
            )

        expected = 2.0 * quad(integrand, 0.0, width / 2.0, limit=200)[0]
        assert kernel_transform(np.array([frequency]), width, beta)[0] == pytest.approx(expected, abs=1e-8)


def test_the_shape_parameter_is_that_of_beatty() -> None:
    """pi sqrt(W^2 / s^2 (s - 1/2)^2 - 0.8) for W = 6, s = 2 by hand; a grid without oversampling counts as oversampled 1.1."""
    assert shape_parameter(6, 2.0) == pytest.approx(np.pi * np.sqrt(4.5**2 - 0.8))
    assert shape_parameter(6, 1.0) == shape_parameter(6, MIN_OVERSAMPLING)
