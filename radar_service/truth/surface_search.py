"""The search for a visible part of a body whose outermost points are all hidden."""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.propagation.legs import reflection_points
from radar_service.scattering.models import scattering_model
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.truth.surface_points import (
    MAX_EDGES,
    ROWS,
    Surface,
    View,
    column_points,
    columns,
    ends_at_edges,
    ends_at_outline,
    outermost,
    outline,
    viewed,
)
from radar_service.world.poses import pose_at
from radar_service.world.scene import Scene

Candidates = tuple[
    Floats, Callable[[Indices], Flags]
]  # points (W, 3) on the map [m], and which of them, by index, are visible
MAX_SURFACES = 512  # whose points are kept: 200 KB each at most


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
        own = self._line_of_sight.own_occluder(body, antenna, time)
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
        """Which points (W,) a ray by the sea reaches."""
        reflection, arrives = reflection_points(points.position, antenna, self._earth_radius)
        return arrives & self._line_of_sight.visible_by_sea(points, reflection, antenna, time, np.inf)


def _chosen(points: SurfacePoints, which: Indices) -> SurfacePoints:
    return SurfacePoints(points.body[which], points.triangle[which], points.position[which])
