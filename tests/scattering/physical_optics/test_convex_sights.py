"""Which instants of a body are plain, and which triangles of others may stand before it."""

from typing import Any

import numpy as np
import pytest

from radar_service.scattering.model import Instant
from radar_service.scattering.physical_optics.cast_shadows import Onlooker
from radar_service.scattering.physical_optics.convex_sights import Casters, Sights, casters_over, plain_sights
from radar_service.scattering.physical_optics.picture import Picture
from tests.scattering.physical_optics.test_convex_bodies import BEFORE, TIMES, hull, optics_and_sight, prepared_for


def sights(
    body: dict[str, Any], max_range: float = 3000.0, environment: dict[str, Any] | None = None, **radar: Any
) -> Sights | None:
    ready = prepared_for(body, environment=environment, **radar)
    instant = Instant(float(TIMES[0]), optics_and_sight(ready)[1], max_range)
    made = ready.scene
    return plain_sights(made.bodies[0], made.radar, made.environment, made.antenna(TIMES), TIMES, instant)


def test_a_hull_under_way_is_plain_with_both_legs_and_one_of_them_without_the_sea() -> None:
    result, direct = sights(hull(760.0)), sights(hull(760.0), environment={"multipath": False})
    assert result is not None and direct is not None and (result.legs, direct.legs) == (2, 1)
    travelled = np.linalg.norm(np.diff(result.position, axis=0), axis=1)
    np.testing.assert_allclose(travelled, 8.0 * 1852.0 / 3600.0 * np.diff(TIMES), rtol=1e-9)


@pytest.mark.parametrize("kind", ["rolls", "heaves", "beyond", "behind-the-horizon", "diffracted"])
def test_a_body_is_not_plain(kind: str) -> None:
    """765 m of maximum range cut its far end off; 4 m up the horizon of what lies at the sea is 8 km off."""
    cases: dict[str, Any] = {
        "rolls": {"body": hull(760.0, roll_deg=2.0, roll_period_s=6.0)},
        "heaves": {"body": hull(760.0, heave_m=0.5)},
        "beyond": {"body": hull(760.0), "max_range": 765.0},
        "behind-the-horizon": {"body": hull(9000.0), "max_range": 20e3, "range_max_m": 15000, "height_m": 4},
        "diffracted": {
            "body": hull(7000.0), "max_range": 20e3, "range_max_m": 15000, "height_m": 4,
            "environment": {"multipath": True, "diffraction": True},
        },
    }  # fmt: skip
    assert sights(**cases[kind]) is None


def test_casters_are_where_they_move_and_absent_ones_and_those_aside_are_none() -> None:
    """The nearer hull of two is taken as it is, where its motion has it at each instant; the other one has sailed on by then."""
    gone = {**hull(600.0), "start_s": 100.0}
    ready = prepared_for(hull(760.0), *BEFORE, gone)
    scene, (_, sight) = ready.scene, optics_and_sight(ready)
    antenna, middle = scene.antenna(TIMES), len(TIMES) // 2
    corners = scene.bodies[0].mesh.vertices + scene.bodies[0].middle_at(TIMES[middle])  # type: ignore[union-attr]
    onlooker = Onlooker(corners[:8], (Picture(antenna[middle], sight.earth_radius, False),), 12)
    casters = casters_over(0, onlooker, antenna, TIMES, Instant(float(TIMES[0]), sight, 3000.0))
    assert casters.begin.tolist() == [0, len(scene.bodies[1].mesh.faces)]  # type: ignore[union-attr]
    for number, body in enumerate(scene.bodies[1:2]):
        pose = body.motion.pose(TIMES)
        np.testing.assert_array_equal(casters.position[:, number], pose.position)
        ahead = casters.turn[:, number] @ [0.0, 1.0, 0.0]
        np.testing.assert_allclose(np.arctan2(ahead[:, 0], ahead[:, 1]), pose.heading - 2 * np.pi * (pose.heading > np.pi))


def test_instants_are_chosen_together() -> None:
    casters = Casters(
        np.array([0]), np.zeros((0, 3, 3)), np.arange(27.0).reshape(3, 1, 3, 3), np.arange(9.0).reshape(3, 1, 3)
    )
    some = casters.chosen(np.array([2]))
    assert some.turn[0, 0, 0, 0] == 18.0 and some.position[0, 0, 0] == 6.0
    each = Sights(np.arange(6.0).reshape(2, 3), np.array([0.1, 0.2]), np.zeros((2, 3)), np.inf, 2).chosen(np.array([1]))
    assert each.position.tolist() == [[3.0, 4.0, 5.0]] and each.heading.tolist() == [0.2] and each.legs == 2


def test_the_antenna_lies_in_the_frame_of_the_body() -> None:
    """From a body that heads east an antenna 5 m north of it lies 5 m to port."""
    sight = Sights(np.array([[3.0, 1.0, 0.0]]), np.array([np.pi / 2]), np.array([[3.0, 6.0, 2.0]]), np.inf, 1)
    np.testing.assert_allclose(sight.antenna_in_frame, [[-5.0, 0.0, 2.0]], atol=1e-15)
