"""Layers of a mesh so close to each other that neither shadows the other: both reflect, where a real hull has one skin."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facets import centroids
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Mesh
from radar_service.trace.embree import TriangleScene
from radar_service.trace.occluder import TOLERANCE

PARALLEL = 0.999  # cosine between normals: 2.6 degrees
APART = 2e-4  # m, at most, by which layers in one place are told apart: a tenth of TOLERANCE
GOLDEN = (5.0**0.5 - 1.0) / 2.0  # steps of it spread evenly over 0 to 1


class Layers(NamedTuple):
    """Triangles of a mesh that are doubled: how many, and their share of the area of the mesh."""

    facets: int
    share: float


def doubled_layers(mesh: Mesh, outside: NDArray[np.int8]) -> Layers:
    """The triangles at whose middle another one lies within TOLERANCE, parallel, and lit from the same side.

    A line of sight ends TOLERANCE before its point, so neither shadows the other. Sides that face each other, as a crate's bottom
    and the deck under it, are not lit together; this is known of closed parts (`outward_side`).
    """
    _, normal, area = triangle_frames(mesh)
    shift = APART * (np.arange(len(area)) * GOLDEN % 1.0)
    corners = mesh.vertices[mesh.faces] + (shift[:, None] * normal)[:, None]
    scene = TriangleScene(corners.reshape(-1, 3), np.arange(3 * len(area)).reshape(-1, 3))
    doubled = np.zeros(len(area), dtype=np.bool_)
    for out in (normal, -normal):
        begin = centroids(corners) + TOLERANCE * out
        hit = scene.first_hit(begin, -out)
        near = scene.hit_distance(hit, begin, -out) < 2.0 * TOLERANCE
        alike = np.einsum("ij,ij->i", normal, normal[hit])
        together = outside * outside[hit] * np.sign(alike) >= 0.0
        doubled |= (hit >= 0) & (hit != np.arange(len(hit))) & near & (np.abs(alike) > PARALLEL) & together
    return Layers(int(doubled.sum()), float(area[doubled].sum() / area.sum()))
