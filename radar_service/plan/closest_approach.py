"""How near two motions ever come, whatever the time: bounds that hold for good, so that what never matters can be left out.

A motion's path is its legs on the map; the last one goes on to FAR. Paths are compared as lines, whenever each is where.
"""

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.body import Body
from radar_service.scene.motion import Motion
from radar_service.scene.world import Scene

Floats = NDArray[np.float64]
FAR = 1e8  # m along the last leg: beyond any range that a radar may have
MOST_PAIRS = 2_000_000  # of legs; paths of more are compared by the boxes about them


def legs_of(motion: Motion) -> tuple[Floats, Floats, float]:
    """Begin and end (L, 2) [m] of the straight legs of a path on the map, and how far its arcs may leave them [m]."""
    place = motion.position[:, :2]
    onward = place[-1] + motion.final_velocity[:2] / max(float(np.linalg.norm(motion.final_velocity)), 1e-300) * FAR
    last = place[-1] if motion.period is not None else onward
    bulge = 0.0
    if motion.arcs is not None and len(motion.time) > 1:
        bulge = float((motion.arcs[:-1, 1] * np.diff(motion.time)).max())  # no arc strays further than it is long
    return place, np.concatenate([place[1:], last[None]]), bulge


def closest_approach(one: Motion, other: Motion) -> float:
    """A distance on the map [m] below which the two never come."""
    (a, b, bulge), (c, d, more) = legs_of(one), legs_of(other)
    if len(a) * len(c) > MOST_PAIRS:
        low, high = np.minimum(a, b).min(axis=0), np.maximum(a, b).max(axis=0)
        apart = np.maximum(np.minimum(c, d).min(axis=0) - high, low - np.maximum(c, d).max(axis=0))
        gap = float(np.linalg.norm(np.maximum(apart, 0.0)))
    else:
        gap = float(_apart(*(x[:, None] for x in (a, b)), *(x[None] for x in (c, d))).min())
    return max(0.0, gap - bulge - more)


def _apart(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Distances [m] between segments a-b and c-d, broadcast (..., 2); 0 where they cross."""
    ends = np.stack([_off(a, c, d), _off(b, c, d), _off(c, a, b), _off(d, a, b)])
    cross = (_side(a, b, c) * _side(a, b, d) < 0.0) & (_side(c, d, a) * _side(c, d, b) < 0.0)
    return np.where(cross, 0.0, ends.min(axis=0))


def _off(point: Floats, a: Floats, b: Floats) -> Floats:
    """Distance [m] of points from segments a-b, broadcast (..., 2)."""
    along = b - a
    square = np.maximum(np.sum(along * along, axis=-1), 1e-300)
    share = np.clip(np.sum((point - a) * along, axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(point - a - share[..., None] * along, axis=-1))


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """On which side of a-b points are, broadcast (..., 2): the sign."""
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (point[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (point[..., 0] - a[..., 0])
    )


def nearest_and_top(body: Body, scene: Scene) -> tuple[float, float]:
    """Ground distance [m] from the antenna below which no point of a body ever comes, and its greatest height [m]."""
    radius, top = 0.0, 0.0
    if body.mesh is not None:
        used = body.mesh.vertices[np.unique(body.mesh.faces)]
        radius, top = float(np.hypot(used[:, 0], used[:, 1]).max()), float(used[:, 2].max())
    lean = 0.0 if scene.own_ship.sway is None else scene.radar.height  # the mast sways about the water line
    gap = closest_approach(scene.own_ship, body.motion) - radius - lean
    return max(0.0, gap), top + highest(body.motion)


def highest(motion: Motion) -> float:
    """The greatest height [m] of a motion; inf where it climbs for ever."""
    return float("inf") if motion.final_velocity[2] > 0.0 else float(motion.position[:, 2].max())
