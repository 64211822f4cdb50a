"""What the antenna can see: sight lines over the curved earth, through bodies that move, with nothing ever rebuilt.

Seen from the antenna the earth curves away as z = up - d^2 / (2 ae). Bending a body about its own origin instead differs
only by a shear, which keeps straight lines straight: a sight line that is straight about the antenna is straight about
the body too. So every body is bent once, about itself, and sight lines are carried into its frame.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import body_rotation, map_from_body
from radar_service.radar.parameters import horizon
from radar_service.scene.world import Mesh
from radar_service.trace.embree import TriangleScene

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
NEARLY = 2e-3  # m; float32 places a hit on a body of a few km to about 1 mm (Embree's own rounding)
NEARLY_RELATIVE = 2e-6  # of the sight line's length: float32 rounding of its direction


@dataclass(frozen=True)
class BodyPose:
    """Where a body stands at one instant: position (3,) [m] and heading [rad]."""

    position: Floats
    heading: float

    def frame_from_map(self, places: Floats, earth_radius: float) -> Floats:
        """Places (..., 3) of the map in this body's bent frame."""
        local = places - self.position
        if self.heading != 0.0:
            local = local @ body_rotation(self.heading)
        if np.isfinite(earth_radius):
            local[..., 2] -= (local[..., 0] ** 2 + local[..., 1] ** 2) / (2.0 * earth_radius)
        return local


class Occluder:
    """A rigid set of triangles that can hide things, in its own bent frame."""

    def __init__(self, mesh: Mesh, earth_radius: float) -> None:
        bent = mesh.vertices.copy()
        bent[:, 2] -= (bent[:, 0] ** 2 + bent[:, 1] ** 2) / (2.0 * earth_radius)
        self._scene = TriangleScene(bent, mesh.faces)
        self._earth_radius = earth_radius
        self._scene.first_hit(np.zeros(3), np.array([[0.0, 0.0, 1.0]]))  # builds the tree now, not under the first beam

    @property
    def rays(self) -> int:
        """Rays cast so far."""
        return self._scene.rays

    def cone(self, stand: BodyPose, antenna: Floats) -> tuple[float, float, float]:
        """What the body may hide: azimuth of its middle [rad], half width [rad], ground distance where it begins [m]."""
        centre = map_from_body(self._scene.centre, stand.position, stand.heading)
        east, north = centre[:2] - antenna[:2]
        distance, radius = float(np.hypot(east, north)), self._scene.radius * 1.01 + 1.0  # 1 m: the bend and rounding
        half = float(np.arcsin(radius / distance)) if distance > radius else np.pi
        return float(np.arctan2(east, north)), half, max(0.0, distance - radius)

    def may_occlude(self, stand: BodyPose, antenna: Floats, places: Floats) -> bool:
        """Whether this body could hide any of `places` (E, 3) of others from `antenna` (3,), on the map [m]; a quick look from
        above: each sight line stays within `spread` of the one to the middle of them all."""
        if not len(places):
            return False
        east, north = places[:, 0], places[:, 1]  # each by itself: six times as fast as along an axis
        low, high = np.array([east.min(), north.min()]), np.array([east.max(), north.max()])
        spread = float(np.hypot(*(high - low))) / 2.0
        line = (low + high) / 2.0 - antenna[:2]
        toward = map_from_body(self._scene.centre, stand.position, stand.heading)[:2] - antenna[:2]
        along = np.clip(toward @ line / max(float(line @ line), 1e-12), 0.0, 1.0)
        return float(np.hypot(*(toward - along * line))) <= spread + self._scene.radius * 1.001 + NEARLY

    def hides(self, stand: BodyPose, antenna: Floats, places: Floats) -> Flags:
        """Which of `places` (E, 3) of other bodies this one hides from `antenna` (3,), both on the map [m]."""
        origin, sight = self._sight_lines(stand, antenna, places)
        near = self._near(origin, sight)
        hidden = np.zeros(len(sight), dtype=np.bool_)
        reach = 1.0 - _slack(sight[near])
        hidden[near] = self._scene.hidden(origin, sight[near], np.maximum(reach, 0.0))
        return hidden

    def self_occluded(self, stand: BodyPose, antenna: Floats, places: Floats, own: tuple[Indices, Indices]) -> Flags:
        """Which points (E, 3) of this body other parts of it hide from `antenna`; triangles own[0] to own[1] (E,),
        exclusive, never hide the point: the one it lies on, or all of a body that counts as a point."""
        origin, sight = self._sight_lines(stand, antenna, places)
        hit = self._scene.first_hit(origin, sight)
        hidden = (hit >= 0) & ((hit < own[0]) | (hit >= own[1]))
        suspects = np.flatnonzero(hidden)
        distance = self._scene.hit_distance(hit[suspects], origin, sight[suspects])
        hidden[suspects] = distance < 1.0 - _slack(sight[suspects])
        return hidden

    def _sight_lines(self, stand: BodyPose, antenna: Floats, places: Floats) -> tuple[Floats, Floats]:
        origin = stand.frame_from_map(antenna, self._earth_radius)
        return origin, stand.frame_from_map(places, self._earth_radius) - origin

    def _near(self, origin: Floats, sight: Floats) -> Flags:
        """Which sight lines pass within the body's bounding sphere before they end."""
        toward = self._scene.centre - origin
        length2 = np.einsum("ij,ij->i", sight, sight)
        along = np.clip(sight @ toward / np.maximum(length2, 1e-12), 0.0, 1.0)
        miss = toward - sight * along[:, None]
        near: Flags = np.einsum("ij,ij->i", miss, miss) <= (self._scene.radius * 1.001 + NEARLY) ** 2
        return near


def beyond_horizon(distance: Floats, height: Floats, antenna_height: float, earth_radius: float) -> Flags:
    """Whether the sea stands between, past the `horizon`. What lies under the sea is hidden too.

    distance: along the earth (E,) [m]; height above the sea (E,) [m]. With earth_radius inf nothing above 0 is hidden.
    """
    return np.asarray((height < 0) | (distance > horizon(height, antenna_height, earth_radius)))


def _slack(sight: Floats) -> Floats:
    length = np.sqrt(np.einsum("ij,ij->i", sight, sight))  # a third of the time of linalg.norm
    return np.asarray(NEARLY / np.maximum(length, NEARLY) + NEARLY_RELATIVE)
