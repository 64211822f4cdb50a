"""Ray tests by Embree. This is the only module that imports embreex.

Embree works in float32, so triangles are stored about their own centre. Embree decides only which triangle a ray meets first,
or whether a path is blocked; `hit_distance` computes the distance in float64. This file works around defects of embreex: a mesh
added after the first ray is ignored, the array `dists` is overwritten, float64 input raises, tnear is always 0.
"""

from functools import cached_property
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class RayCount:
    """Counts rays for a plan. It is passed in; several threads may lose some."""

    def __init__(self) -> None:
        self.rays = 0


class TriangleScene:
    """Triangles for ray tests: vertices (V, 3) [m] and faces (F, 3) in any one frame. Pickling leaves `tree` (Embree's) out,
    and unpickling builds it again."""

    def __init__(self, vertices: Floats, faces: NDArray[np.int64], rays: RayCount | None = None) -> None:
        """rays: counts the rays cast, where given."""
        used = vertices[np.unique(faces)]
        self.centre: Floats = (used.min(axis=0) + used.max(axis=0)) / 2.0
        self.radius = float(np.linalg.norm(used - self.centre, axis=1).max())
        self._vertices, self._faces, self._count = vertices, faces, rays or RayCount()
        self._build()

    def _build(self) -> None:
        """Hands the triangles to Embree, which builds its tree at the first ray."""
        self.tree = EmbreeScene(robust=True)  # non-robust leaks 9 % of rays at shared edges
        TriangleMesh(self.tree, (self._vertices - self.centre).astype(np.float32), self._faces.astype(np.int32))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("tree", "_planes")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._build()

    def first_hit(self, origin: Floats, direction: Floats) -> NDArray[np.int64]:
        """Index of the first triangle that each ray meets, -1 where none. origin (3,) or (M, 3), direction (M, 3)."""
        if len(direction) == 0:
            return np.zeros(0, dtype=np.int64)
        origins, directions = self._as_float32(origin, direction)
        return np.asarray(self.tree.run(origins, directions), dtype=np.int64)

    def occluded(self, origin: Floats, direction: Floats, reach: Floats | float) -> NDArray[np.bool_]:
        """Whether each ray meets a triangle within `reach` (M,), in lengths of `direction`."""
        if len(direction) == 0:
            return np.zeros(0, dtype=np.bool_)
        origins, directions = self._as_float32(origin, direction)
        dists = np.array(np.broadcast_to(reach, (len(directions),)), dtype=np.float32)
        hits = self.tree.run(origins, directions, dists=dists, query="OCCLUDED")
        return np.asarray(np.asarray(hits) >= 0)

    def hit_distance(self, triangle: NDArray[np.int64], origin: Floats, direction: Floats) -> Floats:
        """Where each ray meets the plane of its triangle, in lengths of `direction`, in float64. Shapes (M,), as above."""
        normal, offset = self._planes[0].take(triangle, axis=0), self._planes[1].take(triangle)
        along = np.einsum("ij,ij->i", normal, np.broadcast_to(direction, normal.shape))
        toward = offset - np.einsum("ij,ij->i", normal, np.broadcast_to(origin, normal.shape))
        distance: Floats = np.divide(toward, along, out=np.full(len(along), np.inf), where=along != 0)
        return distance

    @cached_property
    def _planes(self) -> tuple[Floats, Floats]:
        """Normals (F, 3), twice as long as the area, and what all points of the planes have for them (F,); 32 bytes a
        triangle, a fraction of what Embree's tree takes."""
        a, b, c = (self._vertices.take(self._faces[:, i], axis=0) for i in range(3))
        (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
        normal = np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1)  # half the time of np.cross
        return normal, np.einsum("ij,ij->i", normal, a)

    def _as_float32(self, origin: Floats, direction: Floats) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        self._count.rays += len(direction)
        origins = np.broadcast_to(origin - self.centre, direction.shape)
        return np.ascontiguousarray(origins, dtype=np.float32), np.ascontiguousarray(direction, dtype=np.float32)
