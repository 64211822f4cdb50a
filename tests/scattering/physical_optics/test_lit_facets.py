"""Which facets each leg lights."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_deck
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.cast_shadows import CastShadows
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.optical_body import optical_body
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPose
from tests.scenes import scene

BOX = {
    "name": "b",
    "shape": "box",
    "length_m": 4,
    "width_m": 4,
    "height_m": 4,
    "scattering": "optics",
    "position_m": [0, 1, 0],
}


def seen(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    return np.ones(len(points), dtype=np.bool_)


def test_a_flare_is_lit_from_below_alone() -> None:
    """Sides that lean out by 27 degrees, seen from 71 degrees above: the antenna lights the deck alone, the sea the sides."""
    made = scene([BOX])
    box = made.bodies[0]
    assert box.mesh is not None
    wide = box.mesh.vertices.copy()
    wide[:, :2] *= 1.0 + wide[:, 2:] / 4.0
    flare = optical_body(replace(box, mesh=Mesh(wide, box.mesh.faces)), made.radar, 1)
    pose, antenna = BodyPose(np.array([0.0, 100.0, 0.0]), 0.0), np.array([0.0, 0.0, 300.0])
    legs = tuple(BodyLeg(by_sea, pose, antenna, np.inf, seen) for by_sea in (False, True))
    surface, lit = flare.lit_facets(legs, 0.0)
    south, deck = lit.normal[1] < -0.5, lit.normal[2] > 0.9
    assert south.any() and not (lit.share[south, 0] > 0).any() and (lit.share[south, 1] == 1.0).all()
    assert deck.any() and (lit.share[deck, 0] == 1.0).all() and not (lit.share[deck, 1] > 0).any()
    assert (lit.side[south, 1] == lit.side[south, 1][0]).all()


def test_no_ray_looks_for_shadows_of_its_own_where_another_body_covers_it() -> None:
    """A wall before the lower half of a box hides it: without a ray, and the rest is lit as if rays had been asked everywhere."""
    made = scene([BOX])
    box = optical_body(made.bodies[0], made.radar, 1)
    pose, picture = BodyPose(np.array([0.0, 100.0, 0.0]), 0.0), Picture(np.array([0.0, 0.0, 2.0]), np.inf, False)
    wall = CastShadows(picture, np.array([[[-90.0, 50.0, -2.0], [90.0, 50.0, -2.0], [0.0, 50.0, 0.0]]]))
    asked = list[np.ndarray]()

    def reached(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
        asked.append(points)
        return np.ones(len(points), dtype=np.bool_)

    leg = BodyLeg(False, pose, picture.antenna, np.inf, reached, others=wall)
    surface, lit = box.lit_facets((leg,), 0.0)
    heights = np.concatenate(asked)[:, 2]
    south = lit.normal[1] < -0.5
    exact = 4.0 * (4.0 - np.mean(2.0 - 2.0 * np.abs(np.linspace(-2.0, 2.0, 4001)) / 90.0))
    assert heights.min() > 1.3  # a facet of 2 m is covered as a whole, or not
    assert lit.area[south].sum() == pytest.approx(exact, rel=1e-3)


def test_planes_of_a_leaning_body_are_those_of_the_rotated_mesh() -> None:
    box = scene([BOX]).bodies[0].mesh
    assert box is not None
    lean = map_from_deck(np.array(0.3), np.array(0.2), np.array(-0.1))
    rotated, anew = Planes.of(box).rotated(lean), Planes.of(Mesh(box.vertices @ lean.T, box.faces))
    np.testing.assert_allclose(rotated.point, anew.point, atol=1e-12)
    np.testing.assert_allclose(rotated.normal, anew.normal, atol=1e-12)
    np.testing.assert_array_equal(rotated.may_rebounce, anew.may_rebounce)
    same = rotated.number[:, None] == rotated.number
    np.testing.assert_array_equal(same, anew.number[:, None] == anew.number)
