"""Ray tests by Embree, or by `trace.box_tree` where embreex is not installed. This is the only module that imports embreex.

Trees work in float32, so triangles are stored about their own centre. A tree decides only which triangle a ray meets first,
or whether a path is blocked; `hit_distance` computes the distance in float64. This file works around defects of embreex: a mesh
added after the first ray is ignored, the array `dists` is overwritten, float64 input raises, and tnear is always 0
(docs/decisions/0003-two-tracers.md).
"""

import warnings
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from radar_service.numerics import Flags, Floats, Indices, Singles
from radar_service.trace.box_tree import BoxTree
from radar_service.trace.tree_cache import SharedTree, Tree, TreeCache, Triangles
from radar_service.world import used_rows

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore import EmbreeDevice
    from embreex.rtcore_scene import EmbreeScene
except ImportError:  # no wheel for this platform: pyproject.toml names those that have one
    EmbreeScene = None

MAX_TREES = 32_768  # a scene may have 10,000 bodies; 70,000 trees of boxes took 5 KB each and worked (tests/measurements)
MAX_PLANES = 2**20  # triangles of a mesh whose planes are kept; of larger ones they are computed for those that rays meet
LAZY_FACES = 1024  # larger meshes take more than some ms, so their trees are built with the scene and not under the beam


class RayCount:
    """Counts rays for a plan. It is passed in; several threads may lose some."""

    def __init__(self) -> None:
        self.rays = 0


class EmbreeTree(Tree):
    """A tree of one mesh by Embree."""

    def __init__(self, vertices: Singles, faces: NDArray[np.int32]) -> None:
        self._scene = EmbreeScene(_device(), robust=True)  # non-robust leaks 9 % of rays at shared edges
        TriangleMesh(self._scene, vertices, faces)
        self._scene.run(
            np.zeros((1, 3), dtype=np.float32), np.ones((1, 3), dtype=np.float32)
        )  # two threads must not commit it

    @override
    def first_hit(self, origins: Singles, directions: Singles) -> Indices:
        return np.asarray(self._scene.run(origins, directions), dtype=np.int64)

    @override
    def occluded(self, origins: Singles, directions: Singles, reach: Singles) -> Flags:
        hits = self._scene.run(origins, directions, dists=reach.copy(), query="OCCLUDED")
        return np.asarray(np.asarray(hits) >= 0)


@cache
def _device() -> Any:
    """One device for all trees of a process: each device takes thread keys, of which a process has 1024."""
    return EmbreeDevice()


def build_tree(vertices: Singles, faces: NDArray[np.int32]) -> Tree:
    """A tree by the fastest tracer of this platform."""
    if EmbreeScene is not None:
        return EmbreeTree(vertices, faces)
    _warn_of_slow_rays()
    return BoxTree(vertices, faces)


@cache
def _warn_of_slow_rays() -> None:
    text = "embreex is not installed (it has no wheel for Linux on ARM): rays are traced by a slower tracer"
    warnings.warn(text, RuntimeWarning, stacklevel=2)


TREES = TreeCache(build_tree, MAX_TREES)


class TriangleScene:
    """Triangles for ray tests: vertices (V, 3) [m] and faces (F, 3) in any one frame. Equal ones share a tree. Pickling leaves
    the tree out."""

    def __init__(self, vertices: Floats, faces: Indices, rays: RayCount | None = None) -> None:
        """rays: counts the rays cast, where given."""
        used = used_rows(vertices, faces)
        self.centre: Floats = (used.min(axis=0) + used.max(axis=0)) / 2.0
        self.radius = float(np.linalg.norm(used - self.centre, axis=1).max())
        self.vertices: Floats = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces: Indices = np.ascontiguousarray(faces, dtype=np.int64)
        self._count = rays or RayCount()
        self._build_large()

    def _build_large(self) -> None:
        self._shared: SharedTree | None = None
        if len(self.faces) > LAZY_FACES:
            self._tree()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_shared", "planes")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._build_large()

    def first_hit(self, origin: Floats, direction: Floats) -> Indices:
        """Index of the first triangle that each ray meets, -1 where none. origin (3,) or (M, 3), direction (M, 3)."""
        return self.first_hit_of(*self._as_float32(origin, direction))

    def first_hit_of(self, begin: Singles, direction: Singles) -> Indices:
        """Index (M,) of the first triangle that each ray (M, 3) meets, -1 where none; begins are relative to `centre`."""
        if len(direction) == 0:
            return np.zeros(0, dtype=np.int64)
        self._count.rays += len(direction)
        return self._tree().first_hit(begin, direction)

    def occluded(self, origin: Floats, direction: Floats, reach: Floats | float) -> Flags:
        """Whether each ray meets a triangle within `reach` (M,), in lengths of `direction`."""
        if len(direction) == 0:
            return np.zeros(0, dtype=np.bool_)
        self._count.rays += len(direction)
        within = np.broadcast_to(np.asarray(reach, dtype=np.float32), (len(direction),))
        return self._tree().occluded(*self._as_float32(origin, direction), within)

    def hit_distance(self, triangle: Indices, origin: Floats, direction: Floats) -> Floats:
        """Where each ray meets the plane of its triangle, in lengths of `direction`, in float64. Shapes (M,), as above."""
        if len(self.faces) > MAX_PLANES:
            normal, offset = self._planes_of(self.faces.take(triangle, axis=0))
        else:
            normal, offset = self.planes[0].take(triangle, axis=0), self.planes[1].take(triangle)
        along = np.einsum("ij,ij->i", normal, np.broadcast_to(direction, normal.shape))
        toward = offset - np.einsum("ij,ij->i", normal, np.broadcast_to(origin, normal.shape))
        distance: Floats = np.divide(toward, along, out=np.full(len(along), np.inf), where=along != 0)
        return distance

    def corners(self, triangle: Indices) -> Floats:
        """Corners (3, 3, M), by corner and axis, of triangles (M,) [m]."""
        return np.stack([self.vertices.take(self.faces[:, i].take(triangle), axis=0).T for i in range(3)])

    @cached_property
    def planes(self) -> tuple[Floats, Floats]:
        """Normals (F, 3), twice as long as the area, and what all points of the planes have for them (F,); 32 bytes a
        triangle, a fraction of what Embree's tree takes."""
        return self._planes_of(self.faces)

    def _planes_of(self, faces: Indices) -> tuple[Floats, Floats]:
        """`planes` of some faces (F, 3)."""
        a, b, c = (self.vertices.take(faces[:, i], axis=0) for i in range(3))
        (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
        normal = np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1)  # half the time of np.cross
        return normal, np.einsum("ij,ij->i", normal, a)

    def _tree(self) -> Tree:
        if self._shared is None:
            self._shared = TREES.share(self._triangles())
        return TREES.tree(self._shared, self._triangles)

    def _triangles(self) -> Triangles:
        return (self.vertices - self.centre).astype(np.float32), self.faces.astype(np.int32)

    def _as_float32(self, origin: Floats, direction: Floats) -> tuple[Singles, Singles]:
        origins = np.broadcast_to(origin - self.centre, direction.shape)
        return np.ascontiguousarray(origins, dtype=np.float32), np.ascontiguousarray(direction, dtype=np.float32)
