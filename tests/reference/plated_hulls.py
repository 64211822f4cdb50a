"""Slow reference: whole hulls dented between frames, element by element with the dents in their positions (`metal_on_water`).

Each lit triangle above the sea is cut at its frames and tiers and integrated by Gauss-Legendre nodes, which lie where the dents
have them. Its first reflection alone is summed, by four paths. What the hull itself shades is found in the pictures of
`cast_shadows`, node by node. Dents follow docs/engine.md; only their drawn depths are the engine's.

| what | distribution |
|---|---|
| hull | all six types in turns, 9 to 30 m long (evenly in the logarithm), beam 0.24 to 0.36, height 0.25 to 0.4 of the length |
| aspect | within 5 degrees in azimuth, 2 in elevation of the normal of the largest side (80 %), else anywhere, list to 3 |
| plating | dents of 2 to 8 mm, frames 0.6 to 0.8 m apart, panels 1.5 to 3 m high |
| radar | 9.41 GHz, h or v, antenna at 8 to 25 m, 700 to 2500 m off |
| sea | reflects in 70 %, states 0 to 3 |
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tests.reference import metal_on_water as oracle
from tests.reference.cast_shadows import homogeneous
from tests.reference.metal_on_water import Floats, Setting
from tests.reference.ship_draws import log_uniform
from tests.reference.ship_tracks import starboard_down, turned_to

Indices = np.ndarray
TYPES = ("plain", "cargo", "ferry", "fishing", "yacht", "pilot")
MAX_TURN, MAX_LEAN, MAX_LIST = 5.0, 2.0, 3.0  # degrees off the normal of a wall, and off upright
NEAR = 0.8  # of the draws, near the normal of a wall
COPLANAR = 1e-6  # rad
AHEAD = 2e-6  # of the distance: what lies so much nearer shades
PANEL = 200.0  # rad of phase to a panel of nodes
CHUNK = 65_536  # elements that the cache holds
SLICE = 0.25  # m of distance to which faces are cut, so that the phase of a part turns along one edge alone
FINEST = 0.2  # m: larger parts across which the edge of a shadow runs are divided


class Dents(NamedTuple):
    """The largest depths (4, B, T) [m] of panels by wall, bay and tier, and the numbers of the first bay and tier."""

    depths: Floats
    first: tuple[int, int]


@dataclass(frozen=True)
class Hull:
    """A hull whose origin is on the sea north of the antenna.

    table: its shape and plating, as in a scene file. distance: [m].
    turn, lean: off the normal of the largest wall of its sides [rad]. near: whether it is posed so, else by heading and heel.
    heading, heel: [rad].
    """

    table: dict[str, Any]
    distance: float
    turn: float
    lean: float
    near: bool
    heading: float
    heel: float
    setting: Setting

    def posed(self, triangles: Floats) -> "Hull":
        """The hull as it is drawn; one that is `near` leans and turns about where that wall faces the antenna. triangles:
        (F, 3, 3) in its own frame [m]."""
        if not self.near:
            return self
        wall = plated_walls(triangles, self.table["plating"]["frame_m"]) >= 2
        across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[wall]
        normals, which = np.unique(np.round(_normals(triangles)[wall], 5), axis=0, return_inverse=True)
        x, y, z = normals[np.argmax(np.bincount(which.ravel(), np.linalg.norm(across, axis=1)))]
        rise = np.sin(np.arctan2(self.setting.antenna_height, self.distance) + self.lean) / np.hypot(x, z)
        heels = np.arccos(np.clip(rise, -1.0, 1.0)) * np.array([1.0, -1.0]) - np.arctan2(x, z)
        heel = float(min((np.angle(np.exp(1j * heels))).tolist(), key=abs))
        east, north, _ = starboard_down(heel) @ [x, y, z]
        return replace(self, heading=np.pi - float(np.arctan2(east, north)) - self.turn, heel=heel)

    @property
    def position(self) -> Floats:
        """Of its origin (3,), about the foot of the antenna [m]."""
        return np.array([0.0, self.distance, 0.0])

    @property
    def rotation(self) -> Floats:
        """From its own frame to the map (3, 3)."""
        return turned_to(self.heading) @ starboard_down(self.heel)

    @property
    def unit(self) -> float:
        """Root of what a plate of its length and a fifth of its height returns along its normal [m]."""
        return float(np.sqrt(4.0 * np.pi) * self.table["length_m"] * 0.2 * self.table["height_m"] / self.setting.wavelength)

    def body(self, dented: bool = True) -> dict[str, Any]:
        """Of a scene file."""
        flat = {} if dented else {"plating": {"dent_m": 0.0}}
        pose = {"position_m": self.position.tolist(), "heading_deg": float(np.rad2deg(self.heading)) % 360.0}
        return {"name": "hull", **self.table, **pose, "list_deg": float(np.rad2deg(self.heel)), **flat}


def drawn_hull(seed: int, facing: bool = False) -> Hull:
    """Hull number `seed`, to be `posed`. facing: its largest wall faces the antenna, over no sea."""
    rng = np.random.default_rng((73, seed))
    length = log_uniform(rng, 9.0, 30.0)
    table = {
        "shape": "hull", "hull_type": TYPES[seed % len(TYPES)], "length_m": length, "beam_m": length * rng.uniform(0.24, 0.36),
        "height_m": length * rng.uniform(0.25, 0.4), "scattering": "optics",
        "plating": {"dent_m": rng.uniform(0.002, 0.008), "frame_m": rng.uniform(0.6, 0.8),
                    "panel_height_m": rng.uniform(1.5, 3.0), "seed": seed},
    }  # fmt: skip
    table |= {"hull_seed": seed} if table["hull_type"] != "plain" else {}
    sea = bool(rng.uniform() < 0.7) and not facing
    setting = Setting(polarization=str(rng.choice(["h", "v"])), sea=sea, sea_state=int(rng.integers(0, 4)) if sea else 0,
                      antenna_height=float(rng.uniform(8.0, 25.0)))  # fmt: skip
    distance, near = float(rng.uniform(700.0, 2500.0)), bool(rng.uniform() < NEAR) or facing
    heading, heel = rng.uniform(0.0, 2.0 * np.pi), np.deg2rad(rng.uniform(-1.0, 1.0) * MAX_LIST)
    turn, lean = np.deg2rad(rng.uniform(-1.0, 1.0, 2) * [MAX_TURN, MAX_LEAN]) * (not facing)
    return Hull(table, distance, float(turn), float(lean), near, heading, heel, setting)


def fields(hull: Hull, triangles: Floats, dents: Dents) -> tuple[complex, complex]:
    """Roots of the effective cross-sections [m] of a hull and of the same one without dents, with phases about its origin.

    triangles: (F, 3, 3) in its own frame [m]."""
    posed, setting = triangles @ hull.rotation.T + hull.position, hull.setting
    shading = np.array([part for face in posed for part in _fan(oracle.dry(face))])
    legs = (False, True)[: 1 + setting.sea]
    shades = [_picture(shading.reshape(-1, 3), setting, by_sea) for by_sea in legs]
    parts = _parts(hull, posed, plated_walls(triangles, hull.table["plating"]["frame_m"]))
    dented = flat = 0j
    while len(parts.quad):
        elements, owner = _elements(parts, setting)
        clear = np.array([_unshaded(elements.position, *shade, setting, by) for shade, by in zip(shades, legs, strict=True)])
        there = np.array([np.bincount(owner, each, len(parts.quad)) for each in clear])
        mixed = ((there > 0) & (there < np.bincount(owner))).any(axis=0) & parts.large
        kept = ~mixed[owner] & clear.any(axis=0)
        elements, owner, clear = oracle.Elements(*(part[kept] for part in elements)), owner[kept], clear[:, kept]
        flat += _sum(elements, clear, setting)
        dented += _sum(_dented(elements, parts, owner, hull, dents), clear, setting)
        parts = parts.chosen(np.flatnonzero(mixed)).quarters
    slant = oracle.slant_range(hull.position, setting)
    unit = slant**2 * complex(np.exp(2j * setting.wavenumber * slant))
    return dented * unit, flat * unit


def plated_walls(triangles: Floats, frame: float) -> Indices:
    """Which of four ways each wall faces (F,), -1 of what has no plating: flat patches within 30 degrees of upright that are
    longer than two panels and higher than frames are apart. Sides along the hull are 2 and 3, across it 0 and 1."""
    normal = _normals(triangles)
    keys = np.round(triangles, 9) + 0.0
    _, corner = np.unique(keys.reshape(-1, 3), axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    owners: dict[tuple[int, int], list[int]] = {}
    for number, ring in enumerate(corner.tolist()):
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True):
            owners.setdefault((min(a, b), max(a, b)), []).append(number)
    pairs = [(a, b) for edge in owners.values() for a in edge for b in edge if a < b]
    ends = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    ends = ends[np.linalg.norm(np.cross(normal[ends[:, 0]], normal[ends[:, 1]]), axis=1) < COPLANAR]
    count, patch = connected_components(coo_array((np.ones(len(ends)), ends.T), shape=(len(normal),) * 2), directed=False)
    result = np.full(len(normal), -1)
    for number in range(count):
        of_patch = patch == number
        long, wide, high = np.ptp(triangles[of_patch].reshape(-1, 3), axis=0)
        if np.hypot(long, wide) > 2.0 * frame and high > frame:
            result[of_patch] = np.where(np.abs(normal[of_patch, 2]) < 0.5, 0, -1)
    sideways = np.abs(normal[:, 0]) >= np.abs(normal[:, 1])
    way = np.where(sideways, 2 + (normal[:, 0] > 0.0), normal[:, 1] > 0.0)
    return np.where(result < 0, -1, way)


def _normals(triangles: Floats) -> Floats:
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


class _Parts(NamedTuple):
    """Quadrangles (P, 4, 3) of faces on the map [m], normals (P, 3) of the faces, and which way each faces as a plated wall (P,),
    -1: it is none.

    phase: (P,) that dents may add [rad]. least: nodes along each edge at least.
    """

    quad: Floats
    normal: Floats
    wall: Indices
    phase: Floats
    least: int = 6

    @property
    def large(self) -> np.ndarray:
        """Whether the edge of a shadow across each matters (P,)."""
        return np.linalg.norm(np.diff(self.quad, axis=1), axis=2).max(axis=1) > FINEST

    def chosen(self, which: Indices) -> "_Parts":
        """The parts `which`."""
        return _Parts(self.quad[which], self.normal[which], self.wall[which], self.phase[which], self.least)

    @property
    def quarters(self) -> "_Parts":
        """The four quarters of each."""
        a, b, c, d = self.quad.transpose(1, 0, 2)
        ab, bc, cd, da, middle = (a + b) / 2.0, (b + c) / 2.0, (c + d) / 2.0, (d + a) / 2.0, self.quad.mean(axis=1)
        quads = ((a, ab, middle, da), (ab, b, bc, middle), (middle, bc, c, cd), (da, middle, cd, d))
        whole = self.chosen(np.tile(np.arange(len(self.quad)), 4))
        return whole._replace(quad=np.concatenate([np.stack(quad, axis=1) for quad in quads]), least=3)


def _parts(hull: Hull, posed: Floats, wall: Indices) -> _Parts:
    """The quadrangles of the faces that may be lit; of plated ones between two frames and two tiers each."""
    plating, quads, faces = hull.table["plating"], [np.zeros((0, 4, 3))], list[int]()
    across, ahead, up = hull.rotation.T
    for number in np.flatnonzero(_may_be_lit(posed, hull.setting)).tolist():
        polygons = _slices([oracle.dry(posed[number]) - hull.position], np.array([0.0, 1.0, 0.0]), SLICE, 0.0)
        if (way := wall[number]) >= 0:
            polygons = _slices(polygons, ahead if way >= 2 else across, plating["frame_m"], 0.0)
            polygons = _slices(polygons, up, plating["panel_height_m"], 0.5)
        some = [quad + hull.position for polygon in polygons for quad in oracle.quadrangles(polygon)]
        quads.append(np.array(some).reshape(-1, 4, 3))
        faces += [number] * len(some)
    phase = np.where(wall[faces] >= 0, 4.0 * hull.setting.wavenumber * plating["dent_m"], 0.0)
    return _Parts(np.concatenate(quads), _normals(posed)[faces], wall[faces], phase)


def _may_be_lit(posed: Floats, setting: Setting) -> np.ndarray:
    """Whether any ray comes from before the outer side of each face (F,), tried at its corners, with a margin."""
    corners = np.maximum(posed.reshape(-1, 3), [-np.inf, -np.inf, 1e-3])
    azimuth, normal = np.arctan2(corners[:, 0], corners[:, 1]), np.repeat(_normals(posed), 3, axis=0)
    along = normal[:, 0] * np.sin(azimuth) + normal[:, 1] * np.cos(azimuth)
    rays = [oracle.direct_rays(corners, setting), *([oracle.sea_rays(corners, setting)] if setting.sea else [])]
    return np.any([ray.level * along + ray.rise * normal[:, 2] < 1e-2 for ray in rays], axis=0).reshape(-1, 3).any(axis=1)


def _elements(parts: _Parts, setting: Setting) -> tuple[oracle.Elements, Indices]:
    """Elements of all parts, and the part of each (M,). Rays are level within 40 mrad, and northward within 20."""
    a, b, c, d = parts.quad.transpose(1, 0, 2)
    corners = [np.einsum("pi,pi->p", np.cross(one, other), parts.normal)
               for one, other in ((b - a, d - a), (b - a, c - b), (c - d, c - b), (c - d, d - a))]  # fmt: skip
    counts = []
    for edges in (np.stack([b - a, c - d]), np.stack([d - a, c - b])):
        along = np.abs(edges[..., 1]) + 0.04 * np.abs(edges[..., 2]) + 0.02 * np.abs(edges[..., 0])
        phase = 2.0 * setting.wavenumber * along.max(axis=0) + parts.phase
        panels = (phase / PANEL).astype(int) + 1
        counts += [panels, 2 * np.ceil(phase / panels / 8.0).astype(int) + parts.least]
    kinds, which = np.unique(np.stack(counts, axis=1), axis=0, return_inverse=True)
    position, area, owner = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, dtype=np.int64)]
    for number, (n, order, m, other) in enumerate(kinds.tolist()):
        some = np.flatnonzero(which.ravel() == number)
        (s, weight), (t, weight_t) = oracle.gauss(n, order), oracle.gauss(m, other)
        s, t, weight = np.repeat(s, len(t)), np.tile(t, len(s)), np.repeat(weight, len(t)) * np.tile(weight_t, len(s))
        shares = np.stack([(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t], axis=1)
        position.append(np.einsum("kc,pci->pki", shares, parts.quad[some]).reshape(-1, 3))
        size = weight * np.einsum("kc,cp->pk", shares, np.array(corners)[:, some])  # linear over a flat quadrangle
        area.append((size[..., None] * parts.normal[some, None]).reshape(-1, 3))
        owner.append(np.repeat(some, len(s)))
    where = np.concatenate(position)
    return oracle.Elements(where, np.concatenate(area), np.zeros((len(where), 0, 3))), np.concatenate(owner)


def _dented(elements: oracle.Elements, parts: _Parts, owner: Indices, hull: Hull, dents: Dents) -> oracle.Elements:
    """Elements where their dents have them; owner: the part of each (M,)."""
    plated = np.flatnonzero(parts.wall[owner] >= 0)
    position, of = elements.position.copy(), owner[plated]
    own = (position[plated] - hull.position) @ hull.rotation
    position[plated] -= _depths(own, parts.wall[of], hull.table["plating"], dents)[:, None] * parts.normal[of]
    return elements._replace(position=position)


def _sum(elements: oracle.Elements, clear: np.ndarray, setting: Setting) -> complex:
    """What elements (M,) return, each where legs (1 or 2, M) reach it."""
    total = 0j
    for start, part in zip(range(0, clear.shape[1], CHUNK), oracle.chunks(elements, CHUNK), strict=True):
        direct, other = clear[0, start : start + CHUNK], clear[-1, start : start + CHUNK]
        returned = oracle.contributions(part, False, setting)
        total += complex((returned.amplitude * np.stack([direct, direct & other, other])).sum())
    return total


def _depths(own: Floats, way: Indices, plating: dict[str, float], dents: Dents) -> Floats:
    """By how much plating lies inward (M,) at points (M, 3) of walls (M,), in the hull's own frame [m]."""
    share, height = (
        np.where(way >= 2, own[:, 1], own[:, 0]) / plating["frame_m"],
        own[:, 2] / plating["panel_height_m"] - 0.5,
    )
    bay, tier = np.floor(share).astype(int) - dents.first[0], np.floor(height).astype(int) - dents.first[1]
    rest = height - np.floor(height)
    depth = (1.0 - rest) * dents.depths[way, bay, tier] + rest * dents.depths[way, bay, tier + 1]
    return np.asarray(depth * np.sin(np.pi * share) ** 2)


def _slices(polygons: list[Floats], way: Floats, size: float, offset: float) -> list[Floats]:
    """Polygons (V, 3) cut where their coordinate along a unit vector is (n + offset) size [m]."""
    result = []
    for polygon in polygons:
        if not len(polygon):
            continue
        at = polygon @ way / size - offset
        first, last = int(np.floor(at.min() + 1e-9)), int(np.ceil(at.max() - 1e-9))
        for number in range(first, max(last, first + 1)):
            part = oracle.clipped(polygon, at - number)
            part = oracle.clipped(part, number + 1 - (part @ way / size - offset)) if len(part) else part
            if len(part) > 2:
                result.append(part)
    return result


def _fan(polygon: Floats) -> list[Floats]:
    """Triangles (3, 3) of a convex polygon (V, 3)."""
    return [polygon[[0, n, n + 1]] for n in range(1, len(polygon) - 1)]


def _picture(points: Floats, setting: Setting, by_sea: bool) -> tuple[Floats, Floats]:
    """Triangles (T, 3, 2) in a picture as `cast_shadows` has it, of those with corners (3 T, 3) that face the antenna, and the
    inverse distances ahead of their corners (T, 3) [1/m]."""
    at = homogeneous(points, np.array([0.0, 1.0]), setting, by_sea)
    flat, nearness = (at[:, :2] / at[:, 2:]).reshape(-1, 3, 2), (1.0 / at[:, 2]).reshape(-1, 3)
    b, c = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]) * (-1.0 if by_sea else 1.0)
    facing = area > 1e-14  # of a picture: 1 mm by 10 mm at 1 km is 1e-11
    return flat[facing], nearness[facing]


def _unshaded(points: Floats, triangles: Floats, nearness: Floats, setting: Setting, by_sea: bool) -> np.ndarray:
    """Whether no triangle stands between the antenna and each point (M, 3); triangles, nearness: of `_picture`."""
    at = homogeneous(points, np.array([0.0, 1.0]), setting, by_sea)
    order = np.argsort(at[:, 0] / at[:, 2])
    u, v, near = at[order, 0] / at[order, 2], at[order, 1] / at[order, 2], 1.0 / at[order, 2]
    clear = np.ones(len(points), dtype=bool)
    for corners, inverse in zip(triangles, nearness, strict=True):
        low, high = corners.min(axis=0), corners.max(axis=0)
        first, last = np.searchsorted(u, [low[0], high[0]])
        some = first + np.flatnonzero((v[first:last] >= low[1]) & (v[first:last] <= high[1]) & clear[first:last])
        if not len(some):
            continue
        a, (b, c) = corners[0], corners[1:] - corners[0]
        x, y = u[some] - a[0], v[some] - a[1]
        area = b[0] * c[1] - b[1] * c[0]
        second, third = (x * c[1] - y * c[0]) / area, (b[0] * y - b[1] * x) / area
        inside = (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0)
        there = inverse[0] + second * (inverse[1] - inverse[0]) + third * (inverse[2] - inverse[0])
        clear[some[inside & (there > near[some] * (1.0 + AHEAD))]] = False
    result = np.empty(len(points), dtype=bool)
    result[order] = clear
    return result
