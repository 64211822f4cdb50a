"""Points and hulls in the antenna's picture, directly and by the sea."""

import numpy as np
import pytest

from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.picture import Picture, Windows
from tests.reference.cast_shadows import homogeneous
from tests.reference.metal_on_water import EARTH, Setting

ANTENNA = np.array([0.0, 0.0, 15.0])
FLAT = Picture(ANTENNA, np.inf, False)


@pytest.mark.parametrize("by_sea", [False, True])
@pytest.mark.parametrize("earth", [EARTH, np.inf])
def test_points_lie_as_in_the_oracles_picture(by_sea: bool, earth: float) -> None:
    """To 0.2 mm at up to 8 km: the cubic takes angles at the sea as small where the oracle takes their tangents."""
    rng = np.random.default_rng(1)
    points = np.stack([rng.uniform(-500, 500, 200), rng.uniform(100, 8000, 200), rng.uniform(0.0, 30.0, 200)], axis=1)
    setting = Setting(wavelength=0.1, antenna_height=15.0, earth_radius=earth)
    exact = homogeneous(points, np.array([0.0, 1.0]), setting, by_sea)
    virtual = Picture(ANTENNA, earth, by_sea).virtual(points)
    np.testing.assert_allclose(virtual[:, [0, 2, 1]], exact, atol=2e-4)


@pytest.mark.parametrize("by_sea", [False, True])
def test_windows_hold_their_hulls(by_sea: bool) -> None:
    """100 hulls of 8 points, each with 200 points within."""
    rng, picture = np.random.default_rng(2), Picture(ANTENNA, EARTH, by_sea)
    for _ in range(100):
        middle = np.array([rng.uniform(-300, 300), rng.uniform(-300, 3000), 0.0])
        corners = middle + rng.uniform(-1.0, 1.0, (8, 3)) * rng.uniform(1.0, 60.0) * (1.0, 1.0, 0.3)
        share = rng.dirichlet(np.ones(8), 200)
        inside = share @ corners
        inside = inside[inside[:, 2] > 0.0]
        hull, each = Windows.of(corners[None], picture), Windows.of(inside[:, None], picture)
        aside = np.abs(wrap_angle(each.middle - hull.middle))
        held = (aside <= hull.half + 1e-9) & (each.low >= hull.low - 1e-9) & (each.high <= hull.high + 1e-9)  # rounding
        assert (held & (each.nearest >= hull.nearest - 1e-6) & (each.farthest <= hull.farthest + 1e-6)).all()


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.0), (0.0, -300.0, 0.0)], ids=["about", "beside", "behind"])
def test_windows_hold_what_surrounds_the_antenna(place: Floats) -> None:
    """A ring of 20 m about the antenna fills all bearings; one behind it none of those ahead."""
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    ring = np.stack([20.0 * np.sin(angle), 20.0 * np.cos(angle), 20.0 + 0.0 * angle], axis=1) + place
    ahead, around = Windows.of(np.array([[[-2.0, 500.0, 0.0], [2.0, 500.0, 10.0]]]), FLAT), Windows.of(ring[None], FLAT)
    assert bool(around.before(ahead)[0]) == (place[1] > -100.0)
