"""Points of a body's surface by which the truth decides whether any part of it is visible: few at first, more where none is.

A body in plain sight is told by its outermost vertices. What others hide in part is asked in its faces, along its outline as the
antenna sees it, and in vertical columns between the corners of all bodies in between: an opening between two walls has corners
at its sides alone, so a column passes through it however narrow it is.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Floats, Indices
from radar_service.scattering.surface_sampling import R2, triangle_frames
from radar_service.world.body import Mesh

OUTWARD = np.array(
    [[0, 0, 8], [1, 1, 2], [1, -1, 2], [-1, 1, 2], [-1, -1, 2], [1, 0, 0.1], [-1, 0, 0.1], [0, 1, 0.1], [0, -1, 0.1]]
)  # top, upper corners, sides
FACE_POINTS = 512  # of a body, spread evenly over the area of its faces
FACE_SHARE, MAX_FACE_POINTS = 4, 4096  # one for so many triangles of a fine mesh, at most
PLAN_CELLS = 64  # on a side of the plan, of a fine mesh: the highest vertex of each is a corner
MAX_CORNERS = PLAN_CELLS**2
OUTLINE = 128  # parts of a body's width in azimuth; each asks its highest and its nearest corner
MAX_EDGES = 1024  # of a mesh whose columns end at its edges; those of a finer one end at its outline
EVEN_COLUMNS, MAX_OPENINGS = 16, 256  # over a body's width; between corners of others, the widest
TOP = 0.999  # of a column, from the bottom to the top of the body there: just below its outline
ROWS = np.array(
    [TOP, 0.9, 0.7, 0.5, 0.3, 0.1, 0.001]
)  # of columns in the middle of openings; those at their sides have the top alone
SIDE = 0.01  # of an opening, from its side: edges are straight in between, so what shows above another shows at one side


class View(NamedTuple):
    """Points (N,) as the antenna sees them: azimuth from a middle [rad], ground distance [m], and rise over it."""

    azimuth: Floats
    distance: Floats
    slope: Floats


@dataclass(frozen=True)
class Surface:
    """The mesh of a body, and points of it in the body's own frame [m], each computed once where they are needed."""

    mesh: Mesh

    @cached_property
    def corners(self) -> Floats:
        """The vertices (C, 3) that faces use; of more than MAX_CORNERS the highest of each cell of the plan."""
        vertices = _used(self.mesh)
        if len(vertices) <= MAX_CORNERS:
            return vertices
        plan = vertices[:, :2] - vertices[:, :2].min(axis=0)
        cell = np.minimum(plan / np.maximum(plan.max(axis=0), 1e-9) * PLAN_CELLS, PLAN_CELLS - 1).astype(np.int64)
        return vertices[_last_of_each(cell[:, 0] * PLAN_CELLS + cell[:, 1], vertices[:, 2])]

    @cached_property
    def faces(self) -> tuple[Floats, Indices]:
        """Points (P, 3) in faces, evenly over their area, and the triangle of each."""
        area = triangle_frames(self.mesh)[2]
        count = int(np.clip(len(area) // FACE_SHARE, FACE_POINTS, MAX_FACE_POINTS))
        cumulated = np.cumsum(area)
        triangle = np.searchsorted(cumulated, (np.arange(count) + 0.5) * (cumulated[-1] / count))
        u, v = np.outer(R2, np.arange(1, count + 1)) % 1.0
        u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
        a, b, c = self.mesh.vertices[self.mesh.faces[triangle]].transpose(1, 0, 2)
        return a + u[:, None] * (b - a) + v[:, None] * (c - a), triangle

    @cached_property
    def edges(self) -> Floats:
        """Ends (2, N, 3) of the edges of its triangles."""
        faces = self.mesh.faces
        pairs = np.unique(np.sort(np.concatenate([faces[:, :2], faces[:, 1:], faces[:, ::2]]), axis=1), axis=0)
        return np.asarray(self.mesh.vertices[pairs.T])


def outermost(mesh: Mesh) -> Floats:
    """The vertices (K, 3) that lie farthest out in the directions of OUTWARD, in the body's own frame [m]."""
    vertices = _used(mesh)
    return np.asarray(vertices[np.unique(np.argmax(vertices @ OUTWARD.T, axis=0))])


def _used(mesh: Mesh) -> Floats:
    """The vertices (V, 3) that faces use."""
    used = np.zeros(len(mesh.vertices), dtype=np.bool_)
    used[mesh.faces] = True
    return mesh.vertices[used]


def viewed(points: Floats, antenna: Floats, earth_radius: float, middle: float) -> View:
    """Points (N, 3) on the map [m] from the antenna (3,); middle: azimuth that counts as 0 [rad]."""
    east, north = points[:, 0] - antenna[0], points[:, 1] - antenna[1]
    distance = np.maximum(np.hypot(east, north), 1e-6)
    up = points[:, 2] - antenna[2] - distance**2 / (2.0 * earth_radius)
    return View(wrap_angle(np.arctan2(east, north) - middle), distance, up / distance)


def outline(view: View) -> Indices:
    """The highest and the nearest of viewed points in each of OUTLINE parts of their width."""
    return np.union1d(_outermost_by_part(view, view.slope), _outermost_by_part(view, -view.distance))


def columns(own: View, others: View) -> tuple[Floats, Floats]:
    """Azimuths from the middle [rad] over the width of a body: (M,) where whole columns are asked, EVEN_COLUMNS and one in each
    opening, and (S,) where only their tops are, at the sides of openings. An opening lies between two corners of the others in
    front."""
    low, high = float(own.azimuth.min()), float(own.azimuth.max())
    before = (others.azimuth > low) & (others.azimuth < high) & (others.distance < own.distance.max())
    edge = np.unique(np.concatenate([[low], others.azimuth[before], [high]]))
    widest = np.argsort(-np.diff(edge), kind="stable")[:MAX_OPENINGS]
    begin, width = edge[widest], np.diff(edge)[widest]
    even = low + (high - low) * (np.arange(EVEN_COLUMNS) + 0.5) / EVEN_COLUMNS
    sides = np.append(begin + SIDE * width, begin + (1.0 - SIDE) * width)
    return np.append(begin + width / 2.0, even), sides


def ends_at_edges(edges: Floats, antenna: Floats, earth_radius: float, azimuth: Floats) -> tuple[Floats, Floats]:
    """The lowest and the highest slope (C,) at which edges of a body, ends (2, N, 3) on the map [m], meet the vertical planes of
    azimuths (C,) [rad] from the antenna (3,); nan where none does."""
    along, across = np.stack([np.sin(azimuth), np.cos(azimuth)]), np.stack([np.cos(azimuth), -np.sin(azimuth)])
    begin, end = edges - antenna
    off, step = begin[:, :2] @ across, (begin - end)[:, :2] @ across
    share = np.divide(off, step, out=np.full_like(off, np.nan), where=(off < 0.0) != (off < step))
    distance = begin[:, :2] @ along - share * ((begin - end)[:, :2] @ along)
    up = begin[:, 2:] + share * (end - begin)[:, 2:] - distance**2 / (2.0 * earth_radius)
    slope = np.divide(up, distance, out=np.full_like(up, np.nan), where=distance > 0.0)
    return np.fmin.reduce(slope, axis=0), np.fmax.reduce(slope, axis=0)


def ends_at_outline(own: View, azimuth: Floats) -> tuple[Floats, Floats]:
    """The same by the corners of a fine mesh; azimuth: (C,) from the middle [rad]."""
    ends = []
    for sign in (-1.0, 1.0):
        which = _outermost_by_part(own, sign * own.slope)
        order = which[np.argsort(own.azimuth[which])]
        ends.append(np.interp(azimuth, own.azimuth[order], own.slope[order]))
    return ends[0], ends[1]


def column_points(
    antenna: Floats, earth_radius: float, azimuth: Floats, ends: tuple[Floats, Floats], beyond: float, rows: Floats
) -> Floats:
    """Positions (R, 3) on the map [m] at a ground distance `beyond` a body [m]: at `rows` (K,) of 0 to 1 between the ends (C,) of
    its columns at azimuths (C,) [rad]."""
    low, high = ends
    met = ~np.isnan(low)
    slope = (low + rows[:, None] * (high - low))[:, met].ravel()
    plan = beyond * np.stack([np.sin(azimuth[met]), np.cos(azimuth[met])], axis=1)
    return antenna + np.column_stack([np.tile(plan, (len(rows), 1)), beyond * slope + beyond**2 / (2.0 * earth_radius)])


def _outermost_by_part(view: View, value: Floats) -> Indices:
    """The point of the greatest value in each of OUTLINE parts of the width of viewed points (N,)."""
    low, width = view.azimuth.min(), max(float(np.ptp(view.azimuth)), 1e-12)
    return _last_of_each(np.minimum((view.azimuth - low) / width * OUTLINE, OUTLINE - 1).astype(np.int64), value)


def _last_of_each(group: Indices, value: Floats) -> Indices:
    """The index of the greatest value in each group (N,) that there is."""
    order = np.lexsort((value, group))
    return np.asarray(order[np.append(np.diff(group[order]) != 0, True)])
