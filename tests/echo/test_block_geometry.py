"""Positions of echoes over a block: moving bodies at their poses of each instant, resting ones where they are."""

import numpy as np
import pytest

from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes, PartGeometry
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.range_history import parabola
from radar_service.scattering.model import BodyEchoes
from radar_service.world.poses import BodyPoses
from tests.scenes import point, scene
from tests.test_motion import SWAY

EARTH = 4 / 3 * 6_371_000.0


def block_of(**own_ship: object) -> tuple[BlockGeometry, ObservedEchoes]:
    """A resting and a moving body with an echo each, the second 2 m off its origin, over four azimuths from t = 10 s."""
    bodies = [point("rests", 300, 400, 5), point("moves", 0, 900, 5, speed_kn=20, course_deg=90)]
    made = scene(bodies, own_ship=own_ship)
    time = 10.0 + 0.01 * np.arange(4)
    azimuths = AzimuthTimes(np.arange(4), np.zeros(4), time)
    over = parabola(time)
    every = np.concatenate([over.nodes, time])
    poses = BodyPoses(made.bodies)
    moves = np.array([False, True])
    geometry = BlockGeometry(
        azimuths, over, poses.at(every), made.antenna(every), made.upright_from_map(every), ~moves, moves
    )
    echoes = BodyEchoes.of_points(np.array([[0.0, 0, 0], [0, 2, 1]]), np.ones(2, dtype=complex), np.array([0, 1]))
    return geometry, ObservedEchoes(echoes, np.array([[300.0, 400, 5], [np.nan, np.nan, np.nan]]))


def test_positions_are_those_of_the_instant() -> None:
    """The body heads east, so 2 m ahead is 2 m east; 20 kn for 10 s and more."""
    geometry, observed = block_of()
    speed = 20 * 1852 / 3600
    for n, time in enumerate([10.0, 10.015, 10.03, 10.0, 10.01, 10.02, 10.03]):
        (position,) = geometry.positions(observed, np.array([0, 1]), [n])
        np.testing.assert_allclose(position, [[300, 400, -10], [speed * time + 2, 900, -9]], atol=1e-9)


def test_a_part_has_its_middle_as_the_antenna_observes_it() -> None:
    geometry, observed = block_of()
    part = PartGeometry.of(observed, np.array([0]), geometry, np.inf)
    assert part.polar.range[0] == pytest.approx(np.sqrt(250_000 + 100))
    assert part.azimuth[0] == part.polar.azimuth[0] == pytest.approx(np.arctan2(3, 4))
    assert len(part.elevations()) == 3 and part.elevation[0] == pytest.approx(np.arctan2(-10, 500))
    swaying, observed = block_of(heading_deg=40, **SWAY)
    tilted = PartGeometry.of(observed, np.array([0]), swaying, EARTH)
    assert abs(tilted.elevation[0] - tilted.polar.elevation[0]) > 0.01
    assert len({float(e[0]) for e in tilted.elevations()}) == 3
