"""The platform: positions and directions of an antenna on a moving, swaying ship."""

import numpy as np

from radar_service.world.motion import Motion
from radar_service.world.platform import Platform
from radar_service.world.sway import Sway

ROLL = Sway(np.array([np.pi / 6, 0.0, 0.0, 0.0]), np.array([4.0, 1.0, 1.0, 1.0]))  # 30 degrees to starboard at 1 s
HEAVE = Sway(np.array([0.0, 0.0, 0.0, 0.5]), np.full(4, 4.0))
ROUNDING = 1e-12  # of float64 at some 10 m


def platform(heading: float, sway: Sway | None = None) -> Platform:
    """A platform that passes east 100 m, north 50 m at t = 0 with 2 m/s to the east."""
    return Platform(
        Motion(np.zeros(1), np.array([[100.0, 50.0, 0.0]]), np.array([heading]), np.array([2.0, 0.0, 0.0]), sway=sway)
    )


def test_an_upright_mast_stands_above_the_motion() -> None:
    steady = platform(0.3)
    np.testing.assert_allclose(
        steady.antenna(np.array([0.0, 3.0]), 15.0), [[100, 50, 15], [106, 50, 15]], rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(steady.heading(np.array([0.0, 9.0])), 0.3, rtol=0, atol=ROUNDING)
    assert steady.upright_from_map(np.zeros(2)) is None and steady.text == "at east 100.0, north 50.0 m"


def test_roll_moves_the_antenna_to_starboard_and_down() -> None:
    """h sin 30 to starboard, which is south on an eastern heading, and h cos 30 above the sea."""
    antenna = platform(np.pi / 2, ROLL).antenna(1.0, 20.0)
    np.testing.assert_allclose(antenna, [[102.0, 40.0, 20.0 * np.sqrt(0.75)]], rtol=0, atol=ROUNDING)


def test_heave_alone_lifts_the_antenna_over_the_sea() -> None:
    """Half a metre at a quarter of its period; where the motion itself lies does not count."""
    heaving = Platform(Motion(np.zeros(1), np.array([[0.0, 0.0, 7.0]]), np.zeros(1), sway=HEAVE))
    np.testing.assert_allclose(heaving.antenna(np.array([0.0, 1.0]), 20.0)[:, 2], [20.0, 20.5], rtol=0, atol=ROUNDING)


def test_directions_along_the_swaying_mast_become_vertical() -> None:
    rolling, time = platform(np.pi / 2, ROLL), np.array([0.0, 1.0])
    matrix = rolling.upright_from_map(time)
    assert matrix is not None
    mast = rolling.antenna(time, 1.0) - rolling.motion.pose(time).position
    np.testing.assert_allclose(np.einsum("kij,kj->ki", matrix, mast), [[0, 0, 1], [0, 0, 1]], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix[1] @ [1.0, 0.0, 0.0], [1, 0, 0], rtol=0, atol=ROUNDING)  # the axis of roll stays
