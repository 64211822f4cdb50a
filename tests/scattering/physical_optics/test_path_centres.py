"""What legs weigh fields by, over what the nodes of a lattice have."""

import dataclasses

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_legs import FLATTEST, BodyLeg, SeaField
from radar_service.scattering.physical_optics.plane_echoes import PlaneEchoes
from radar_service.scattering.physical_optics.scattering_centres import Lattice, flattest, over_nodes
from radar_service.world.poses import MAP_POSE

POINTS = np.array([[0.0, 0.0, 0.3], [1.0, 2.0, 1.0], [0.5, -1.0, 2.9]])
ENDS = np.array([[0.3, 0.3], [0.2, 1.8], [2.9, 2.9]])  # m: of a bounce both differ
ECHOES = PlaneEchoes(POINTS, ENDS, np.ones(3, dtype=np.complex128), np.zeros(3, dtype=np.int64), np.array([1, 2, 1]))
LATTICE = Lattice.over(POINTS, np.full(3, 1.0), 1.5, 0.0)


def leg(by_sea: bool, distance: float, earth_radius: float) -> BodyLeg:
    return BodyLeg(by_sea, MAP_POSE, np.array([0.0, distance, 15.0]), earth_radius)


def test_a_leg_alone_and_a_sea_that_lowers_little_weigh_nothing() -> None:
    assert over_nodes((leg(False, 1e3, np.inf),), LATTICE, ECHOES) == [1.0]
    assert over_nodes((leg(False, 1e3, np.inf), leg(True, 1e3, np.inf)), LATTICE, ECHOES) == [1.0] * 3
    assert flattest((leg(False, 1e3, np.inf),)) == np.inf
    assert flattest((leg(False, 1e3, np.inf), leg(True, 1e3, np.inf))) == FLATTEST


def test_the_curved_sea_weighs_points_over_what_nodes_share() -> None:
    """At 12 km its divergence bends over a cell's height: weights times what nodes share are those at the points."""
    legs = (leg(False, 12e3, 8.5e6), leg(True, 12e3, 8.5e6))
    for ways, weight in enumerate(over_nodes(legs, LATTICE, ECHOES)):
        shared = LATTICE.between(legs[1].weight(LATTICE.nodes) ** ways)
        np.testing.assert_allclose(weight * shared, legs[1].weight(POINTS) ** ways, rtol=1e-12)


def test_a_leg_for_all_paths_weighs_both_ends_of_bounces() -> None:
    height = np.linspace(0.0, 10.0, 50)
    field = SeaField(height, ((height / 10.0) ** 2).astype(np.complex128), True, 4.8, 3.0)
    alone = dataclasses.replace(leg(False, 12e3, 8.5e6), sea=field)
    (weight,) = over_nodes((alone,), LATTICE, ECHOES)
    np.testing.assert_allclose(
        weight * LATTICE.between(field.at(LATTICE.nodes[:, 2]) ** 2), field.at(ENDS).prod(axis=1), rtol=1e-9
    )
    assert flattest((alone,)) == pytest.approx(min(FLATTEST, 0.3 * 4.8))
