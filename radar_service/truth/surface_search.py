"""Points of a body's surface by which the truth decides whether any part of it is visible, by the engine's lines of sight.

A body in plain sight is told by its outermost vertices. What others hide in part is asked in its faces.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.propagation.land_reflection import ABOVE_LAND, LandBefore
from radar_service.propagation.radar_equation import radar_two_rays
from radar_service.scattering.models import scattering_model
from radar_service.scattering.surface_sampling import R2, normals_and_areas, points_in_triangles
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.world.body import Mesh
from radar_service.world.poses import pose_at
from radar_service.world.scene import Scene

OUTWARD = np.array(
    [[0, 0, 8], [1, 1, 2], [1, -1, 2], [-1, 1, 2], [-1, -1, 2], [1, 0, 0.1], [-1, 0, 0.1], [0, 1, 0.1], [0, -1, 0.1]]
)  # top, upper corners, sides
VERTICES = 2**18  # at a time
FACE_POINTS = 4096  # of a body, spread evenly over the area of its faces: 15 mm apart on a wall of 60 m, seen from its foot
FIRST = 8  # of so many points one is asked first, which tells most bodies
MAX_SURFACES = 512  # whose points are kept: 130 KB each
Candidates = tuple[
    Floats, Callable[[Indices], Flags]
]  # points (W, 3) on the map [m], and which of them, by index, are visible


def outermost(mesh: Mesh) -> Floats:
    """The vertices (K, 3) that lie farthest out in the directions of OUTWARD, in the body's own frame [m]."""
    vertices, farthest, index = mesh.used_vertices, np.full(len(OUTWARD), -np.inf), np.zeros(len(OUTWARD), dtype=np.int64)
    for start in range(0, len(vertices), VERTICES):
        reach = vertices[start : start + VERTICES] @ OUTWARD.T
        first, most = reach.argmax(axis=0), reach.max(axis=0)
        index, farthest = np.where(most > farthest, start + first, index), np.maximum(most, farthest)
    return np.asarray(vertices[np.unique(index)])


def face_points(mesh: Mesh) -> tuple[Indices, Floats]:
    """FACE_POINTS points in faces, evenly over their area: the triangle of each, and positions (N, 3) in the body's frame [m]."""
    cumulated, number = np.cumsum(normals_and_areas(mesh)[1]), np.arange(FACE_POINTS)
    steps = (number + 0.5) * (cumulated[-1] / FACE_POINTS)
    return points_in_triangles(mesh, cumulated, steps, np.outer(R2, number + 1) % 1.0)


class SurfaceSearch:
    """Points of the bodies of a scene, in the order in which the truth tests them. Safe to call from several threads.

    outermost: points (K, 3) of each body in its own frame [m]; the origin of a body without a mesh.
    """

    def __init__(self, scene: Scene, line_of_sight: OcclusionScene) -> None:
        self._scene, self._line_of_sight = scene, line_of_sight
        self._faces: ResultCache[int, tuple[Indices, Floats]] = ResultCache(MAX_SURFACES)
        self.outermost = [np.zeros((1, 3)) if body.mesh is None else outermost(body.mesh) for body in scene.bodies]

    def candidates(self, body: int, antenna: Floats, time: float, reach: float) -> Iterator[Candidates]:
        """Points of a body with a mesh for the antenna (3,) at `time` [s]; reach: height up to which fields reach beyond
        the horizon [m]."""
        faces = self._points(body, time)
        seen = partial(self._line_of_sight.visible, antenna=antenna, time=time, max_range=np.inf, over_horizon=reach)
        for points in (_chosen(faces, np.arange(0, FACE_POINTS, FIRST)), faces):
            yield points.position, lambda lit, points=points: seen(_chosen(points, lit))  # type: ignore[misc]
        if scattering_model(self._scene.bodies[body]).lit_by_sea and self._scene.environment.multipath:
            yield faces.position, lambda lit: self._visible_by_sea(_chosen(faces, lit), antenna, time)

    def _points(self, body: int, time: float) -> SurfacePoints:
        scene_body = self._scene.bodies[body]
        assert scene_body.mesh is not None
        mesh = scene_body.mesh
        triangle, position = self._faces.get(body, lambda: face_points(mesh))
        return SurfacePoints(np.full(len(triangle), body), triangle, pose_at(scene_body, time).map_from_frame(position))

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
