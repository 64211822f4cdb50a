"""Reference twin of the samplers: the mean power that a stretch of surface returns, by a lattice of rays of its own.

It shares no code with them: no points on surfaces, no random rays, no Embree, no float32. Triangles are bent vertex by
vertex about the antenna, a regular lattice of directions is tried against those in their way by the determinants of
Cramer's rule in float64, and the mean power is the integral of gamma K G^2 / R^2 over the solid angle, K the radar
equation's constant.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.world import Scene
from radar_service.study.chart.twin import beam

Floats = NDArray[np.float64]
LIGHT = 299_792_458.0
EARTH = 6_371_000.0


@dataclass(frozen=True)
class Window:
    """A piece of the picture: azimuth [rad] of its first side and how far it goes round, and ranges [m] from and to."""

    azimuth: float
    angle: float
    near: float
    far: float

    def holds(self, azimuth: Floats, distance: Floats) -> NDArray[np.bool_]:
        """Which echoes (E,) are in it."""
        inside = (azimuth - self.azimuth) % (2.0 * np.pi) < self.angle
        return np.asarray(inside & (distance >= self.near) & (distance < self.far))


class SurfaceTwin:
    """All triangles of a stopped scene as the antenna sees them."""

    def __init__(self, scene: Scene) -> None:
        self._radar = scene.radar
        self._antenna = scene.antenna(0.0)[0]
        self._earth = scene.environment.earth_factor * EARTH
        corners, gamma = [], []
        for body in scene.bodies:
            if body.mesh is not None:
                pose = body.motion.pose(0.0)
                seen = self._seen(body.mesh.vertices, pose.position[0], float(pose.heading[0]))
                corners.append(seen[body.mesh.faces])
                gamma.append(np.full(len(body.mesh.faces), body.material.gamma))
        self._corners, self._gamma = np.concatenate(corners), np.concatenate(gamma)
        x, y, z = np.moveaxis(self._corners, 2, 0)
        bearing = np.arctan2(x, y)
        self._middle = bearing[:, 0]
        turn = (bearing - bearing[:, :1] + np.pi) % (2.0 * np.pi) - np.pi
        self._left, self._right = turn.min(axis=1), turn.max(axis=1)
        level = np.hypot(x, y)
        self._high = np.arctan2(z.max(axis=1), np.where(z.max(axis=1) > 0, _nearest(x, y), level.max(axis=1)))
        self._low = np.arctan2(z.min(axis=1), np.where(z.min(axis=1) < 0, _nearest(x, y), level.max(axis=1)))
        self._near, self._far = _nearest(x, y), np.sqrt(x**2 + y**2 + z**2).max(axis=1)

    def _seen(self, vertices: Floats, place: Floats, heading: float) -> Floats:
        """Vertices (V, 3) relative to the antenna, lowered by the curve of the earth."""
        east = vertices[:, 0] * np.cos(heading) + vertices[:, 1] * np.sin(heading) + place[0] - self._antenna[0]
        north = vertices[:, 1] * np.cos(heading) - vertices[:, 0] * np.sin(heading) + place[1] - self._antenna[1]
        up = vertices[:, 2] + place[2] - self._antenna[2]
        return np.stack([east, north, up - (east**2 + north**2) / (2.0 * self._earth)], axis=1)

    def power(self, window: Window, across: int, upward: int) -> float:
        """Mean power [W] that a boresight through it would hear of all surfaces in a window, from a lattice."""
        radar = self._radar
        azimuths = window.azimuth + window.angle * (np.arange(across) + 0.5) / across
        inside = self._meeting(window.azimuth, window.angle) & (self._near < window.far) & (self._far > window.near)
        if not inside.any():
            return 0.0
        reach = 1.5 * radar.beamwidth_el  # of the rays that the samplers throw
        low, high = max(self._low[inside].min(), radar.tilt - reach), min(self._high[inside].max(), radar.tilt + reach)
        if high <= low:
            return 0.0
        elevation = low + (high - low) * (np.arange(upward) + 0.5) / upward
        total = sum(self._column(float(azimuth), elevation, window) for azimuth in azimuths)
        constant = radar.power * radar.gain**2 * (LIGHT / radar.frequency) ** 2 / ((4.0 * np.pi) ** 3 * radar.loss)
        return float(constant * total * (window.angle / across) * (high - low) / upward)

    def _column(self, azimuth: float, elevation: Floats, window: Window) -> float:
        """Sum over directions of one azimuth of gamma G^2 cos(elevation) / R^2 of what they meet in the window."""
        some = np.flatnonzero(self._meeting(azimuth, 0.0))
        ray = np.stack([np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)], axis=1)
        distance, which = _first_met(self._corners[some], ray)
        met = np.isfinite(distance) & (distance >= window.near) & (distance < window.far)
        met &= ~self._under_water(elevation, distance)
        radar = self._radar
        gain = beam(elevation[met] - radar.tilt, radar.beamwidth_el, radar.pattern_el)
        nearest = np.maximum(distance[met], radar.range_min)
        spread = distance[met] ** 2 / nearest**4
        return float(np.sum(self._gamma[some[which[met]]] * gain**2 * np.cos(elevation[met]) * spread))

    def _meeting(self, azimuth: float, angle: float) -> NDArray[np.bool_]:
        """Which triangles have a part between `azimuth` and `angle` [rad] farther on."""
        after = (self._middle - azimuth + np.pi) % (2.0 * np.pi) - np.pi
        around = self._right - self._left > np.pi / 2  # under the antenna
        return np.asarray(around | ((after + self._right >= 0.0) & (after + self._left <= angle)))

    def _under_water(self, elevation: Floats, distance: Floats) -> NDArray[np.bool_]:
        """Whether rays have met the sea before: height h + d tan(e) + d^2 / (2 ae) falls below 0 on the way."""
        h, slope = self._antenna[2], np.tan(elevation)
        level = np.where(np.isfinite(distance), distance, 0.0) * np.cos(elevation)
        lowest = np.clip(-slope * self._earth, 0.0, level) if np.isfinite(self._earth) else level * (slope < 0)
        return np.asarray(h + lowest * slope + lowest**2 / (2.0 * self._earth) < -1e-6)


def _nearest(x: Floats, y: Floats) -> Floats:
    """Level distance (F,) [m] of the nearest places of triangles (F, 3), 0 of those around the antenna."""
    ends = [(np.stack([x[:, i], y[:, i]], 1), np.stack([x[:, j], y[:, j]], 1)) for i, j in ((0, 1), (1, 2), (2, 0))]
    found = np.full(len(x), np.inf)
    crosses = []
    for a, b in ends:
        along = b - a
        share = -np.einsum("ij,ij->i", a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
        found = np.minimum(found, np.linalg.norm(a + np.clip(share, 0.0, 1.0)[:, None] * along, axis=1))
        crosses.append(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    side = np.stack(crosses)
    within = (side >= 0).all(axis=0) | (side <= 0).all(axis=0)
    return np.where(within, 0.0, found)


def _first_met(corners: Floats, ray: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Distance (M,) [m] from the origin to the first of triangles (F, 3, 3) along unit rays (M, 3), inf, and which it is."""
    if not len(corners):
        return np.full(len(ray), np.inf), np.zeros(len(ray), dtype=np.int64)
    a, b, c = (corners[:, i] for i in range(3))
    volume = np.einsum("fi,fi->f", a, np.cross(b, c))  # a = u, v, w of the ray in the corners' own axes
    shares = np.stack([ray @ np.cross(b, c).T, ray @ np.cross(c, a).T, ray @ np.cross(a, b).T])
    same = (shares >= 0).all(axis=0) | (shares <= 0).all(axis=0)
    total = shares.sum(axis=0)
    distance = np.divide(volume, total, out=np.full(total.shape, np.inf), where=same & (total != 0))
    distance[distance <= 0] = np.inf
    which = distance.argmin(axis=1)
    return distance[np.arange(len(ray)), which], which
