"""The kernel that places echoes at some instants against numpy."""

import numpy as np
import pytest

from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.range_history import parabola
from radar_service.numerics.frames import map_from_deck
from radar_service.scattering.model import BodyEchoes
from radar_service.world.poses import PoseArrays
from tests.kernels.both import both


@pytest.mark.parametrize("leaning", [[], [1], [0, 2, 3]], ids=["upright", "one leans", "most lean"])
@pytest.mark.parametrize("count", [0, 1, 500])
def test_positions_are_those_of_numpy(count: int, leaning: list[int]) -> None:
    """Four bodies, of which the last rests; one of them has no echo, and an undefined heading. The tolerance is four roundings of
    5 km."""
    draw, time = np.random.default_rng(17), 0.01 * np.arange(4)
    instants, body = 3 + len(time), draw.choice([0, 1, 3], 500)
    heading = draw.uniform(0.0, 6.0, (instants, 4))
    heading[:, 2] = np.nan
    rotation = {b: map_from_deck(*draw.uniform(-1.0, 1.0, (3, instants))) for b in leaning}
    poses = PoseArrays(draw.uniform(-5000.0, 5000.0, (instants, 4, 3)), heading, rotation)
    moves, antenna = np.array([True, True, True, False]), draw.uniform(-10.0, 10.0, (instants, 3))
    over, azimuths = parabola(time), AzimuthTimes(np.arange(4), np.zeros(4), time)
    block = BlockGeometry(azimuths, over, poses, antenna, None, ~moves, moves)
    echoes = BodyEchoes.of_points(draw.uniform(-50.0, 50.0, (500, 3)), np.ones(500, dtype=np.complex128), body)
    observed, which = ObservedEchoes(echoes, draw.uniform(-5000.0, 5000.0, (500, 3))), draw.integers(0, 500, count)
    for instants_of in ([1], range(3), range(3, 7)):
        for one, other in zip(*both(lambda: block.positions(observed, which, instants_of)), strict=True):  # noqa: B023
            np.testing.assert_allclose(one, other, rtol=0.0, atol=4e-12)
            assert one.T.flags.c_contiguous and np.isfinite(one).all()
