"""Where rays from the antenna first meet triangles, over the curved earth and with bodies that move.

A ray is straight in the antenna's coordinates, z = up - d^2 / (2 ae) - antenna height, d from the antenna. A body is bent
about its own origin, d counted from there. With b the antenna's offset from that origin, the one follows from the other by

    z' = z + b_up - |b|^2 / (2 ae) - (q . b) / ae,    q: the horizontal part in the antenna's coordinates,

which is linear in the place: straight rays stay straight, a ray's direction loses (q . b) / ae of its rise, and what is one
length along it stays one length. So a unit ray's distance in the body's frame is the slant range.
"""

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import body_rotation
from radar_service.scene.body import Mesh
from radar_service.scene.poses import BodyPose
from radar_service.trace.embree import TriangleScene
from radar_service.trace.occluder import curved_vertices

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class RayTarget:
    """A rigid set of triangles that rays are thrown at, bent about its own origin once."""

    def __init__(self, mesh: Mesh, earth_radius: float) -> None:
        self._triangles = TriangleScene(curved_vertices(mesh, earth_radius), mesh.faces)
        self._earth_radius = earth_radius

    def first_hit(self, pose: BodyPose, antenna: Floats, ray: Floats) -> tuple[Indices, Floats]:
        """Triangle (M,), -1 where none, and slant range (M,) [m], inf where none, at which each unit ray (M, 3) of the
        antenna (3,) first meets this target; the range is decided in float64."""
        origin, local = self._carried(pose, antenna, ray)
        triangle = np.full(len(ray), -1, dtype=np.int64)
        near = self._near(origin, local)
        triangle[near] = self._triangles.first_hit(origin, local[near])
        distance = np.full(len(ray), np.inf)
        hit = np.flatnonzero(triangle >= 0)
        distance[hit] = self._triangles.hit_distance(triangle[hit], origin, local[hit])
        triangle[~(distance > 0.0)] = -1
        distance[triangle < 0] = np.inf
        return triangle, distance

    def point(self, pose: BodyPose, antenna: Floats, ray: Floats, distance: Floats) -> Floats:
        """Points (H, 3) [m] of the body's own frame, unbent, that lie `distance` (H,) [m] along unit rays (H, 3)."""
        origin, local = self._carried(pose, antenna, ray)
        point = origin + local * distance[:, None]
        point[:, 2] += (point[:, 0] ** 2 + point[:, 1] ** 2) / (2.0 * self._earth_radius)
        return point

    def _carried(self, pose: BodyPose, antenna: Floats, ray: Floats) -> tuple[Floats, Floats]:
        """Origin (3,) and directions (M, 3) of the antenna's rays in the body's bent frame."""
        offset = antenna - pose.position
        local = ray.copy()
        local[:, 2] -= (ray[:, :2] @ offset[:2]) / self._earth_radius
        return pose.frame_from_map(antenna, self._earth_radius), local @ body_rotation(pose.heading)

    def _near(self, origin: Floats, ray: Floats) -> NDArray[np.bool_]:
        """Which rays pass the target's bounding sphere, ahead of the antenna."""
        toward = self._triangles.centre - origin
        radius = self._triangles.radius * 1.001 + 0.01  # float32 rounds the triangles, at most by mm
        along = np.maximum(ray @ toward, 0.0) / np.einsum("ij,ij->i", ray, ray)
        miss = toward - ray * along[:, None]
        near: NDArray[np.bool_] = np.einsum("ij,ij->i", miss, miss) <= radius**2
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
