"""A mesh cut into facets small enough for physical optics: within the range cell and the beam, with little bend of the phase."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Floats, Indices
from radar_service.radar.parameters import Radar
from radar_service.scattering.predictions import NEAREST
from radar_service.world.body import Mesh

MAX_FACETS = 60_000  # of one column of a body (`body_columns`): some 100 MB and 60 ms while they are evaluated
ENLARGEMENT_STEP = 2.0**0.5  # one more cut through a right isosceles triangle shortens its longest edge by this
MAX_BEND = 0.3  # rad, two-way, over half an edge (docs/engine.md#errors)
# Of the beam's width and of the range cell that a facet and a cell may take: what weighs them is linear in between
BEAM_SHARE, RANGE_SHARE = 1.0 / 6.0, 1.0 / 4.0
EXTENT_SHARE = 1.0 / 9.0  # of the body, likewise: its sidelobes are what is left of many cells
FACET_SHARE = 3.0 / 5.0  # of the range cell, of a facet: few lie along the line of sight
BOX_CORNERS = np.arange(8)[:, None] & [1, 2, 4] > 0  # (8, 3) at which end of each axis each lies


class EdgeLimits(NamedTuple):
    """What bounds facets and the cells in which they are summed: range resolution [m], beamwidth [rad], wavelength [m], and the
    extent of the body [m]."""

    range_cell: float
    beamwidth: float
    wavelength: float
    extent: float

    def cell(self, distance: float) -> float:
        """Size [m] of the cells at `distance` [m], the same throughout half an octave."""
        return min(RANGE_SHARE * self.range_cell, self._widest(distance))

    def at(self, distance: float) -> tuple[float, float]:
        """Cell and longest edge [m] at `distance` [m]."""
        return self.cell(distance), self.longest_edge(distance)

    def longest_edge(self, distance: float) -> float:
        """The longest edge [m] of facets at `distance` [m]."""
        bend = bend_edge(_half_octave(distance), self.wavelength)
        return min(FACET_SHARE * self.range_cell, self._widest(distance), bend)

    def _widest(self, distance: float) -> float:
        """What the beam and the body's extent allow at `distance` [m]."""
        return min(BEAM_SHARE * self.beamwidth * _half_octave(distance), EXTENT_SHARE * self.extent)


def edge_limits(radar: Radar, mesh: Mesh) -> EdgeLimits:
    """What bounds the facets of a mesh for this radar."""
    extent = float(np.ptp(mesh.used_vertices, axis=0).max())
    return EdgeLimits(radar.range_resolution, radar.beamwidth, radar.wavelength, extent)


def bend_edge(distance: float, wavelength: float) -> float:
    """The edge [m] over half of which the two-way phase at `distance` [m] bends by MAX_BEND: k (e/2)^2 / R."""
    return float(np.sqrt(2.0 * MAX_BEND * wavelength * distance / np.pi))


def _half_octave(distance: float) -> float:
    return float(2.0 ** (np.floor(2.0 * np.log2(max(distance, NEAREST))) / 2.0))


@dataclass(frozen=True)
class Facets:
    """Flat facets (M,) in a body's frame.

    corners: (M, 3, 3) [m].
    centre: (M, 3), the centroid [m].
    normal: (M, 3), of unit length.
    triangle: (M,) of the mesh that each was cut from.
    enlargement: how much longer than requested the edges may be, 1 if not at all.
    """

    corners: Floats
    centre: Floats
    normal: Floats
    triangle: Indices
    enlargement: float

    def __post_init__(self) -> None:
        count = len(self.triangle)
        assert self.corners.shape == (count, 3, 3) and self.normal.shape == self.centre.shape == (count, 3)

    def __len__(self) -> int:
        return len(self.triangle)


def cut_facets(mesh: Mesh, longest: float, max_facets: int = MAX_FACETS) -> Facets:
    """The triangles of a mesh cut until no edge exceeds `longest` [m].

    `longest` grows where it would make more than `max_facets` facets, and more than the mesh has triangles.
    """
    triangles = mesh.vertices[mesh.faces]
    bound, enlargement = max(max_facets, len(triangles)), 1.0
    while (cut := _cut(triangles, np.full(len(triangles), longest * enlargement), bound)) is None:
        enlargement *= ENLARGEMENT_STEP
    corners, triangle = cut
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    sound = double > 0.0
    corners = corners[sound]
    return Facets(corners, corners.mean(axis=1), cross[sound] / double[sound, None], triangle[sound], enlargement)


def cut_triangles(corners: Floats, longest: Floats | float) -> tuple[Floats, Indices]:
    """Triangles (F, 3, 3) halved until no edge exceeds `longest` (F,) [m], and the one that each comes from, rising."""
    limits = np.ascontiguousarray(np.broadcast_to(longest, len(corners)), dtype=np.float64)
    taken, room = (np.ascontiguousarray(corners), limits), 2 * len(corners)
    while True:
        parts, origin = np.empty((room, 3, 3)), np.empty(room, dtype=np.int64)
        if (count := KERNELS.cut_triangles(len(corners), room, *taken, parts, origin)) <= room:
            return parts[:count], origin[:count]
        room = count


def _cut(corners: Floats, longest: Floats, limit: int) -> tuple[Floats, Indices] | None:
    """Triangles (F, 3, 3) halved across their longest edge until none is too long; None once there are too many."""
    done: list[tuple[Floats, Indices]] = [(np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64))]
    triangle = np.arange(len(corners))
    count = 0
    while len(corners):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        fits = edges.max(axis=1) <= longest[triangle]
        done.append((corners[fits], triangle[fits]))
        count += int(fits.sum())
        if count + 2 * int((~fits).sum()) > limit:
            return None
        corners, triangle = _halved(corners[~fits], edges[~fits].argmax(axis=1)), np.tile(triangle[~fits], 2)
    joined, origin = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.argsort(origin, kind="stable")
    return joined[order], origin[order]


def areas(corners: Floats) -> Floats:
    """Areas (M,) of triangles (M, 3, 3) [m^2]."""
    (ux, uy, uz), (vx, vy, vz) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return np.asarray(np.sqrt(x * x + y * y + z * z) / 2.0)


def box_corners(low: Floats, high: Floats) -> Floats:
    """The corners (8, 3) of a box from its lowest to its highest coordinates (3,) [m]."""
    return np.asarray(np.where(BOX_CORNERS, high, low))


def box_around(corners: Floats) -> Floats:
    """The corners (8, 3) of a box that holds triangles (M, 3, 3) [m]."""
    return box_corners(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)))


def centroids(corners: Floats) -> Floats:
    """Centroids (M, 3) of triangles (M, 3, 3) [m]; six times as fast as a mean along an axis."""
    return np.asarray((corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3.0)


def _halved(corners: Floats, edge: Indices) -> Floats:
    """Both halves (2 M, 3, 3) of triangles (M, 3, 3) cut from the middle of edge (M,), edge i from corner i to i + 1."""
    turn = (edge[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, turn[:, :, None], axis=1).transpose(1, 0, 2)
    middle = (a + b) / 2.0
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
