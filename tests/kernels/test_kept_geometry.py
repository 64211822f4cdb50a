"""Kernels of what is computed anew from a kept trace against numpy: tubes, the waterline, weights, and the lattice."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics import illumination
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.illumination import KeptTubes
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.scattering_centres import Lattice
from radar_service.world.poses import BodyPose
from tests.kernels.both import both

EARTH = 4 / 3 * 6_371_000.0
LEAN = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]) @ np.array(
    [[1, 0, 0], [0, 0.96, -0.28], [0, 0.28, 0.96]]
)
POSE = BodyPose(np.array([300.0, -200.0, 0.5]), 2.1, None)


def leg(by_sea: bool, earth: float = EARTH) -> BodyLeg:
    return BodyLeg(
        by_sea, POSE, np.array([-90.0, 400.0, 20.0]), earth, lambda points, _: np.ones(len(points), dtype=np.bool_)
    )


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("lean", [None, LEAN], ids=["upright", "leaning"])
@pytest.mark.parametrize("count", [0, 1, 400])
def test_kept_tubes_end_where_they_end_by_numpy(count: int, lean: np.ndarray | None, polarization: str) -> None:
    """Chains of one to four surfaces between planes in any order, some of which the tubes graze or do not meet at all."""
    draw = np.random.default_rng(13)
    normal = draw.normal(size=(9, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    planes = Planes(draw.uniform(-5, 5, (9, 3)), normal, np.ones((9, 2), dtype=np.bool_), np.arange(9), 100.0)
    chain = draw.integers(0, 9, (4, count))
    chain[np.arange(4)[:, None] > draw.integers(0, 4, count)] = -1
    corners = draw.uniform(-3.0, 3.0, (1, 3, count)) + draw.uniform(-0.2, 0.2, (3, 3, count))
    corners[:, 2] += 3.0  # above the sea
    kept = KeptTubes(1, 1, 0, corners, chain, draw.uniform(0, 1, count), np.full(count, 0.4), np.ones(count))
    legs = (leg(False), leg(True))
    compiled, by_numpy = both(lambda: kept.traced(planes, lean, legs, polarization, 3.0))
    for name in by_numpy.__dataclass_fields__:
        if name != "launch":
            one, other = getattr(compiled, name), getattr(by_numpy, name)
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9, err_msg=name)  # grazing tubes go 100 times as far
    for one, other in zip(compiled.launch, by_numpy.launch, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)
    assert count < 400 or 0 < np.count_nonzero(compiled.launch.share) < count


@pytest.mark.parametrize("water", [-9.0, 0.2, 9.0], ids=["all dry", "some cut", "all wet"])
def test_what_rises_above_the_sea_is_that_of_numpy(water: float) -> None:
    draw = np.random.default_rng(14)
    points, corner = draw.uniform(-3.0, 3.0, (90, 3)), draw.integers(0, 90, (3, 60))
    points[:20, 2] = 0.2  # at the level itself
    planes = Planes(np.zeros((1, 3)), np.eye(3)[:1], np.zeros((1, 2), dtype=np.bool_), np.zeros(1, dtype=np.int64), 1.0)
    triangle, cells = np.zeros(60, dtype=np.int64), draw.uniform(1.0, 2.0, 60)
    side, share = np.ones((60, 1), dtype=np.int8), draw.uniform(0.0, 1.0, (60, 1))
    kept = illumination.Illumination(points, corner, triangle, cells, side, share, ())
    compiled, by_numpy = both(lambda: kept.facets(planes, None, (leg(False),), water))
    np.testing.assert_array_equal(compiled.cell, by_numpy.cell)
    np.testing.assert_array_equal(compiled.points[compiled.corner], by_numpy.points[by_numpy.corner])
    assert len(by_numpy.cell) == 0 if water > 3.0 else len(by_numpy.cell) > 20


@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("count", [0, 1, 400])
def test_weights_of_the_leg_by_sea(count: int, earth: float) -> None:
    """Also at the foot of the antenna, below the sea and beyond the horizon."""
    points = np.random.default_rng(15).uniform([-100, -100, -2], [100, 100, 40], (400, 3))
    points[:3] = [30.0, 40.0, 3.0], [40_000.0, 0.0, 2.0], [0.0, 0.0, -5.0]
    np.testing.assert_allclose(*both(lambda: leg(True, earth).weight(points[:count])), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lowest", [0.3, -np.inf], ids=["at sea", "anywhere"])
@pytest.mark.parametrize("count", [0, 1, 300])
def test_lattices_are_those_of_numpy(count: int, lowest: float) -> None:
    """Two sizes of cells; points on nodes and, by rounding, below the lowest cell; in clusters far from each other."""
    draw = np.random.default_rng(16)
    points = draw.uniform(-4.0, 4.0, (300, 3)) + 60.0 * draw.integers(0, 2, (300, 1))
    points[:9] = np.round(points[:9])
    points[:9, 2] = 0.3 - 1e-12
    points, cell = points[:count], np.repeat([0.5, 0.8], 150)[:count]
    compiled, by_numpy = both(lambda: Lattice.over(points, cell, 0.7, lowest))
    sides = ((each.nodes, each.corner, each.share) for each in (compiled, by_numpy))
    for one, other in zip(*sides, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)
    values = draw.normal(size=len(by_numpy.nodes))
    np.testing.assert_allclose(*both(lambda: by_numpy.between(values)), rtol=0.0, atol=1e-12)
