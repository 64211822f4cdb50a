"""Scatterers: points fixed on the surface of a body, made once in its own frame, each standing for some area.

Because they are fixed, phases repeat when nothing moves and change as they should when something does.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.fidelity import MIN_SCATTERERS
from radar_service.scene.world import Mesh

Floats = NDArray[np.float64]

MOST = 1_500_000  # points on one body: some 250 MB while they are laid


@dataclass(frozen=True)
class Scatterers:
    """Points (E,) in a body's frame: position (E, 3) [m], normal (E, 3) unit, area (E,) [m^2], triangle, unit phasor."""

    position: Floats
    normal: Floats
    area: Floats
    triangle: NDArray[np.int64]
    phasor: NDArray[np.complex128]

    def __post_init__(self) -> None:
        count = len(self.area)
        assert self.position.shape == self.normal.shape == (count, 3)
        assert self.triangle.shape == self.phasor.shape == (count,)

    def __len__(self) -> int:
        return len(self.area)


def point_scatterer(place: Floats) -> Scatterers:
    """The one scatterer of a body that counts as a point, at `place` (3,) in its frame [m]."""
    return Scatterers(place[None, :].copy(), np.zeros((1, 3)), np.ones(1), np.full(1, -1), np.ones(1, dtype=np.complex128))


def no_scatterers() -> Scatterers:
    """None: of a body that scatters in another way."""
    return Scatterers(
        np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.complex128)
    )


def triangle_frames(mesh: Mesh) -> tuple[Floats, Floats, Floats]:
    """Centroids (F, 3) [m], unit normals (F, 3) and areas (F,) [m^2] of the triangles of a mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(double > 0, double, 1.0)[:, None]
    return (a + b + c) / 3.0, normal, double / 2.0


def scatter_over(mesh: Mesh, density: Floats, rng: np.random.Generator, min_scatterers: int = MIN_SCATTERERS) -> Scatterers:
    """Points spread over a mesh with `density` (F,) [per m^2] expected on each triangle.

    Systematic sampling along the cumulated expectation: every triangle gets the number it is owed to within one, and a
    triangle owed less than one is represented by its neighbours, so that the area carried is right in the mean. The
    density is scaled to keep the total between `min_scatterers` and MOST.
    """
    _, normal, area = triangle_frames(mesh)
    owed = area * density
    scale = np.clip(owed.sum(), min_scatterers, MOST) / owed.sum()
    owed = owed * scale
    cumulated = np.cumsum(owed)
    count = int(np.ceil(cumulated[-1]))
    ticks = (np.arange(count) + rng.random(count)) * (cumulated[-1] / count)
    triangle = np.minimum(np.searchsorted(cumulated, ticks, side="right"), len(owed) - 1)
    u, v = rng.random((2, count))
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    a, b, c = (mesh.vertices[mesh.faces[triangle, i]] for i in range(3))
    position = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    carried = cumulated[-1] / count / (density[triangle] * scale)
    phasor = np.exp(2j * np.pi * rng.random(count))
    return Scatterers(position, normal[triangle], carried, triangle, phasor)


def cell_density(distance: Floats, range_step: float, beamwidth: float, per_cell: float) -> Floats:
    """Points per m^2 of surface at `distance` (F,) [m] that put `per_cell` of them into a cell of range step by beam."""
    across = np.maximum(beamwidth * distance, range_step)
    return per_cell / (range_step * across)
