"""The references of the chart: the compressed pulse under the exact beam, echo by echo, and the mean power of a surface by a
regular lattice of rays. They share no code with the engine.

The mean power is the integral of gamma K G^2 / R^2 over the solid angle; K is the constant of the radar equation.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from radar_service.echo import Echoes
from radar_service.numerics import Complexes, Flags, Floats, Indices
from radar_service.radar import AntennaPattern, Cosine, Cosine2, Gaussian, Printed, Radar, Sinc2, Taylor
from radar_service.study.compressed_pulse import (
    compressed_chirp,
    compressed_nonlinear_chirp,
    tapered_pulse,
)
from radar_service.world import Scene

LIGHT = 299_792_458.0
EARTH = 6_371_000.0
ECHOES_PER_BATCH = 128
SINGULARITY_STEP = 1e-8  # distance kept from removable singularities: -160 dB
LineSource = Sinc2 | Cosine | Cosine2 | Taylor


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


def compressed_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns the compressed unit echo at `delay` [s] from its peak, any shape; a chirp gives 0 beyond a pulse length."""
    if radar.modulation == "none":
        return unmodulated_pulse(delay, radar)
    if radar.compression == "inverse":
        return tapered_pulse(delay, radar.bandwidth, radar.window)
    if radar.modulation == "nlfm":
        return compressed_nonlinear_chirp(delay, radar.bandwidth, radar.pulse, radar.window)
    return compressed_chirp(delay, radar.bandwidth, radar.pulse, radar.window)


def unmodulated_pulse(delay: Floats, radar: Radar) -> Complexes:
    """Returns an unmodulated pulse after a Gaussian filter of half-power bandwidth B, 1 at its middle.

    It is a difference of two normal integrals with the standard deviation sqrt(ln 2) / (pi B) of the impulse response.
    """
    half = radar.pulse / 2.0 * np.pi * radar.bandwidth / np.sqrt(np.log(2.0))
    x = 2.0 * half * delay / radar.pulse
    return np.asarray((ndtr(x + half) - ndtr(x - half)) / (2.0 * ndtr(half) - 1.0), dtype=np.complex128)


def beam(offset: Floats, beamwidth: float, pattern: AntennaPattern) -> Floats:
    """Returns the one-way power gain relative to boresight at `offset` [rad], any shape.

    A pattern without a formula here, such as a table, uses its own gain.
    """
    wrapped = np.angle(np.exp(1j * offset))
    match pattern:
        case Gaussian():
            return np.asarray(0.5 ** ((2.0 * wrapped / beamwidth) ** 2))
        case Printed():
            return np.asarray(np.sinc(2.783 * wrapped / beamwidth) ** 2)
        case Sinc2() | Cosine() | Cosine2() | Taylor():
            return np.asarray(aperture(2.0 * _half_power(pattern) * wrapped / beamwidth, pattern) ** 2)
    return pattern.gain(wrapped, beamwidth)


def _half_power(pattern: LineSource) -> float:
    """Returns the u at which the power of a line source is half of its peak, by bisection."""
    low, high = 0.3, 1.0  # half power of every aperture here lies between, in wavelengths over its length
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if aperture(np.array([middle]), pattern)[0] ** 2 > 0.5 else (low, middle)
    return low


def aperture(u: Floats, pattern: LineSource) -> Floats:
    """Returns the far field of a line source at u = (length / wavelength) sin(offset), 1 at 0.

    Sources: Balanis 2016; Taylor 1955.
    """
    shifted = u + 2.0 * SINGULARITY_STEP * (np.abs(u - np.rint(u)) < SINGULARITY_STEP)
    match pattern:
        case Sinc2():
            return np.asarray(np.sinc(u))
        case Cosine():
            halves = u + SINGULARITY_STEP * (np.abs(np.abs(u) - 0.5) < SINGULARITY_STEP)
            return np.asarray(np.cos(np.pi * halves) / (1.0 - 4.0 * halves**2))
        case Cosine2():
            return np.asarray(np.sinc(shifted) / (1.0 - shifted**2))
    n = np.arange(1, pattern.nbar)
    a = np.arccosh(10.0 ** (pattern.sidelobe_db / 20.0)) / np.pi
    zeros = pattern.nbar * np.sqrt((a**2 + (n - 0.5) ** 2) / (a**2 + (pattern.nbar - 0.5) ** 2))
    field = np.sinc(shifted)
    for zero, sinc_zero in zip(zeros, n, strict=True):
        field = field * (1.0 - (shifted / zero) ** 2) / (1.0 - (shifted / sinc_zero) ** 2)
    return np.asarray(field)


def closed_form_field(echoes: Echoes, radar: Radar, boresight: Floats, sample_range: Floats) -> Complexes:
    """Returns the field (K, N) [sqrt(W)] of echoes (E,) at boresights (K,) [rad] and ranges (N,) [m]."""
    field = np.zeros((len(boresight), len(sample_range)), dtype=np.complex128)
    for i in range(0, len(echoes.range), ECHOES_PER_BATCH):
        part = slice(i, i + ECHOES_PER_BATCH)
        delay = 2.0 * (sample_range - echoes.range[part, None]) / LIGHT
        weight = beam(boresight[:, None] - echoes.azimuth[part], radar.beamwidth, radar.pattern) * echoes.amplitude[part]
        field += weight @ compressed_pulse(delay, radar)
    return field
