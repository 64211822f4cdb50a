"""Kernels of a body's own shadows against numpy."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.own_shadows import BEFORE_THE_SEA, STEPS, OwnShadows
from tests.kernels.both import both
from tests.scattering.physical_optics.test_own_shadows import BACK, EARTH, shadows, walls

ROUNDING = 1e-9  # m; positions on the map, of some 1 km, round to 1e-13 m, the cubic of the reflection point to 1e-11


def compared(own: OwnShadows, points: Floats, triangle: Indices) -> Indices:
    """What occludes points, the same either way."""
    (occluding, *compiled), (by_numpy, *others) = both(lambda: own.occluding(points, triangle))
    np.testing.assert_array_equal(occluding, by_numpy)
    for one, other in zip(compiled, others, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=ROUNDING * 1e3)  # rays by the sea seem to come from afar
    return occluding


@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("roll", [0.0, 0.2], ids=["upright", "rolled"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
@pytest.mark.parametrize("distance", [100.0, 3000.0])
def test_occluding_triangles_and_edges_are_those_of_numpy(distance: float, by_sea: bool, roll: float, earth: float) -> None:
    own = shadows(walls(4.0, 3), distance, 12.0, by_sea, roll, earth)
    draw = np.random.default_rng(3)
    points = draw.uniform([-15.0, 5.0, 0.0], [15.0, 5.0, 8.0], (500, 3))
    triangle = np.full(500, 2 * 3**2)
    occluding = compared(own, points, triangle)
    assert (occluding >= 0).any() and (by_sea or (occluding == -1).any())
    hidden, seen = points[occluding >= 0][:100], points[:100] + [0.0, 0.0, 12.0]
    ways = hidden[: len(seen)], seen[: len(hidden)], triangle[: min(len(hidden), len(seen))]
    compiled, by_numpy = both(lambda: own.edges(*ways))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=ROUNDING)  # NaN in the same places
    assert np.isfinite(compiled).any()


@pytest.mark.parametrize("count", [0, 1])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_few_points_and_none(count: int, by_sea: bool) -> None:
    own, points = shadows(walls(2.0), 400.0, 12.0, by_sea), np.array([[0.0, 5.0, 1.0]])[:count]
    compared(own, points, np.full(count, BACK))
    compiled, by_numpy = both(lambda: own.edges(points, points + [0.0, 0.0, 6.0], np.full(count, BACK)))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=ROUNDING)


def test_a_point_is_never_hidden_by_its_own_triangle_nor_by_one_that_it_lies_on() -> None:
    """Points on the front wall, whatever triangle they are said to lie on; rays along the wall of the back meet no plane."""
    own = shadows(walls(2.0), 400.0, 12.0, False)
    on_front = np.array([[0.0, -5.0, 1.0], [0.0, -5.0, 1.0], [0.0, -5.0, 2.0], [15.0, -5.0, 1.0]])
    assert (compared(own, on_front, np.array([0, 1, 1, 0])) == -1).all()


def test_rays_that_do_not_reach_the_sea_are_lost_either_way() -> None:
    own = shadows(walls(1.0), 200.0, 20.0, True)
    assert compared(own, np.array([[0.0, 5.0, 0.5]]), np.array([BACK])).tolist() == [BEFORE_THE_SEA]


def test_ways_behind_too_many_triangles_stay_open() -> None:
    own = shadows(walls(2.0, 60), 400.0, 12.0, False)
    hidden, seen = np.array([[0.3, 5.0, 0.2], [0.3, 5.0, 1.9]]), np.array([[0.3, 5.0, 4.0], [0.3, 5.0, 4.0]])
    compiled, by_numpy = both(lambda: own.edges(hidden, seen, np.array([7200, 7200])))
    assert np.isnan(compiled[0]) and STEPS < 30
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=ROUNDING)
