"""The reference of the samplers: the mean power of a surface by a regular lattice of rays.

It shares no code with the samplers: it has no points on surfaces, random rays, Embree or float32. The curvature of the
earth lowers each vertex. Rays of a regular lattice of directions meet triangles by Cramer's rule in float64. The mean power
is the integral of gamma K G^2 / R^2 over the solid angle, where K is the constant of the radar equation.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.study.chart.closed_form import beam
from radar_service.world.scene import Scene

LIGHT = 299_792_458.0
EARTH = 6_371_000.0


@dataclass(frozen=True)
class Window:
    """A sector of the picture: first azimuth [rad], extent in azimuth [rad], nearest and farthest range [m]."""

    azimuth: float
    angle: float
    near: float
    far: float

    def contains(self, azimuth: Floats, distance: Floats) -> Flags:
        """Whether echoes (E,) lie in it."""
        inside = (azimuth - self.azimuth) % (2.0 * np.pi) < self.angle
        return np.asarray(inside & (distance >= self.near) & (distance < self.far))


class ReferenceSurface:
    """All triangles of a frozen scene, relative to the antenna."""

    def __init__(self, scene: Scene) -> None:
        self._radar = scene.radar
        self._antenna = scene.antenna(0.0)[0]
        self._earth = scene.environment.earth_factor * EARTH
        corners, gamma = [], []
        for body in scene.bodies:
            if body.mesh is not None:
                pose = body.motion.pose(0.0)
                vertices = self._from_antenna(body.mesh.vertices, pose.position[0], float(pose.heading[0]))
                corners.append(vertices[body.mesh.faces])
                gamma.append(np.full(len(body.mesh.faces), body.material.gamma))
        self._corners, self._gamma = np.concatenate(corners), np.concatenate(gamma)
        x, y, z = np.moveaxis(self._corners, 2, 0)
        bearing = np.arctan2(x, y)
        self._bearing = bearing[:, 0]
        offset = (bearing - bearing[:, :1] + np.pi) % (2.0 * np.pi) - np.pi
        self._left, self._right = offset.min(axis=1), offset.max(axis=1)
        ground = np.hypot(x, y)
        self._high = np.arctan2(z.max(axis=1), np.where(z.max(axis=1) > 0, _nearest_ground(x, y), ground.max(axis=1)))
        self._low = np.arctan2(z.min(axis=1), np.where(z.min(axis=1) < 0, _nearest_ground(x, y), ground.max(axis=1)))
        self._near, self._far = _nearest_ground(x, y), np.sqrt(x**2 + y**2 + z**2).max(axis=1)

    def _from_antenna(self, vertices: Floats, position: Floats, heading: float) -> Floats:
        """Returns vertices (V, 3) [m] relative to the antenna, lowered by the curvature of the earth."""
        east = vertices[:, 0] * np.cos(heading) + vertices[:, 1] * np.sin(heading) + position[0] - self._antenna[0]
        north = vertices[:, 1] * np.cos(heading) - vertices[:, 0] * np.sin(heading) + position[1] - self._antenna[1]
        up = vertices[:, 2] + position[2] - self._antenna[2]
        return np.stack([east, north, up - (east**2 + north**2) / (2.0 * self._earth)], axis=1)

    def power(self, window: Window, columns: int, rows: int) -> float:
        """Returns the mean power [W] of all surfaces in a window on boresight, from a lattice of columns x rows rays."""
        radar = self._radar
        azimuths = window.azimuth + window.angle * (np.arange(columns) + 0.5) / columns
        inside = self._overlapping(window.azimuth, window.angle) & (self._near < window.far) & (self._far > window.near)
        if not inside.any():
            return 0.0
        extent = 1.5 * radar.beamwidth_el  # as far as the rays of the samplers
        low, high = max(self._low[inside].min(), radar.tilt - extent), min(self._high[inside].max(), radar.tilt + extent)
        if high <= low:
            return 0.0
        elevation = low + (high - low) * (np.arange(rows) + 0.5) / rows
        total = sum(self._column(float(azimuth), elevation, window) for azimuth in azimuths)
        constant = radar.power * radar.gain**2 * (LIGHT / radar.frequency) ** 2 / ((4.0 * np.pi) ** 3 * radar.loss)
        return float(constant * total * (window.angle / columns) * (high - low) / rows)

    def _column(self, azimuth: float, elevation: Floats, window: Window) -> float:
        """Returns the sum of gamma G^2 cos(elevation) / R^2 over the rays of one azimuth that meet a surface in the window."""
        some = np.flatnonzero(self._overlapping(azimuth, 0.0))
        ray = np.stack([np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)], axis=1)
        distance, triangle = _first_hit(self._corners[some], ray)
        hit = np.isfinite(distance) & (distance >= window.near) & (distance < window.far)
        hit &= ~self._below_sea(elevation, distance)
        radar = self._radar
        gain = beam(elevation[hit] - radar.tilt, radar.beamwidth_el, radar.pattern_el)
        nearest = np.maximum(distance[hit], radar.range_min)
        loss = distance[hit] ** 2 / nearest**4
        return float(np.sum(self._gamma[some[triangle[hit]]] * gain**2 * np.cos(elevation[hit]) * loss))

    def _overlapping(self, azimuth: float, angle: float) -> Flags:
        """Whether triangles (F,) reach into the sector of `angle` [rad] clockwise from `azimuth` [rad]."""
        offset = (self._bearing - azimuth + np.pi) % (2.0 * np.pi) - np.pi
        surrounds = self._right - self._left > np.pi / 2  # under the antenna
        return np.asarray(surrounds | ((offset + self._right >= 0.0) & (offset + self._left <= angle)))

    def _below_sea(self, elevation: Floats, distance: Floats) -> Flags:
        """Whether rays meet the sea first: their height h + d tan(e) + d^2 / (2 ae) falls below 0 on the way."""
        h, slope = self._antenna[2], np.tan(elevation)
        ground = np.where(np.isfinite(distance), distance, 0.0) * np.cos(elevation)
        lowest = np.clip(-slope * self._earth, 0.0, ground) if np.isfinite(self._earth) else ground * (slope < 0)
        return np.asarray(h + lowest * slope + lowest**2 / (2.0 * self._earth) < -1e-6)


def _nearest_ground(x: Floats, y: Floats) -> Floats:
    """Returns the smallest ground distance (F,) [m] of triangles with corners (F, 3), 0 of those around the antenna."""
    ends = [(np.stack([x[:, i], y[:, i]], 1), np.stack([x[:, j], y[:, j]], 1)) for i, j in ((0, 1), (1, 2), (2, 0))]
    nearest = np.full(len(x), np.inf)
    crosses = []
    for a, b in ends:
        along = b - a
        share = -np.einsum("ij,ij->i", a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
        nearest = np.minimum(nearest, np.linalg.norm(a + np.clip(share, 0.0, 1.0)[:, None] * along, axis=1))
        crosses.append(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    side = np.stack(crosses)
    within = (side >= 0).all(axis=0) | (side <= 0).all(axis=0)
    return np.where(within, 0.0, nearest)


def _first_hit(corners: Floats, ray: Floats) -> tuple[Floats, Indices]:
    """Returns the distance (M,) [m] along unit rays (M, 3) to the first of triangles (F, 3, 3), or inf, and its index."""
    if not len(corners):
        return np.full(len(ray), np.inf), np.zeros(len(ray), dtype=np.int64)
    a, b, c = (corners[:, i] for i in range(3))
    volume = np.einsum("fi,fi->f", a, np.cross(b, c))  # Cramer's rule: coordinates of the ray on the corners
    shares = np.stack([ray @ np.cross(b, c).T, ray @ np.cross(c, a).T, ray @ np.cross(a, b).T])
    inside = (shares >= 0).all(axis=0) | (shares <= 0).all(axis=0)
    total = shares.sum(axis=0)
    distance = np.divide(volume, total, out=np.full(total.shape, np.inf), where=inside & (total != 0))
    distance[distance <= 0] = np.inf
    first = distance.argmin(axis=1)
    return distance[np.arange(len(ray)), first], first
