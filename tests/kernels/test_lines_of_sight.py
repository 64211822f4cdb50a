"""Kernels of lines of sight past many bodies against numpy."""

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_deck
from radar_service.trace.occluder import Occluder
from radar_service.trace.posed_occluders import OccluderKinds, PosedOccluders
from radar_service.trace.shadow_sectors import ShadowSectors, points_behind
from radar_service.world.poses import PoseArrays
from radar_service.world.shapes import box
from tests.kernels.both import both

EARTH = 4 / 3 * 6_371_000.0


@pytest.mark.parametrize("leaning", [[], [1], [0, 2, 3]], ids=["upright", "one leans", "most lean"])
@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize(("count", "origins"), [(0, 1), (1, 1), (600, 1), (600, 600)])
@pytest.mark.parametrize("passing", [False, True])
def test_lines_of_sight_are_those_of_numpy(
    count: int, origins: int, leaning: list[int], earth: float, passing: bool
) -> None:
    """Four bodies of two meshes, before, about and behind points 5 km off. The tolerance is four roundings of 5 km; the share
    left out rounds by as much over the way."""
    draw, occluders = np.random.default_rng(23), [Occluder(box(30.0, 20.0, height), earth) for height in (10.0, 14.0)]
    rotation = {b: map_from_deck(*draw.uniform(-1.0, 1.0, (3, 1))) for b in leaning}
    poses = PoseArrays(draw.uniform(-3000.0, 3000.0, (1, 4, 3)), draw.uniform(0.0, 6.0, (1, 4)), rotation)
    posed = PosedOccluders(OccluderKinds.of([occluders[k] for k in (0, 1, 1, 0)]), poses, earth)
    body, origin = draw.integers(0, 4, count), draw.uniform(-60.0, 60.0, (origins, 3))
    away = draw.uniform(0.5, 1.7, (count, 1))
    points = away * (poses.position[0][body] + draw.uniform(-25.0, 25.0, (count, 3)))
    if count == 600:
        points[0] = origin[0]  # no way at all
    begins = origin[0] if origins == 1 else origin
    results = both(lambda: posed.lines_of_sight(body, begins, points, passing))
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=4e-12)
    kept = len(results[0].which)
    assert kept == count or (passing and (count == 1 or 100 < kept < 500))


@pytest.mark.parametrize("sloping", [False, True])
@pytest.mark.parametrize("count", [1, 900])
def test_points_behind_bodies_are_those_of_numpy(count: int, sloping: bool) -> None:
    """The same pairs in the same order. One body stands round about the antenna."""
    draw = np.random.default_rng(29)
    sectors = ShadowSectors(draw.uniform(-3.0, 3.0, 40), draw.uniform(0.0, 0.6, 40), draw.uniform(0.0, 4000.0, 40))
    sectors.half[7] = np.pi
    azimuth, distance = draw.uniform(-np.pi, np.pi, count), draw.uniform(3500.0, 5000.0, count)
    slopes = (draw.uniform(-1.0, 1.0, 40), draw.uniform(-1.0, 1.0, count)) if sloping else None
    compiled, by_numpy = both(lambda: list(points_behind(sectors, azimuth, distance, slopes)))
    for one, other in zip(compiled, by_numpy, strict=True):
        np.testing.assert_array_equal(one, other)
    assert count == 1 or sum(len(body) for body, _ in compiled) > 1000
