"""Fixed scatterers: points on the surface of a body, drawn once in its own frame, each standing for some area.

Because they are fixed, phases repeat when nothing moves, and change with the geometry when something moves.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.fidelity import MIN_SCATTERERS
from radar_service.scene.body import Mesh
from radar_service.types import Complexes, Floats, Indices

MAX_SCATTERERS = 1_500_000  # on one body: some 250 MB while they are spread


@dataclass(frozen=True)
class Scatterers:
    """Scatterers (E,) in a body's frame.

    position: (E, 3) [m].
    normal: (E, 3), of unit length; 0 for a point.
    area: (E,) that each stands for [m^2].
    triangle: (E,) index in the mesh, -1 for a point.
    phasor: (E,) of unit length: the random phase.
    """

    position: Floats
    normal: Floats
    area: Floats
    triangle: Indices
    phasor: Complexes

    def __post_init__(self) -> None:
        count = len(self.area)
        assert self.position.shape == self.normal.shape == (count, 3)
        assert self.triangle.shape == self.phasor.shape == (count,)

    def __len__(self) -> int:
        return len(self.area)


def point_scatterer(position: Floats) -> Scatterers:
    """The single scatterer of a body that counts as a point, at `position` (3,) in its frame [m]."""
    return Scatterers(
        position[None, :].copy(), np.zeros((1, 3)), np.ones(1), np.full(1, -1), np.ones(1, dtype=np.complex128)
    )


def triangle_frames(mesh: Mesh) -> tuple[Floats, Floats, Floats]:
    """Centroids (F, 3) [m], unit normals (F, 3) and areas (F,) [m^2] of the triangles of a mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(double > 0, double, 1.0)[:, None]
    return (a + b + c) / 3.0, normal, double / 2.0


def sample_surface(
    mesh: Mesh, density: Floats, rng: np.random.Generator, min_scatterers: int = MIN_SCATTERERS
) -> Scatterers:
    """Scatterers drawn over a mesh with an expected `density` (F,) on each triangle [per m^2].

    Systematic sampling along the cumulated expectation: each triangle gets its expected number to within one. A triangle
    that expects less than one is represented by its neighbours, so the area is right in the mean. The density is scaled
    to keep the total between `min_scatterers` and MAX_SCATTERERS.
    """
    _, normal, area = triangle_frames(mesh)
    expected = area * density
    scale = np.clip(expected.sum(), min_scatterers, MAX_SCATTERERS) / expected.sum()
    expected = expected * scale
    cumulated = np.cumsum(expected)
    count = int(np.ceil(cumulated[-1]))
    steps = (np.arange(count) + rng.random(count)) * (cumulated[-1] / count)
    triangle = np.minimum(np.searchsorted(cumulated, steps, side="right"), len(expected) - 1)
    u, v = rng.random((2, count))
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    a, b, c = (mesh.vertices[mesh.faces[triangle, i]] for i in range(3))
    position = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    represented = cumulated[-1] / count / (density[triangle] * scale)
    phasor = np.exp(2j * np.pi * rng.random(count))
    return Scatterers(position, normal[triangle], represented, triangle, phasor)


def cell_density(distance: Floats, range_step: float, beamwidth: float, per_cell: float) -> Floats:
    """Points per m^2 of surface at `distance` (F,) [m] that put `per_cell` of them into a cell of range step by beam."""
    across = np.maximum(beamwidth * distance, range_step)
    return per_cell / (range_step * across)
