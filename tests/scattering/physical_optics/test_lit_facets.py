"""Which facets each leg lights."""

import numpy as np

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scene.body import Mesh
from radar_service.scene.poses import BodyPose
from tests.scattering.physical_optics.meshes import optical
from tests.scenes import scene

ANTENNA = np.array([0.0, 0.0, 15.0])


def seen(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    return np.ones(len(points), dtype=np.bool_)


def test_a_flare_is_lit_from_below_alone() -> None:
    """The side of a hull leans out by 45 degrees: the antenna above does not light it, the sea before it does."""
    made = scene([{"name": "b", "shape": "box", "length_m": 4, "width_m": 4, "height_m": 4, "scattering": "optics",
                   "position_m": [0, 300, 0]}])  # fmt: skip
    body = optical(made)
    mesh = body.mesh
    flared = mesh.vertices.copy()
    flared[:, :2] *= 1.0 + flared[:, 2:] / 4.0
    wide = Mesh(flared, mesh.faces)
    made = scene([], radar={"height_m": 60.0})
    pose, antenna = BodyPose(np.array([0.0, 100.0, 0.0]), 0.0), np.array([0.0, 0.0, 60.0])
    legs = tuple(BodyLeg(by_sea, pose, antenna, np.inf, seen, crowded=False, thin=False) for by_sea in (False, True))
    from radar_service.scattering.physical_optics.optical_body import optical_body
    from tests.scenes import radar

    flare = optical_body(scene_body(wide), radar(), 1)
    lit = flare.lit_facets(legs, 0.0)
    south = lit.normal[:, 1] < -0.5
    assert south.any() and not (lit.share[south, 0] > 0).any() and (lit.share[south, 1] == 1.0).all()
    deck = lit.normal[:, 2] > 0.9
    assert (lit.share[deck, 0] == 1.0).all() and not (lit.share[deck, 1] > 0).any()


def scene_body(mesh: Mesh) -> object:
    """A metal body of this mesh."""
    from dataclasses import replace

    body = scene([{"name": "b", "shape": "box", "length_m": 4, "width_m": 4, "height_m": 4, "scattering": "optics"}]).bodies[
        0
    ]
    return replace(body, mesh=mesh)
