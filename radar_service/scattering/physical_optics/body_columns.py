"""Columns of a large body: each is cut as finely as its own distance asks."""

from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.physical_optics.facets import cut_triangles
from radar_service.world.body import Mesh

WIDTH = 32.0  # m; a body that fits into one has no other


class BodyColumn(NamedTuple):
    """A part of a mesh: its triangles, the triangle of the whole mesh that each comes from (F,), and the circle about it in plan:
    centre (2,) and radius [m]."""

    mesh: Mesh
    triangle: Indices
    centre: Floats
    radius: float

    def distance(self, antenna: Floats) -> float:
        """From an antenna (3,) in the body's frame, in plan [m]."""
        return float(np.hypot(*(antenna[:2] - self.centre))) - self.radius


def body_columns(mesh: Mesh) -> tuple[BodyColumn, ...]:
    """The mesh in columns of WIDTH by WIDTH, triangles longer than that cut."""
    corners = mesh.vertices[mesh.faces]
    if np.ptp(corners[:, :, :2].reshape(-1, 2), axis=0).max() <= WIDTH:
        return (_column(corners, np.arange(len(corners))),)
    corners, triangle = cut_triangles(corners, WIDTH)
    column = np.floor((corners.mean(axis=1) - mesh.vertices[mesh.faces].min(axis=(0, 1)))[:, :2] / WIDTH)
    number = column[:, 0] * (column[:, 1].max() + 1.0) + column[:, 1]
    order = np.argsort(number, kind="stable")
    members = np.split(order, np.flatnonzero(np.diff(number[order])) + 1)
    return tuple(_column(corners[which], triangle[which]) for which in members)


def _column(corners: Floats, triangle: Indices) -> BodyColumn:
    plan = corners[:, :, :2].reshape(-1, 2)
    centre = (plan.min(axis=0) + plan.max(axis=0)) / 2.0
    radius = float(np.hypot(*(plan - centre).T).max())
    return BodyColumn(Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)), triangle, centre, radius)
