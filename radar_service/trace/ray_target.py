"""First hits of rays from the antenna on one rigid body, over the curved earth.

A ray is straight in the antenna's coordinates, z = up - d^2 / (2 ae) - antenna height, d from the antenna. A body is curved
about its own origin, with d from there. With b the antenna's offset from that origin, the two are related by

    z' = z + b_up - |b|^2 / (2 ae) - (q . b) / ae,    q: the horizontal part in the antenna's coordinates,

which is linear in the position. Straight rays stay straight, and a unit ray's distance in the body's frame is the slant range.
"""

import numpy as np

from radar_service.numerics import Flags, Floats, Indices
from radar_service.trace.embree import TriangleScene
from radar_service.trace.occluder import curved_vertices
from radar_service.world import BodyPose, Mesh


class RayTarget:
    """A rigid set of triangles for rays, curved about its own origin once."""

    def __init__(self, mesh: Mesh, earth_radius: float) -> None:
        self._triangles = TriangleScene(curved_vertices(mesh, earth_radius), mesh.faces)
        self._earth_radius = earth_radius

    def first_hit(self, pose: BodyPose, antenna: Floats, ray: Floats) -> tuple[Indices, Floats]:
        """First hit of each unit ray (M, 3) from the antenna (3,): triangle (M,), -1 for none, and slant range (M,) [m], inf for
        none, computed in float64."""
        origin, local = self._in_body_frame(pose, antenna, ray)
        triangle = np.full(len(ray), -1, dtype=np.int64)
        near = self._close_to_body(origin, local)
        triangle[near] = self._triangles.first_hit(origin, local[near])
        distance = np.full(len(ray), np.inf)
        hit = np.flatnonzero(triangle >= 0)
        distance[hit] = self._triangles.hit_distance(triangle[hit], origin, local[hit])
        triangle[~(distance > 0.0)] = -1
        distance[triangle < 0] = np.inf
        return triangle, distance

    def front(self, pose: BodyPose, antenna: Floats, ray: Floats, triangle: Indices) -> Flags:
        """Which unit rays (H, 3) meet the side of their triangle (H,) that its winding faces."""
        _, local = self._in_body_frame(pose, antenna, ray)
        a, b, c = (corner.T for corner in self._triangles.corners(triangle))
        return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), local) < 0.0)

    def point(self, pose: BodyPose, antenna: Floats, ray: Floats, distance: Floats) -> Floats:
        """Points (H, 3) [m] of the body's own frame, not curved, that lie `distance` (H,) [m] along unit rays (H, 3)."""
        origin, local = self._in_body_frame(pose, antenna, ray)
        point = origin + local * distance[:, None]
        if pose.lean is not None:
            point = point @ pose.lean.T
        point[:, 2] += (point[:, 0] ** 2 + point[:, 1] ** 2) / (2.0 * self._earth_radius)
        return point if pose.lean is None else point @ pose.lean

    def _in_body_frame(self, pose: BodyPose, antenna: Floats, ray: Floats) -> tuple[Floats, Floats]:
        """Origin (3,) and directions (M, 3) of the antenna's rays in the body's curved frame."""
        offset = antenna - pose.position
        local = ray.copy()
        local[:, 2] -= (ray[:, :2] @ offset[:2]) / self._earth_radius
        return pose.frame_from_map(antenna, self._earth_radius), local @ pose.matrix

    def _close_to_body(self, origin: Floats, ray: Floats) -> Flags:
        """Which rays pass the target's bounding sphere, ahead of the antenna."""
        toward = self._triangles.centre - origin
        radius = self._triangles.radius * 1.001 + 0.01  # float32 rounds the triangles, at most by mm
        along = np.maximum(ray @ toward, 0.0) / np.einsum("ij,ij->i", ray, ray)
        miss = toward - ray * along[:, None]
        near: Flags = np.einsum("ij,ij->i", miss, miss) <= radius**2
        return near


def sea_range(elevation: Floats, antenna_height: float, earth_radius: float) -> Floats:
    """Slant range (M,) [m] at which rays at these elevations [rad] meet the sea, inf where they pass over the horizon.

    The ray stands h + d tan(el) + d^2 / (2 ae) above the sea at ground distance d; the nearer root, written so that it also
    holds for a flat earth (ae = inf).
    """
    fall = -np.tan(elevation)
    squared = fall**2 - 2.0 * antenna_height / earth_radius
    meets = (fall > 0.0) & (squared >= 0.0)
    root = np.sqrt(np.where(meets, squared, 0.0))
    ground = 2.0 * antenna_height / np.where(meets, fall + root, 1.0)
    return np.where(meets, ground / np.cos(elevation), np.inf)
