"""Studies of propagation, against worked values."""

import numpy as np
import pytest

from radar_service.study.stability.studies.propagation_limits import min_grazing, two_ray_db
from tests.study.stability.run import EARTH, WAVELENGTH, finding_of


def test_flat_and_curved_two_ray_agree_with_worked_values() -> None:
    """Worked by hand at 9.41 GHz, heights 15 and 10 m, rho = -1: at 20 km -5.35 dB over 4/3 earth, 11.97 dB over a flat
    earth. The coefficient of the sea (0.998 at half a degree) changes F^4 by 0.03 dB."""
    flat, curved = two_ray_db(np.array([20_000.0]))
    assert flat[0] == pytest.approx(11.97, abs=0.05)
    assert curved[0] == pytest.approx(-5.35, abs=0.05)


def test_last_quarter_wavelength() -> None:
    """Path difference over 4/3 earth by a search of the shortest reflected path in extended precision: a quarter wavelength
    at the boundary. The tolerance of 1 % is that of linear interpolation in the grid of 250 m."""
    ground = finding_of("horizon").boundary
    assert ground is not None
    x = np.linspace(0.0, ground, 2_000_001).astype(np.longdouble)
    drop = x**2 / (2 * np.longdouble(EARTH))
    foot, far = np.hypot(x, 15.0 + drop), ground - x
    total = np.longdouble(ground) ** 2 / (2 * np.longdouble(EARTH))
    excess = (foot + np.hypot(far, 10.0 - total + drop)).min() - np.hypot(ground, 10.0 - total - 15.0)
    assert float(excess) == pytest.approx(WAVELENGTH / 4.0, rel=0.01)


def test_min_grazing_angle() -> None:
    """(0.031859 / (2 pi 8 494 667))^(1/3) by hand: 5.969e-10^(1/3) = 8.42e-4 rad."""
    assert min_grazing(WAVELENGTH, EARTH) == pytest.approx(8.42e-4, abs=5e-7)
