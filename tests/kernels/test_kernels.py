"""The short modules of kernels, each under its name."""

import subprocess
import sys

import numpy as np
import pytest

from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.range_history import parabola
from radar_service.numerics.frames import map_from_deck
from radar_service.scattering.model import BodyEchoes
from radar_service.world.poses import PoseArrays
from tests.kernels.both import both


# beam_weights: the kernel of beam weights against numpy.
@pytest.mark.parametrize(("count", "azimuths"), [(0, 4), (1, 1), (1, 17), (700, 16), (700, 3)])
def test_beam_weights_are_those_of_numpy(count: int, azimuths: int) -> None:
    """Also beyond the table's end, and near enough for the loss to change by a fifth. Bytes are equal."""
    draw, table = np.random.default_rng(18), BeamTable(lambda offset: np.cos(offset) ** 2, 0.03, 0.1, 0.02)
    boresight, azimuth = draw.uniform(-0.02, 0.02, azimuths), draw.uniform(-0.3, 0.3, count)
    changes, migration = draw.uniform(-0.01, 0.01, (count, azimuths)), draw.uniform(-9.0, 9.0, (count, azimuths))
    columns = [c.astype(np.float32) for c in (boresight, azimuth, changes, draw.uniform(0.0, 0.01, count), migration)]
    compiled, by_numpy = both(lambda: table.weights(*columns))
    np.testing.assert_array_equal(compiled, by_numpy)
    assert compiled.dtype == np.float32 and compiled.shape == (count, azimuths)


# echo_positions: the kernel that places echoes at some instants against numpy.
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


# fuzz: no call of a kernel ends a process, whatever it is given: in a child process, whose last line names the kernel that did.
def fuzzed(seed: int, rounds: int) -> None:
    command = [sys.executable, "-m", "tests.kernels.fuzz", str(seed), str(rounds)]
    child = subprocess.run(command, capture_output=True, text=True)
    assert (child.returncode, child.stdout.split()[-1]) == (0, "done"), child.stderr


def test_kernels_survive_what_is_odd_and_refuse_what_is_wrong() -> None:
    fuzzed(1, 30)


@pytest.mark.study
@pytest.mark.parametrize("seed", range(2, 12))
def test_kernels_survive_a_thousand_calls_each(seed: int) -> None:
    fuzzed(seed, 1000)
