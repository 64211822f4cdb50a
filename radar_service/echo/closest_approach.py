"""Lower bounds of the distance between two motions at all times, and highest powers of echoes, by which bodies are culled.

A motion's path is its segments on the map; the last segment continues to FAR. Paths are compared as lines, without regard to
time.
"""

import numpy as np

from radar_service.numerics import Floats
from radar_service.propagation import received_amplitude
from radar_service.records import Fidelity
from radar_service.scattering import scattering_model
from radar_service.world import Body, Motion, Scene, SteeredMotion

MAX_MULTIPATH = 16.0  # |F|^4 at most: direct and reflected ray in phase, both ways
FAR = 1e8  # m along the last segment: beyond any range that a radar may have
MAX_PAIRS = 2_000_000  # of segments; paths with more pairs are compared by their bounding boxes


def segments_of(motion: Motion) -> tuple[Floats, Floats, float]:
    """Start and end (L, 2) [m] of the straight segments of a path on the map, and the maximum distance of its arcs from them
    [m]."""
    position = motion.position[:, :2]
    direction = motion.final_velocity[:2] / max(float(np.linalg.norm(motion.final_velocity)), 1e-300)
    last = position[-1] if motion.period is not None else position[-1] + direction * FAR
    bulge = 0.0
    if motion.arcs is not None and len(motion.time) > 1:
        bulge = float((motion.arcs[:-1, 1] * np.diff(motion.time)).max())  # an arc leaves its chord by less than its length
    if motion.arcs is not None and motion.final_turn:
        last, bulge = position[-1], max(bulge, 2.0 * float(motion.arcs[-1, 1]) / abs(motion.final_turn))  # a circle
    return position, np.concatenate([position[1:], last[None]]), bulge


def closest_approach(motion: Motion, other: Motion) -> float:
    """A lower bound of the distance on the map between two motions [m]: 0 where commands may bring one anywhere."""
    if isinstance(motion, SteeredMotion) or isinstance(other, SteeredMotion):
        return 0.0
    (a, b, bulge), (c, d, other_bulge) = segments_of(motion), segments_of(other)
    if len(a) * len(c) > MAX_PAIRS:
        low, high = np.minimum(a, b).min(axis=0), np.maximum(a, b).max(axis=0)
        between = np.maximum(np.minimum(c, d).min(axis=0) - high, low - np.maximum(c, d).max(axis=0))
        gap = float(np.linalg.norm(np.maximum(between, 0.0)))
    else:
        gap = float(_segment_distance(*(x[:, None] for x in (a, b)), *(x[None] for x in (c, d))).min())
    return max(0.0, gap - bulge - other_bulge)


def _segment_distance(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Distances [m] between segments a-b and c-d, broadcast (..., 2); 0 where they cross."""
    ends = np.stack([_point_distance(a, c, d), _point_distance(b, c, d), _point_distance(c, a, b), _point_distance(d, a, b)])
    cross = (_side(a, b, c) * _side(a, b, d) < 0.0) & (_side(c, d, a) * _side(c, d, b) < 0.0)
    return np.where(cross, 0.0, ends.min(axis=0))


def _point_distance(point: Floats, a: Floats, b: Floats) -> Floats:
    """Distance [m] of points from segments a-b, broadcast (..., 2)."""
    along = b - a
    square = np.maximum(np.sum(along * along, axis=-1), 1e-300)
    share = np.clip(np.sum((point - a) * along, axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(point - a - share[..., None] * along, axis=-1))


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Cross product (b - a) x (point - a), broadcast (..., 2); its sign is the side of a-b that a point lies on."""
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (point[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (point[..., 0] - a[..., 0])
    )


def nearest_and_top(body: Body, scene: Scene) -> tuple[float, float]:
    """Minimum ground distance [m] of a body's points from the antenna at any time, and their maximum height [m]."""
    radius, top = 0.0, 0.0
    if body.mesh is not None:
        radius, top = body.arm, body.mesh.top
        if body.motion.sway is not None and body.motion.sway.tilts:
            top += radius * float(np.sin(body.motion.sway.max_tilt))
    lean = 0.0 if scene.own_ship.sway is None else scene.radar.height  # the mast sways about the water line
    gap = closest_approach(scene.own_ship, body.motion) - radius - lean
    return max(0.0, gap), top + max_height(body.motion)


def max_height(motion: Motion) -> float:
    """The maximum height [m] of a motion at any time; inf where it climbs without end."""
    heave = 0.0 if motion.sway is None else motion.sway.max_heave
    return float("inf") if motion.final_velocity[2] > 0.0 else float(motion.position[:, 2].max()) + heave


def max_power(body: Body, scene: Scene, fidelity: Fidelity) -> float:
    """A power [W] that the echoes of a body hardly ever exceed in any cell, at its closest approach."""
    nearest, _ = nearest_and_top(body, scene)
    level = float(received_amplitude(scene.radar, np.array([nearest]))[0] ** 2)
    multipath = MAX_MULTIPATH if scene.environment.multipath else 1.0
    return level * scattering_model(body).max_rcs(body, scene.radar, fidelity) * multipath
