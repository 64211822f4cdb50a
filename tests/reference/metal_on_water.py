"""Slow reference: flat metal faces over the sea by physical optics, element by element, sharing no code with the engine.

Each element of a lit face carries the currents of a perfect conductor. It is lit directly and by the sea, and it returns both
ways, so four paths are added, each with its own directions, length, shadow and coefficient. All lengths are exact, so the near
field is in it. A part of a face below the sea does not exist. Author: this project, from J = 2 n x H (Knott, Shaeffer, Tuley
1985), the reflection at equal angles, Fresnel's coefficients, divergence (Kerr 1951) and roughness (Miller, Brown, Vegh 1984).

Positions are east, north and height above the sea about the foot of the antenna [m]; the earth's surface there is
z = -d^2 / (2 ae) (docs/conventions.md). Phases follow exp(+j w t).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

LIGHT = 299_792_458.0
EARTH = 4.0 / 3.0 * 6_371_000.0  # m, effective radius
SEA_WATER = 55.3 - 38.2j  # relative permittivity at 9.41 GHz and 15 C, reference value
SIGNIFICANT = (0.0, *(0.04 + 0.1 * state**2.1 for state in range(1, 6)))  # m, wave height by sea state: NRL 2012
UPRIGHT = 50.0  # m: a wall that is higher covers all that is behind it, a lower one a part
WAYS = (0, 1, 2)  # how many of the two ways go by the sea


@dataclass(frozen=True)
class Setting:
    """Radar and sea.

    wavelength: [m]; antenna_height: above the sea [m]; polarization: "h" or "v".
    beamwidth_el: one-way half-power width of a level sinc^2 beam [rad]; None: no vertical pattern.
    sea: whether the sea reflects; sea_state: 0 to 5; permittivity: of the sea; earth_radius: ae [m], inf for flat.
    """

    wavelength: float = LIGHT / 9.41e9
    antenna_height: float = 15.0
    polarization: str = "h"
    beamwidth_el: float | None = None
    sea: bool = True
    sea_state: int = 0
    permittivity: complex = SEA_WATER
    earth_radius: float = EARTH

    @property
    def wavenumber(self) -> float:
        """2 pi / lambda [rad/m]."""
        return 2.0 * np.pi / self.wavelength


@dataclass(frozen=True)
class Face:
    """A flat convex polygon (V, 3), V at least 3 [m], counterclockwise from outside; a sheet scatters on both sides."""

    corners: Floats
    sheet: bool = False


@dataclass(frozen=True)
class Screen:
    """An opaque flat parallelogram: corner and two sides (3,) at right angles [m]."""

    corner: Floats
    one: Floats
    other: Floats


class Elements(NamedTuple):
    """Flat elements: position (M, 3) [m]; area (M, 3), the unit normal on the lit side times the area [m^2]; size (M, 2, 3),
    both edges [m]."""

    position: Floats
    area: Floats
    edges: Floats


class Rays(NamedTuple):
    """Paths between antenna and points (M,): the direct one, or the one by the sea.

    length: [m]; level, rise: components (M,) of the unit direction at the point, along the ground and upward.
    weight: amplitude of one way relative to 1 m of free space, with phase (M,) [1/m].
    """

    length: Floats
    level: Floats
    rise: Floats
    weight: Complexes


class Contributions(NamedTuple):
    """What elements (M,) return: amplitude (3, M) by `WAYS` [m], the root of a cross-section at 1 m with its phase
    [1/m^2 each]; length (3, M): half of the whole way [m]; azimuth (M,) [rad]."""

    amplitude: Complexes
    length: Floats
    azimuth: Floats


# ------------------------------------------------------------------------------------------------------------------- the sea


def reflection_distance(distance: Floats, height: Floats, antenna_height: float, earth_radius: float) -> Floats:
    """Where the sea reflects: the distance x (M,) from the antenna [m] at which both grazing angles are equal, by bisection
    and Newton's steps; height (M,): above the local sea, positive."""
    top = height - distance**2 / (2.0 * earth_radius)
    x = distance * antenna_height / (antenna_height + height)
    low, high = np.zeros_like(x), np.array(distance, dtype=np.float64)
    for _ in range(60):
        rise_1, rise_2 = antenna_height + x**2 / (2.0 * earth_radius), top + x**2 / (2.0 * earth_radius)
        rest = distance - x
        unequal = np.arctan2(rise_1, x) - np.arctan2(rise_2, rest) - 2.0 * np.arctan(x / earth_radius)  # falls with x
        low, high = np.where(unequal > 0, x, low), np.where(unequal > 0, high, x)
        slope = -rise_1 / (x**2 + rise_1**2) - rise_2 / (rest**2 + rise_2**2)
        ahead = x - unequal / slope
        ahead = np.where((ahead > low) & (ahead < high), ahead, (low + high) / 2.0)
        if np.all(np.abs(ahead - x) <= 1e-7 * distance):
            break
        x = ahead
    return ahead


def sea_coefficient(grazing: Floats, setting: Setting) -> Complexes:
    """Fresnel's coefficient times the roughness factor exp(-g^2/2) I0(g^2/2), (M,)."""
    sine = np.sin(grazing)
    root = np.sqrt(setting.permittivity - np.cos(grazing) ** 2 + 0j)
    first = sine if setting.polarization == "h" else setting.permittivity * sine
    rms = SIGNIFICANT[setting.sea_state] / 4.0
    half = 0.5 * (2.0 * setting.wavenumber * rms * sine) ** 2
    return np.asarray((first - root) / (first + root) * scaled_bessel(half))


def scaled_bessel(x: Floats) -> Floats:
    """exp(-x) I0(x) for x (M,) >= 0; beyond 50 by its asymptotic series (Abramowitz and Stegun 9.7.1), to 1e-8."""
    small = np.minimum(x, 50.0)
    near = np.exp(-small) * np.i0(small)
    large = np.maximum(x, 50.0)
    far = (1.0 + 1.0 / (8.0 * large) + 9.0 / (128.0 * large**2) + 225.0 / (3072.0 * large**3)) / np.sqrt(2 * np.pi * large)
    return np.where(x < 50.0, near, far)


def vertical_gain(rise: Floats, setting: Setting) -> Floats:
    """One-way amplitude gain (M,) toward rays of which the elevation at the antenna is `rise` (M,) [rad]."""
    if setting.beamwidth_el is None:
        return np.ones_like(rise)
    return np.abs(np.sinc(2.783114752 / np.pi * rise / setting.beamwidth_el))


# ------------------------------------------------------------------------------------------------------------------ the rays


def direct_rays(position: Floats, setting: Setting) -> Rays:
    """The straight paths to points (M, 3)."""
    ground = np.hypot(position[:, 0], position[:, 1])
    z = position[:, 2] - ground**2 / (2.0 * setting.earth_radius) - setting.antenna_height
    length = np.hypot(ground, z)
    weight = vertical_gain(np.arctan2(z, ground), setting) * np.exp(-1j * setting.wavenumber * length) / length
    return Rays(length, ground / length, z / length, weight)


def sea_rays(position: Floats, setting: Setting) -> Rays:
    """The paths by the sea to points (M, 3); directions are those of the second leg."""
    ground, radius = np.hypot(position[:, 0], position[:, 1]), setting.earth_radius
    x = reflection_distance(ground, position[:, 2], setting.antenna_height, radius)
    foot = -(x**2) / (2.0 * radius)
    top = position[:, 2] - ground**2 / (2.0 * radius)
    first, second = np.hypot(x, setting.antenna_height - foot), np.hypot(ground - x, top - foot)
    grazing = np.arctan2(setting.antenna_height - foot, x) - np.arctan(x / radius)
    spread = 1.0 / np.sqrt(1.0 + 2.0 * x * (ground - x) / (radius * ground * np.sin(grazing)))
    gain = vertical_gain(np.arctan2(foot - setting.antenna_height, x), setting)
    length = first + second
    phase = np.exp(-1j * setting.wavenumber * length)
    weight = sea_coefficient(grazing, setting) * (spread * gain / length) * phase
    return Rays(length, (ground - x) / second, (top - foot) / second, np.where(grazing > 0, weight, 0.0))


# --------------------------------------------------------------------------------------------------------------- the currents


def contributions(elements: Elements, sheet: bool, setting: Setting, screens: Sequence[Screen] = ()) -> Contributions:
    """What elements return by each number of ways over the sea; the sum over all is the scattered amplitude."""
    position = elements.position
    direct = direct_rays(position, setting)
    azimuth = np.arctan2(position[:, 0], position[:, 1])
    outward = elements.area[:, 0] * np.sin(azimuth) + elements.area[:, 1] * np.cos(azimuth)
    upward = elements.area[:, 2]
    if np.isfinite(setting.earth_radius):  # the surface's own tilt there, of areas the transposed inverse of the shear
        outward = outward + np.hypot(position[:, 0], position[:, 1]) / setting.earth_radius * upward
    rays = [direct, sea_rays(position, setting)] if setting.sea else [direct]
    clear = [uncovered(elements, setting, screens, way) for way in range(len(rays))]
    amplitude = np.zeros((3, len(position)), dtype=np.complex128)
    for side in (1.0, -1.0) if sheet else (1.0,):
        lit = [side * (ray.level * outward + ray.rise * upward) < 0.0 for ray in rays]
        for a, there in enumerate(rays):
            for b, back in enumerate(rays):
                both = lit[a] & lit[b]
                shown = both * np.minimum(clear[a], clear[b])
                amplitude[a + b] += (
                    shown * side * current(there, back, outward, upward, setting) * there.weight * back.weight
                )
    amplitude *= -2j * np.sqrt(np.pi) / setting.wavelength
    other = rays[-1].length
    length = np.stack([direct.length, (direct.length + other) / 2.0, other])
    return Contributions(amplitude, length, azimuth)


def current(there: Rays, back: Rays, outward: Floats, upward: Floats, setting: Setting) -> Floats:
    """(p_b . d_a)(n . p_a) - (p_b . p_a)(n . d_a), times the area (M,): what waves along d_a leave toward -d_b."""
    facing = there.level * outward + there.rise * upward
    if setting.polarization == "h":
        return -facing
    across = upward * there.level - outward * there.rise
    along = there.rise * back.level - there.level * back.rise
    return along * across - (there.level * back.level + there.rise * back.rise) * facing


# ---------------------------------------------------------------------------------------------------------------- the shadows


def uncovered(elements: Elements, setting: Setting, screens: Sequence[Screen], way: int) -> Floats:
    """Share (M,) of each element that no screen covers, on the direct way (0) or on the way by the sea (1)."""
    clear = np.ones(len(elements.position))
    if not screens:
        return clear
    antenna = np.array([0.0, 0.0, setting.antenna_height])
    position, ground = bent(elements.position, setting), np.hypot(*elements.position[:, :2].T)
    start = np.broadcast_to(antenna, position.shape)
    legs = [(start, position, np.zeros_like(ground), np.ones_like(ground))]
    if way == 1:
        x = reflection_distance(ground, elements.position[:, 2], setting.antenna_height, setting.earth_radius)
        foot = elements.position * (x / ground)[:, None]
        foot[:, 2] = -(x**2) / (2.0 * setting.earth_radius)
        legs = [(start, foot, np.zeros_like(x), x / ground), (foot, position, x / ground, np.ones_like(x))]
    for screen in screens:
        for leg in legs:
            clear *= 1.0 - cover(*leg, elements.edges, screen, setting)
    return clear


def cover(
    start: Floats, stop: Floats, first: Floats, last: Floats, edges: Floats, screen: Screen, setting: Setting
) -> Floats:
    """Share (M,) of bundles of rays from start to stop (M, 3) that a screen stops. They begin in a point and end as wide as
    `edges` (M, 2, 3); this leg holds shares `first` to `last` (M,) of the whole way."""
    corner = bent(screen.corner[None], setting)[0]
    normal = np.cross(screen.one, screen.other)
    before, after = (start - corner) @ normal, (stop - corner) @ normal
    crosses = before * after < 0.0
    t = np.divide(before, before - after, out=np.zeros_like(before), where=crosses)
    point = start + t[:, None] * (stop - start) - corner
    share = crosses.astype(np.float64)
    for side in (screen.one, screen.other):
        length = float(np.linalg.norm(side))
        at = point @ side / length
        wide = (first + t * (last - first)) * np.abs(edges @ (side / length)).sum(axis=1) + 1e-9
        share *= np.clip((length - at) / wide + 0.5, 0.0, 1.0) * np.clip(at / wide + 0.5, 0.0, 1.0)
    return share


def bent(position: Floats, setting: Setting) -> Floats:
    """Points (M, 3) lowered by the earth's curve."""
    result = position.copy()
    result[:, 2] -= (position[:, 0] ** 2 + position[:, 1] ** 2) / (2.0 * setting.earth_radius)
    return result


# --------------------------------------------------------------------------------------------------------------- the elements


def clipped(corners: Floats, side: Floats) -> Floats:
    """What of a convex polygon (V, 3) lies where `side` (V,), linear in position, is positive: (W, 3), none with W = 0."""
    result: list[Floats] = []
    if side.max(initial=0.0) <= 1e-9:  # a bottom on the water is not above it
        return np.zeros((0, 3))
    for a, b, p, q in zip(corners, np.roll(corners, -1, axis=0), side, np.roll(side, -1), strict=True):
        if p >= 0.0:
            result.append(a)
        if p * q < 0.0:
            result.append(a + (b - a) * p / (p - q))
    return np.array(result).reshape(-1, 3)


def beside(corners: Floats, screen: Screen) -> list[Floats]:
    """What of a convex polygon (V, 3) is left and right of a tall wall nearer by. Direct and reflected rays to a point lie in
    one upright plane through the antenna, so both have the same shadow edge."""
    ends = screen.corner[:2], (screen.corner + screen.one)[:2]
    left, right = sorted(ends, key=lambda end: float(np.cross(np.append(ends[0], 0), np.append(end, 0))[2]), reverse=True)
    beyond_left = left[0] * corners[:, 1] - left[1] * corners[:, 0]
    beyond_right = corners[:, 0] * right[1] - corners[:, 1] * right[0]
    return [part for part in (clipped(corners, beyond_left), clipped(corners, beyond_right)) if len(part)]


def quadrangles(corners: Floats) -> list[Floats]:
    """A convex polygon (V, 3) as quadrangles (4, 3); the last may have two corners in one."""
    parts = []
    for first in range(1, len(corners) - 1, 2):
        last = min(first + 2, len(corners) - 1)
        parts.append(corners[[0, first, first + 1, last]])
    return parts


def placed(face: Face, position: Floats, heading: float) -> Face:
    """A face of a body's own frame (x starboard, y ahead) at a position (3,) [m] and heading [rad]."""
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = face.corners.T
    return replace(face, corners=np.stack([c * x + s * y, c * y - s * x, z], axis=1) + position)


def path_lengths(position: Floats, setting: Setting) -> list[Floats]:
    """Lengths (M,) [m] of the direct path, and of the one by the sea."""
    rays = [direct_rays(position, replace(setting, beamwidth_el=None)).length]
    return [*rays, sea_rays(position, setting).length] if setting.sea else rays


def turns(quad: Floats, setting: Setting) -> tuple[float, float]:
    """Largest total change of the two-way phase along a quadrangle's first and second edges [rad]."""
    share = (np.arange(33) / 32.0)[:, None]
    result = []
    for a, b, c, d in ((0, 1, 3, 2), (0, 3, 1, 2)):
        worst = 0.0
        for start, stop in ((quad[a], quad[b]), (quad[c], quad[d])):
            line = start + share * (stop - start)
            line[:, 2] = np.maximum(line[:, 2], 1e-3)
            for length in path_lengths(line, setting):
                worst = max(worst, float(np.abs(np.diff(length)).sum()))
        result.append(2.0 * setting.wavenumber * worst)
    return result[0], result[1]


@lru_cache(maxsize=256)
def gauss(panels: int, order: int) -> tuple[Floats, Floats]:
    """Nodes and weights of composite Gauss-Legendre quadrature over 0 to 1."""
    node, weight = np.polynomial.legendre.leggauss(order)
    first = np.arange(panels)[:, None]
    return ((first + (node + 1.0) / 2.0) / panels).ravel(), np.tile(weight / 2.0 / panels, panels)


def gauss_for(phase: float) -> tuple[Floats, Floats]:
    """Quadrature for an oscillation by `phase` [rad]: the error falls beyond phase / 4 nodes, and 12 more leave 1e-6."""
    panels = int(np.ceil(phase / 200.0)) or 1
    order = int(np.ceil((0.3 * phase / panels + 14.0) / 4.0)) * 4
    return gauss(panels, order)


def midpoints(count: int) -> tuple[Floats, Floats]:
    """Equal elements over 0 to 1."""
    return (np.arange(count) + 0.5) / count, np.full(count, 1.0 / count)


def bilinear(quad: Floats, first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> Elements:
    """Elements of a flat quadrangle (4, 3) at nodes along its first and second edges."""
    s, t = (grid.ravel()[:, None] for grid in np.meshgrid(first[0], second[0], indexing="ij"))
    weight = (first[1][:, None] * second[1]).ravel()[:, None]
    a, b, c, d = quad
    along = (b - a) * (1.0 - t) + (c - d) * t
    across = (d - a) * (1.0 - s) + (c - b) * s
    position = a * (1 - s) * (1 - t) + b * s * (1 - t) + c * s * t + d * (1 - s) * t
    step = np.repeat(first[1], len(second[1]))[:, None], np.tile(second[1], len(first[1]))[:, None]
    return Elements(position, np.cross(along, across) * weight, np.stack([along * step[0], across * step[1]], axis=1))


def smooth_elements(quad: Floats, setting: Setting) -> Elements:
    """Elements of a quadrangle without shadow edges: Gauss-Legendre nodes, as many as the phase needs."""
    first, second = turns(quad, setting)
    return bilinear(quad, gauss_for(first), gauss_for(second))


def equal_elements(quad: Floats, size: float) -> Elements:
    """Elements of a quadrangle no longer than `size` [m]: brute force."""
    counts = []
    for a, b, c, d in ((0, 1, 3, 2), (0, 3, 1, 2)):
        longest = max(np.linalg.norm(quad[b] - quad[a]), np.linalg.norm(quad[d] - quad[c]))
        counts.append(max(1, int(np.ceil(longest / size))))
    return bilinear(quad, midpoints(counts[0]), midpoints(counts[1]))


def screened_elements(quad: Floats, setting: Setting) -> Elements:
    """Elements of a quadrangle on which the shadow of a low wall runs along the first edge: Gauss-Legendre nodes along it;
    across it equal elements, over which the phase turns by 0.3 rad at most (0.4 %), and 128 or more of them."""
    along, across = turns(quad, setting)
    elements = bilinear(quad, gauss_for(along), midpoints(int(np.ceil(max(across / 0.3, 128.0)))))
    elements.edges[:, 0] = 0.0
    return elements


# ------------------------------------------------------------------------------------------------------------------- the sums


def pieces(faces: Sequence[Face], setting: Setting, screens: Sequence[Screen], size: float | None) -> list[Contributions]:
    """Contributions of faces on the map, of elements of `size` [m], or of as many as the phase needs with None."""
    if size is not None:
        brute = [(face.sheet, equal_elements(quad, size)) for face in faces for quad in quadrangles(dry(face.corners))]
        return [contributions(part, sheet, setting, screens) for sheet, whole in brute for part in chunks(whole)]
    tall, low = ([screen for screen in screens if bool(screen.other[2] > UPRIGHT) is upright] for upright in (True, False))
    result = []
    for face in faces:
        polygons = [dry(face.corners)] if may_be_lit(face, setting) else []
        for screen in tall:
            polygons = [part for polygon in polygons for part in beside(polygon, screen)]
        for quad in (quad for polygon in polygons for quad in quadrangles(polygon)):
            elements = screened_elements(quad, setting) if low else smooth_elements(quad, setting)
            result += [contributions(part, face.sheet, setting, low) for part in chunks(elements)]
    return result


def dry(corners: Floats) -> Floats:
    """What of a convex polygon (V, 3) is above the water."""
    return clipped(corners, corners[:, 2])


def may_be_lit(face: Face, setting: Setting) -> bool:
    """Whether any ray comes from before the outer side of a face: directions are tried at its corners, with a margin."""
    a, b, c = face.corners[:3]
    normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    corners = np.maximum(face.corners, [-np.inf, -np.inf, 1e-3])
    azimuth = np.arctan2(corners[:, 0], corners[:, 1])
    rays = [direct_rays(corners, setting), *([sea_rays(corners, setting)] if setting.sea else [])]
    along = normal[0] * np.sin(azimuth) + normal[1] * np.cos(azimuth)
    return face.sheet or any(bool((ray.level * along + ray.rise * normal[2] < 1e-2).any()) for ray in rays)


def chunks(elements: Elements, count: int = 65_536) -> list[Elements]:
    """Elements in parts of at most `count`, which the cache holds."""
    starts = range(0, len(elements.position), count)
    return [Elements(*(part[start : start + count] for part in elements)) for start in starts]


def scattering_amplitude(
    faces: Sequence[Face],
    setting: Setting,
    distance: float,
    screens: Sequence[Screen] = (),
    size: float | None = None,
    ways: Sequence[int] = WAYS,
) -> complex:
    """Root of the cross-section [m] with its phase, as the radar equation at slant range `distance` [m] has it.

    faces: on the map; size: of brute-force elements [m], such as lambda / 8; None: quadrature; ways: which are added.
    """
    parts = pieces(faces, setting, screens, size)
    return complex(distance**2 * sum(part.amplitude[way].sum() for part in parts for way in ways))


def slant_range(position: Floats, setting: Setting) -> float:
    """Slant range [m] of a position (3,)."""
    return float(direct_rays(np.asarray(position, dtype=np.float64)[None], setting).length[0])


def two_ray_field(position: Floats, setting: Setting) -> Complexes:
    """F (M,) of points (M, 3): the field over that of the direct ray."""
    direct = direct_rays(position, setting).weight
    return np.asarray(1.0 + sea_rays(position, setting).weight / direct) if setting.sea else np.ones(len(position), complex)


# ----------------------------------------------------------------------------------------------------------------- the bodies


def plate(width: float, height: float, lean: float = 0.0) -> list[Face]:
    """A sheet about the origin, normal +y leaning back by `lean` [rad]: its lower edge comes forward."""
    w, h = width / 2.0, height / 2.0
    corners = np.array([(w, 0, -h), (-w, 0, -h), (-w, 0, h), (w, 0, h)])
    corners[:, 1], corners[:, 2] = -corners[:, 2] * np.sin(lean), corners[:, 2] * np.cos(lean)
    return [Face(corners, sheet=True)]


def prism(bottom: tuple[float, float], top: tuple[float, float], height: float) -> list[Face]:
    """A closed body from z = 0 to `height`: rectangles (width along x, length along y) at its bottom and top. A wider top
    makes the flare of a hull, a narrower one a mast or a deckhouse."""
    low, high = (
        np.array([(-x / 2, -y / 2, z), (x / 2, -y / 2, z), (x / 2, y / 2, z), (-x / 2, y / 2, z)])
        for (x, y), z in ((bottom, 0.0), (top, height))
    )
    sides = [Face(np.array([low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]])) for i in range(4)]
    return [*sides, Face(high), Face(low[::-1].copy())]
