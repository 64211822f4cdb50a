"""Occlusion by one rigid body over the curved earth. Nothing is rebuilt when the body or the antenna moves.

Relative to the antenna the earth curves away as z = up - d^2 / (2 ae). Curving a body about its own origin instead differs
only by a shear, which keeps straight lines straight. So each body is curved once, about its own origin, and lines of sight are
transformed into its frame. A ray that the sea reflects is two such lines.
"""

import numpy as np

from radar_service.numerics import Flags, Floats, Indices
from radar_service.radar import horizon
from radar_service.trace.embree import RayCount, TriangleScene
from radar_service.world import BodyPose, Mesh

TOLERANCE = 2e-3  # m; float32 places a hit on a body of a few km to about 1 mm (Embree's own rounding)
RELATIVE_TOLERANCE = 2e-6  # of the line of sight's length: float32 rounding of its direction


class Occluder:
    """A rigid set of triangles that occludes others, in its own curved frame."""

    def __init__(self, mesh: Mesh, earth_radius: float, rays: RayCount | None = None) -> None:
        """rays: counts the rays cast, where given."""
        self.scene = TriangleScene(curved_vertices(mesh, earth_radius), mesh.faces, rays)  # in its own frame
        self._earth_radius = earth_radius
        self.top = mesh.top  # in its own frame [m]
        self.scene.first_hit(np.zeros(3), np.array([[0.0, 0.0, 1.0]]))  # builds the tree now, not under the first beam

    @property
    def sphere(self) -> tuple[Floats, float]:
        """Middle (3,) and radius [m] of the curved body's bounding sphere, in its own frame."""
        return self.scene.centre, self.scene.radius

    def may_occlude(self, pose: BodyPose, antenna: Floats, points: Floats) -> bool:
        """Whether this body may occlude any of `points` (E, 3) of others from `antenna` (3,), on the map [m].

        A quick test in plan: each line of sight stays within `width` of the one to the middle of all points.
        """
        if not len(points):
            return False
        east, north = points[:, 0], points[:, 1]  # each by itself: six times as fast as along an axis
        low, high = np.array([east.min(), north.min()]), np.array([east.max(), north.max()])
        width = float(np.hypot(*(high - low))) / 2.0
        line = (low + high) / 2.0 - antenna[:2]
        toward = pose.map_from_frame(self.scene.centre)[:2] - antenna[:2]
        along = np.clip(toward @ line / max(float(line @ line), 1e-12), 0.0, 1.0)
        return float(np.hypot(*(toward - along * line))) <= width + self.scene.radius * 1.001 + TOLERANCE

    def occludes(self, pose: BodyPose, origin: Floats, points: Floats) -> Flags:
        """Which of `points` (E, 3) of other bodies this one occludes from `origin` (3,) or (E, 3), all on the map [m]."""
        origin, line = self._lines_of_sight(pose, origin, points)
        near = slice(None) if self._holds(origin) else np.flatnonzero(self._close_to_body(origin, line))
        occluded = np.zeros(len(line), dtype=np.bool_)
        begin, skipped = self._begun_nearby(origin if origin.ndim == 1 else origin[near], line[near])
        occluded[near] = self.scene.occluded(begin, line[near], reach_of(line[near], skipped))
        return occluded

    def self_occluded(self, pose: BodyPose, origin: Floats, points: Floats, own: tuple[Indices, Indices]) -> Flags:
        """Which points (E, 3) of this body are occluded from `origin` (3,) or (E, 3) by other parts of it, on the map [m].

        own: first and last (exclusive) triangle (E,) that never occlude each point: the one it lies on, or all of a body
        that counts as a point.
        """
        origin, line = self._lines_of_sight(pose, origin, points)
        return hit_before(self.scene, origin, self._begun_nearby(origin, line)[0], line, own)

    def _lines_of_sight(self, pose: BodyPose, origin: Floats, points: Floats) -> tuple[Floats, Floats]:
        begin = pose.frame_from_map(origin, self._earth_radius)
        return begin, pose.frame_from_map(points, self._earth_radius) - begin

    def _begun_nearby(self, origin: Floats, line: Floats) -> tuple[Floats, Floats]:
        """`begun_nearby` of lines of sight from an origin (3,), or from one each."""
        if self._holds(origin):  # the same bytes
            return origin, np.zeros(len(line))
        return begun_nearby(origin, line, self.scene.centre - origin, self.scene.radius)

    def _holds(self, origin: Floats) -> bool:
        """Whether all lines of sight begin within the body's bounding sphere, from an origin (3,)."""
        return origin.ndim == 1 and bool(np.linalg.norm(self.scene.centre - origin) <= self.scene.radius)

    def _close_to_body(self, origin: Floats, line: Floats) -> Flags:
        """`passes_by` of lines of sight from an origin (3,), or from one each."""
        return passes_by(line, self.scene.centre - origin, self.scene.radius)


def begun_nearby(origin: Floats, line: Floats, toward: Floats, radius: Floats | float) -> tuple[Floats, Floats]:
    """Lines of sight from where they reach a body's bounding sphere: begins (E, 3), and the share (E,) left out.

    toward: (3,) or (E, 3) from the origins to middles of spheres of `radius` [m]. Embree rounds in float32, less from here.
    """
    length2 = np.maximum(np.einsum("ij,ij->i", line, line), 1e-12)
    reach = sphere_reach(radius) / np.sqrt(length2)
    skipped = np.clip(_progress(line, toward) / length2 - reach, 0.0, 1.0)
    return origin + line * skipped[:, None], skipped


def passes_by(line: Floats, toward: Floats, radius: Floats | float) -> Flags:
    """Which lines of sight (E, 3) pass within a body's bounding sphere before they end.

    toward: (3,) or (E, 3) from the origins to middles of spheres of `radius` [m].
    """
    length2 = np.einsum("ij,ij->i", line, line)
    along = np.clip(_progress(line, toward) / np.maximum(length2, 1e-12), 0.0, 1.0)
    miss = toward - line * along[:, None]
    near: Flags = np.einsum("ij,ij->i", miss, miss) <= sphere_reach(radius) ** 2
    return near


def sphere_reach(radius: Floats | float) -> Floats | float:
    """How far off the middle of a body's bounding sphere lines of sight may meet the body [m]."""
    return radius * 1.001 + TOLERANCE


def _progress(line: Floats, toward: Floats) -> Floats:
    """Products (E,) of lines (E, 3) and a vector (3,), or one each (E, 3)."""
    return np.asarray(line @ toward if toward.ndim == 1 else np.einsum("ij,ij->i", line, toward))


def reach_of(line: Floats, skipped: Floats) -> Floats:
    """How far (E,) lines of sight (E, 3) that begin after a share (E,) are traced, in their lengths."""
    return np.maximum(1.0 - _slack(line) - skipped, 0.0)


def hit_before(scene: TriangleScene, origin: Floats, begin: Floats, line: Floats, own: tuple[Indices, Indices]) -> Flags:
    """Which lines of sight (E, 3) meet a triangle of their own body before they end.

    origin: (3,) or (E, 3); begin: (E, 3) where rays begin instead; own: first and last (exclusive) triangle (E,) left out.
    """
    hit = scene.first_hit(begin, line)
    occluded = (hit >= 0) & ((hit < own[0]) | (hit >= own[1]))
    candidates = np.flatnonzero(occluded)
    begin = origin if origin.ndim == 1 else origin[candidates]
    distance = scene.hit_distance(hit[candidates], begin, line[candidates])
    occluded[candidates] = distance < 1.0 - _slack(line[candidates])
    return np.asarray(occluded)


def curved_vertices(mesh: Mesh, earth_radius: float) -> Floats:
    """The vertices (V, 3) of a mesh, curved down about its origin: z - (x^2 + y^2) / (2 ae) [m]."""
    curved = mesh.vertices.copy()
    curved[:, 2] -= (curved[:, 0] ** 2 + curved[:, 1] ** 2) / (2.0 * earth_radius)
    return curved


def beyond_horizon(
    distance: Floats,
    height: Floats,
    antenna_height: Floats | float,
    earth_radius: float,
    over_horizon: Floats | float = 0.0,
) -> Flags:
    """Whether the sea occludes: beyond the `horizon`, and below the surface.

    distance: along the earth (E,) [m]; height above the sea (E,) [m]; antenna_height: one, or one each (E,) [m]. With
    earth_radius inf nothing above 0 is occluded. over_horizon: height [m] of antenna and point up to which a field
    reaches beyond the horizon, one, or one each (E,); 0: none.
    """
    blocked = np.maximum(height, antenna_height) >= over_horizon
    return np.asarray((height < 0) | (blocked & (distance > horizon(height, antenna_height, earth_radius))))


def _slack(line: Floats) -> Floats:
    length = np.sqrt(np.einsum("ij,ij->i", line, line))  # a third of the time of linalg.norm
    return np.asarray(TOLERANCE / np.maximum(length, TOLERANCE) + RELATIVE_TOLERANCE)
