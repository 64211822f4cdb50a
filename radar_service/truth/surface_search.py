"""Points of a body's surface by which the truth decides whether any part of it is visible: few at first, more where none is.

A body in plain sight is told by its outermost vertices. What others hide in part is asked in its faces, along its outline as the
antenna sees it, and in vertical columns between the corners of all bodies in between: an opening between two walls has corners
at its sides alone, so a column passes through it however narrow it is.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.propagation.land_reflection import ABOVE_LAND, LandBefore
from radar_service.propagation.radar_equation import radar_two_rays
from radar_service.scattering.models import scattering_model
from radar_service.scattering.surface_sampling import R2, normals_and_areas
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.world.body import Mesh
from radar_service.world.poses import pose_at
from radar_service.world.scene import Scene

OUTWARD = np.array(
    [[0, 0, 8], [1, 1, 2], [1, -1, 2], [-1, 1, 2], [-1, -1, 2], [1, 0, 0.1], [-1, 0, 0.1], [0, 1, 0.1], [0, -1, 0.1]]
)  # top, upper corners, sides
VERTICES = 2**18  # at a time
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
Candidates = tuple[
    Floats, Callable[[Indices], Flags]
]  # points (W, 3) on the map [m], and which of them, by index, are visible
MAX_SURFACES = 512  # whose points are kept: 200 KB each at most


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
        vertices = self.mesh.used_vertices
        if len(vertices) <= MAX_CORNERS:
            return vertices
        plan = vertices[:, :2] - vertices[:, :2].min(axis=0)
        cell = np.minimum(plan / np.maximum(plan.max(axis=0), 1e-9) * PLAN_CELLS, PLAN_CELLS - 1).astype(np.int64)
        return vertices[_last_of_each(cell[:, 0] * PLAN_CELLS + cell[:, 1], vertices[:, 2])]

    @cached_property
    def faces(self) -> tuple[Floats, Indices]:
        """Points (P, 3) in faces, evenly over their area, and the triangle of each."""
        area = normals_and_areas(self.mesh)[1]
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
    vertices, farthest, index = mesh.used_vertices, np.full(len(OUTWARD), -np.inf), np.zeros(len(OUTWARD), dtype=np.int64)
    for start in range(0, len(vertices), VERTICES):
        reach = vertices[start : start + VERTICES] @ OUTWARD.T
        first, most = reach.argmax(axis=0), reach.max(axis=0)
        index, farthest = np.where(most > farthest, start + first, index), np.maximum(most, farthest)
    return np.asarray(vertices[np.unique(index)])


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


class SurfaceSearch:
    """Points of the bodies of a scene, in the order in which the truth tests them. Safe to call from several threads.

    outermost: points (K, 3) of each body in its own frame [m]; the origin of a body without a mesh.
    """

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self._scene, self._line_of_sight, self._earth_radius = scene, line_of_sight, line_of_sight.earth_radius
        self._surfaces: ResultCache[int, Surface] = ResultCache(MAX_SURFACES)
        self.outermost = [np.zeros((1, 3)) if body.mesh is None else outermost(body.mesh) for body in scene.bodies]

    def candidates(self, body: int, antenna: Floats, time: float, reach: float) -> Iterator[Candidates]:
        """Points of a body with a mesh for the antenna (3,) at `time` [s]; reach: as of `beyond_horizon`."""
        seen = partial(self._line_of_sight.visible, antenna=antenna, time=time, max_range=np.inf, over_horizon=reach)
        faces = self._faces(body, time)
        yield faces.position, lambda lit: seen(_chosen(faces, lit))
        corners = self._corners(body, time)
        view = self._viewed(corners, body, antenna, time)
        ends = corners[outline(view)]
        yield ends, lambda lit: ~self._occluded(ends[lit], antenna, time)
        met = self._in_columns(body, view, antenna, time)
        yield met.position, lambda lit: seen(_chosen(met, lit))
        if scattering_model(self._scene.bodies[body]).lit_by_sea and self._scene.environment.multipath:
            yield faces.position, lambda lit: self._visible_by_sea(_chosen(faces, lit), antenna, time)

    def _surface(self, body: int) -> Surface:
        mesh = self._scene.bodies[body].mesh
        assert mesh is not None
        return self._surfaces.get(body, lambda: Surface(mesh))

    def _faces(self, body: int, time: float) -> SurfacePoints:
        position, triangle = self._surface(body).faces
        return SurfacePoints(np.full(len(triangle), body), triangle, self._placed(position, body, time))

    def _corners(self, body: int, time: float) -> Floats:
        return self._placed(self._surface(body).corners, body, time)

    def _placed(self, points: Floats, body: int, time: float) -> Floats:
        """Points (..., 3) of a body's frame on the map [m]."""
        return pose_at(self._scene.bodies[body], time).map_from_frame(points)

    def _viewed(self, points: Floats, body: int, antenna: Floats, time: float) -> View:
        """Points (N, 3) on the map [m] as the antenna (3,) sees them, from the middle of a body."""
        return viewed(points, antenna, self._earth_radius, self._azimuth(body, antenna, time))

    def _azimuth(self, body: int, antenna: Floats, time: float) -> float:
        """Azimuth of the middle of a body [rad]."""
        east, north = (self._scene.bodies[body].middle_at(time) - antenna)[:2].tolist()
        return math.atan2(east, north)

    def _in_columns(self, body: int, view: View, antenna: Floats, time: float) -> SurfacePoints:
        """Where lines of sight in columns between the corners of all bodies first meet a body. view: of its own corners."""
        own = self._line_of_sight.own_occluder(body, time)
        if own is None:
            return SurfacePoints(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 3)))
        others = self._line_of_sight.other_occluders(body, antenna, time)
        corners = [np.zeros((0, 3)), *(self._corners(other, time) for other in others)]
        middles, sides = columns(view, self._viewed(np.concatenate(corners), body, antenna, time))
        rows = (self._rows(body, view, antenna, time, *column) for column in ((middles, ROWS), (sides, ROWS[:1])))
        triangle, position = own[0].first_met(own[1], antenna, np.concatenate([*rows]))
        return SurfacePoints(np.full(len(triangle), body), triangle, position)

    def _rows(self, body: int, view: View, antenna: Floats, time: float, azimuth: Floats, rows: Floats) -> Floats:
        """Positions (R, 3) on the map [m] behind rows of a body in columns at azimuths (C,) from its middle [rad]."""
        surface, beyond = self._surface(body), float(view.distance.max()) * 1.01 + 1.0
        north = azimuth + self._azimuth(body, antenna, time)
        if 3 * len(surface.mesh.faces) > 2 * MAX_EDGES:
            ends = ends_at_outline(view, azimuth)
        else:
            ends = ends_at_edges(self._placed(surface.edges, body, time), antenna, self._earth_radius, north)
        return column_points(antenna, self._earth_radius, north, ends, beyond, rows)

    def _occluded(self, point: Floats, antenna: Floats, time: float) -> Flags:
        """Which points (W, 3) on the map any body occludes, their own one too, from the antenna (3,)."""
        resting = self._line_of_sight.occluded_by_resting(point, antenna)
        return resting | self._line_of_sight.occluded_by_moving(point, antenna, time)

    def _visible_by_sea(self, points: SurfacePoints, antenna: Floats, time: float) -> Flags:
        """Which points (W,) a ray by the sea reaches, or by land."""
        land = LandBefore(self._line_of_sight, antenna, points.position - antenna)
        rays = radar_two_rays(self._scene.radar, self._scene.environment, *land.site, land=land)
        reflection = antenna + land.offset * (rays.geometry.reflection / np.maximum(land.site[0], 1e-9))[:, None]
        reflection[:, 2] = rays.level + ABOVE_LAND * (rays.level != 0.0)
        arrives = (rays.geometry.grazing > 0.0) & (rays.ratio != 0.0)
        return np.asarray(arrives & self._line_of_sight.visible_by_sea(points, reflection, antenna, time, np.inf))


def _chosen(points: SurfacePoints, which: Indices) -> SurfacePoints:
    return SurfacePoints(points.body[which], points.triangle[which], points.position[which])
