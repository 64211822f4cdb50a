"""Built-in shapes as triangle meshes in their own frame: heading 0, x east, y north (ahead), z up; normals face outward.

The origin is the centre of sphere and plate, the apex of the trihedral, the middle of the dihedral's fold, and the foot of
box, cylinder and hull (docs/scenes.md#shapes). A plate faces +y; dihedral and trihedral open toward +y, axis of symmetry
level.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from radar_service.numerics import Floats, Indices
from radar_service.world.body import Mesh

SAG = 0.004  # m between facet and curve: an eighth of an X-band wavelength, Rayleigh's limit for a smooth surface
_MAX_SPLITS = 6  # 81 920 triangles
_MAX_SIDES = 2048
_MAX_FINE_SIDES = 4096  # of a cylinder of a given sag: at 1/400 wavelength enough for radii up to 7600 wavelengths
# A sphere with n parts to an edge of the icosahedron has 20 n^2 triangles, which sag by at most 0.292 r / n^2.
_PARTS_SAG = 0.292
_MIN_PARTS, _MAX_PARTS = 4, 80  # 80: 1/300 wavelength up to a radius of 73 wavelengths, 1/100 up to 219


def shape_mesh(shape: str, sizes: dict[str, float], sag: float | None = None) -> Mesh:
    """Returns the mesh of a built-in shape; sizes [m] have the names of the scene file (`radius_m`, ...).

    sag: how far facets may be off the curves of a sphere or a cylinder [m], as a scattering model wants them; None: SAG.
    """
    plain = {key.removesuffix("_m"): value for key, value in sizes.items()}
    if sag is not None and shape == "sphere":
        return fine_sphere(plain["radius"], sag)
    if sag is not None and shape == "cylinder":
        return cylinder(**plain, sag=sag, max_sides=_MAX_FINE_SIDES)
    return SHAPES[shape](**plain)


def sphere(radius: float, sag: float = SAG) -> Mesh:
    """Returns an icosphere about the origin: facets within `sag` [m] of the sphere, at most 81 920 of them."""
    longest = 1.05 * 1.26 * radius  # edge of the icosahedron, and its unevenness after splitting
    splits = math.ceil(math.log2(longest / math.sqrt(6.0 * radius * sag)))  # a triangle of edge e sags by e^2 / (6 r)
    vertices, faces = _icosahedron()
    for _ in range(min(max(splits, 2), _MAX_SPLITS)):
        vertices, faces = _split(vertices, faces)
    return Mesh(radius * vertices, faces, solid=True)


def fine_sphere(radius: float, sag: float) -> Mesh:
    """Returns a sphere about the origin: facets within `sag` [m] of it, and no more of them than needed, at most 128,000."""
    parts = math.ceil(min(max(math.sqrt(_PARTS_SAG * radius / sag), _MIN_PARTS), _MAX_PARTS))
    vertices, faces = _divided(*_icosahedron(), parts)
    return Mesh(radius * vertices, faces, solid=True)


def _divided(vertices: Floats, faces: Indices, parts: int) -> tuple[Floats, Indices]:
    """Divides each edge into parts and each face into parts^2, with all vertices on the unit sphere."""
    index = {(i, j): number for number, (i, j) in enumerate((i, j) for i in range(parts + 1) for j in range(parts + 1 - i))}
    upright = [(index[i, j], index[i + 1, j], index[i, j + 1]) for i, j in index if i + j < parts]
    turned = [(index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]) for i, j in index if i + j < parts - 1]
    share = np.array([(parts - i - j, i, j) for i, j in index]) / parts
    points = (share @ vertices[faces]).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    parted = np.array(upright + turned) + len(index) * np.arange(len(faces))[:, None, None]
    _, first, same = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return points[first], same.reshape(-1)[parted.reshape(-1, 3)]


def _icosahedron() -> tuple[Floats, Indices]:
    g = (1.0 + math.sqrt(5.0)) / 2.0
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
               (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]  # fmt: skip
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]  # fmt: skip
    return np.array(corners, dtype=np.float64) / math.hypot(1.0, g), np.array(faces, dtype=np.int64)


def _split(vertices: Floats, faces: Indices) -> tuple[Floats, Indices]:
    """Splits each face into four, with new vertices on the unit sphere."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, middle = np.unique(edges, axis=0, return_inverse=True)
    points = vertices[unique].sum(axis=1)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    ab, bc, ca = (middle.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.concatenate([vertices, points]), np.concatenate([np.stack(part, axis=1) for part in parts])


def plate(width: float, height: float) -> Mesh:
    """Returns a vertical sheet about the origin with normal +y: width along x, height along z [m]."""
    w, h = width / 2.0, height / 2.0
    return _mesh([(w, 0, -h), (-w, 0, -h), (-w, 0, h), (w, 0, h)], [(0, 1, 2), (0, 2, 3)])


def box(length: float, width: float, height: float) -> Mesh:
    """Returns a closed box above the origin, length along y, width along x [m]."""
    x, y = width / 2.0, length / 2.0
    ring = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return _prism(np.array(ring), height)


def cylinder(radius: float, height: float, sag: float = SAG, max_sides: int = _MAX_SIDES) -> Mesh:
    """Returns a closed vertical cylinder above the origin: sides within `sag` [m] of the curve, at most `max_sides`."""
    sides = 4 * math.ceil(min(max(2.0 * math.pi * math.sqrt(radius / (8.0 * sag)), 16.0), max_sides) / 4.0)
    turn = np.arange(sides) * (2.0 * np.pi / sides)
    return _prism(radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), height)


def _prism(ring: Floats, height: float) -> Mesh:
    """Returns a vertical prism over a convex counter-clockwise ring (n, 2), with the middle of each end as a vertex."""
    n = len(ring)
    middle = ring.mean(axis=0)
    foot = np.column_stack([ring, np.zeros(n)])
    vertices = np.concatenate([foot, foot + (0, 0, height), [[*middle, 0.0], [*middle, height]]])
    i = np.arange(n)
    j = (i + 1) % n
    parts = [(i, j, j + n), (i, j + n, i + n), (j, i, np.full(n, 2 * n)), (i + n, j + n, np.full(n, 2 * n + 1))]
    return Mesh(vertices, np.concatenate([np.stack(part, axis=1) for part in parts]).astype(np.int64), solid=True)


def dihedral(width: float, height: float) -> Mesh:
    """Returns two vertical plates at a right angle, each width x height [m], open toward +y; the origin is in their fold."""
    s, h = width / math.sqrt(2.0), height / 2.0
    corners = [(0, 0, -h), (0, 0, h), (s, s, -h), (s, s, h), (-s, s, -h), (-s, s, h)]
    return _mesh(corners, [(2, 0, 1), (2, 1, 3), (0, 4, 5), (0, 5, 1)])


def trihedral(edge: float) -> Mesh:
    """Returns three perpendicular right triangles with legs `edge` [m], apex in the origin, axis of symmetry along +y."""
    y, up, side = 1.0 / math.sqrt(3.0), 1.0 / math.sqrt(6.0), 1.0 / math.sqrt(2.0)
    edges = [(0.0, y, 2.0 * up), (side, y, -up), (-side, y, -up)]  # right-handed: each normal is the third leg
    corners = [(0.0, 0.0, 0.0), *(tuple(edge * c for c in edge_end) for edge_end in edges)]
    return _mesh(corners, [(0, 1, 2), (0, 2, 3), (0, 3, 1)])


# Half breadth of deck and bottom, as shares of half the beam, along the ship from transom (-1) to bow (1), of a typical
# ship: a full stern, a parallel middle body, a flared bow with a raked stem.
_STATIONS = ((-1.0, 0.86, 0.70), (-0.8, 0.95, 0.84), (-0.5, 1.0, 0.92), (-0.45, 1.0, 0.93), (0.2, 1.0, 0.92),
             (0.45, 0.95, 0.80), (0.65, 0.80, 0.56), (0.80, 0.58, 0.32), (0.92, 0.30, 0.12), (1.0, 0.0, 0.0))  # fmt: skip
_HOUSE = (1, 2)  # the deckhouse stands between these stations
_HOUSE_BREADTH = 0.8  # of the beam
_DECK = 0.45  # height of the deck, of the whole height
_RAKE = 0.08  # the foot of the stem lies this share of half the length abaft the bow


def hull(length: float, beam: float, height: float) -> Mesh:
    """Returns a closed hull with a deckhouse aft: length along y (bow ahead), height from keel to house top [m]."""
    rings = []
    first, last = _HOUSE
    for k, (_, deck, _) in enumerate(_STATIONS):
        low, high = min(_HOUSE_BREADTH, deck), height
        if k == first:
            rings.append(_section(k, low, _DECK * height, length, beam, height))
        rings.append(_section(k, low, high if first <= k <= last else _DECK * height, length, beam, height))
        if k == last:
            rings.append(_section(k, low, _DECK * height, length, beam, height))
    return loft(np.array(rings))


def _section(k: int, house: float, top: float, length: float, beam: float, height: float) -> Floats:
    """Returns one ring (8, 3) of the hull: bottom, deck edge, foot and top of the house, starboard, then port."""
    along, deck, bottom = _STATIONS[k]
    y, foot = along * length / 2.0, ((along + 1.0) * (1.0 - _RAKE / 2.0) - 1.0) * length / 2.0
    b, d, h, z = bottom * beam / 2.0, deck * beam / 2.0, house * beam / 2.0, _DECK * height
    starboard = [(b, foot, 0.0), (d, y, z), (h, y, z), (h, y, top)]
    return np.array(starboard + [(-p[0], p[1], p[2]) for p in reversed(starboard)])


def loft(rings: Floats) -> Mesh:
    """Returns the closed surface over rings (s, n, 3) that are counter-clockwise seen from ahead, with caps at both ends."""
    s, n, _ = rings.shape
    k, i = np.meshgrid(np.arange(s - 1) * n, np.arange(n), indexing="ij")
    a, b = (k + i).ravel(), (k + (i + 1) % n).ravel()
    skin = np.concatenate([np.stack([a, b + n, b], axis=1), np.stack([a, a + n, b + n], axis=1)])
    fan = np.stack([np.zeros(n - 2, dtype=np.int64), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    bow = (s - 1) * n + fan[:, ::-1]
    return _merged(rings.reshape(-1, 3), np.concatenate([skin, fan, bow]))


def _merged(vertices: Floats, faces: Indices) -> Mesh:
    """Returns the closed mesh with equal vertices merged, without faces without area."""
    unique, index = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # + 0.0: -0.0 and 0.0 are the same coordinate
    faces = index.reshape(-1)[faces]
    a, b, c = unique[faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(unique, faces[area > 0.0].astype(np.int64), solid=True)


def _mesh(vertices: Sequence[tuple[float, ...]], faces: list[tuple[int, int, int]]) -> Mesh:
    return Mesh(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int64))


SHAPES: dict[str, Callable[..., Mesh]] = {
    "sphere": sphere,
    "plate": plate,
    "box": box,
    "cylinder": cylinder,
    "dihedral": dihedral,
    "trihedral": trihedral,
    "hull": hull,
}


# Hulls of other types than `plain` have flared sides, superstructure, masts and rails, drawn about proportions by a seed.
# Each of their parts is closed, and reaches a little into what it stands on: no two facets coincide. Walls and bars lean by
# drawn angles: exact corners of this size return far more than ships do.
SUNK = 0.03  # m by which a part reaches into what it stands on
BAR = 0.02  # m, half the width of rails
POLE = 0.0012  # of the length, that half the width of poles is more
KEEL = 0.75  # breadth of the bottom over that of the waterline: of no account for echoes
# Walls lean by up to half a degree on a ship of 100 m, and more on smaller ones, as echoes of ships ask (docs/accuracy.md).
LEAN_DEG, LEAN_LENGTH, LEAN_POWER = 0.5, 100.0, 0.75
MAX_TAPER = 0.2  # of the width of a block that two of its walls may lean inward together
# Along the ship from transom (-1) to stem (1): half breadths of the deck and of the waterline, as shares of half the beam.
Stations = tuple[tuple[float, float, float], ...]
SHIP: Stations = ((-1.0, 0.88, 0.78), (-0.75, 0.97, 0.93), (-0.4, 1.0, 0.995), (0.35, 1.0, 0.995), (0.6, 0.93, 0.80),
                  (0.78, 0.74, 0.50), (0.92, 0.40, 0.16), (1.0, 0.02, 0.01))  # fmt: skip
BOAT: Stations = ((-1.0, 0.86, 0.74), (-0.4, 0.98, 0.88), (0.1, 1.0, 0.88), (0.45, 0.88, 0.64), (0.78, 0.52, 0.24),
                  (1.0, 0.02, 0.01))  # fmt: skip
Span = tuple[float, float]


@dataclass
class _Drawing:
    """Parts of one ship. length, beam: of its deck [m]; deck, roof: heights above the waterline [m]; rng: draws.

    Places are shares of half the beam (x) and of half the length (y), and heights [m].
    """

    length: float
    beam: float
    deck: float
    roof: float
    stations: Stations
    rng: Generator
    vertices: list[Floats] = field(default_factory=list)
    faces: list[Indices] = field(default_factory=list)

    @property
    def pole_half(self) -> float:
        """Half the width of a pole [m]."""
        return BAR + POLE * self.length

    @property
    def lean(self) -> float:
        """The largest angle by which a wall of a house is off upright [rad]."""
        return float(math.radians(LEAN_DEG) * (LEAN_LENGTH / self.length) ** LEAN_POWER)

    def near(self, value: float, spread: float = 0.1) -> float:
        """A value drawn within a share of it."""
        return value * (1.0 + spread * float(self.rng.uniform(-1.0, 1.0)))

    def shell(self, draught: float, rake: float, sheer: float) -> None:
        """The hull from keel to deck. rake: by which the stem leans ahead from waterline to deck, over the height of the deck;
        sheer: by which the deck rises to the stem, likewise."""
        rings = []
        for along, deck, water in self.stations:
            ahead = max(along, 0.0) ** 2
            y, top = along * self.length / 2.0, self.deck * (1.0 + sheer * ahead)
            foot = y - rake * self.deck * ahead
            starboard = [(KEEL * water, foot, -draught), (water, foot, 0.0), (deck, y, top)]
            half = self.beam / 2.0
            sides = [(half * x, y, z) for x, y, z in starboard]
            rings.append([*sides, *((-x, y, z) for x, y, z in reversed(sides))])
        self._add(loft(np.array(rings)))

    def block(self, x: Span, y: Span, z: Span, lean: float = 1.0) -> None:
        """A house, hatch or locker. Each wall leans inward by a drawn angle, 0.25 to 1 of `lean` times that of houses."""
        low, high = z[0] - SUNK, z[1]
        (left, right), (aft, fore) = np.array(x) * self.beam / 2.0, np.array(y) * self.length / 2.0
        inward = np.tan(lean * self.lean * self.rng.uniform(0.25, 1.0, 4)) * (high - low)
        inward = np.minimum(inward, MAX_TAPER * np.repeat([right - left, fore - aft], 2) / 2.0)
        foot = np.array([[left, aft], [right, aft], [right, fore], [left, fore]])
        port, starboard, astern, ahead = inward
        top = foot + [[port, astern], [-starboard, astern], [-starboard, -ahead], [port, -ahead]]
        self._add(_frustum(np.column_stack([foot, np.full(4, low)]), np.column_stack([top, np.full(4, high)])))

    def bar(self, foot: Floats, top: Floats, half: float = BAR, sides: int = 4) -> None:
        """A bar of regular section from foot to top (3,) [m], turned about its axis as drawn. half: its radius [m]."""
        along = (top - foot) / np.linalg.norm(top - foot)
        across = np.cross(along, [1.0, 0.0, 0.0] if abs(along[0]) < 0.8 else [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        turn = 2.0 * np.pi * (np.arange(sides) + self.rng.uniform()) / sides
        ring = half * (np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * np.cross(along, across))
        self._add(_frustum(foot + ring, top + ring))

    def pole(self, x: float, y: float, z: Span, half: float | None = None, lean: float = 2.0) -> None:
        """A pole that is off upright by a draw about `lean` [degrees]. half: its radius [m]; None: `pole_half`."""
        high = z[1] - z[0]
        off = math.tan(math.radians(self.near(lean, 0.5))) * high
        way = self.rng.uniform(0.0, 2.0 * np.pi)
        foot = np.array([x * self.beam / 2.0, y * self.length / 2.0, z[0] - SUNK])
        self.bar(foot, foot + [off * math.cos(way), off * math.sin(way), high + SUNK], half or self.pole_half, 8)

    def rails(self, y: Span, count: int) -> None:
        """Stanchions inside the edge of the deck at both sides, with a rail on their heads at each side."""
        high = min(1.1, 0.06 * self.length)
        along, edge, _ = np.array(self.stations).T
        for side in (-1.0, 1.0):
            heads = []
            for share in np.linspace(*y, count):
                half = 0.96 * float(np.interp(share, along, edge)) * self.beam / 2.0
                lean = np.tan(np.deg2rad(2.0 * self.rng.standard_normal(2))) * high
                foot = np.array([side * half, share * self.length / 2.0, self.deck - SUNK])
                heads.append(foot + [lean[0] - side * BAR, lean[1], high + SUNK])
                self.bar(foot, heads[-1])
            for begin, end in zip(heads[:-1], heads[1:], strict=True):
                self.bar(begin + [0.0, 0.01, BAR], end + [0.0, -0.01, BAR])

    def mesh(self) -> Mesh:
        """All parts."""
        return Mesh(np.concatenate(self.vertices), np.concatenate(self.faces))

    def _add(self, part: Mesh) -> None:
        self.faces.append(part.faces + sum(map(len, self.vertices)))
        self.vertices.append(part.vertices)


def _frustum(foot: Floats, top: Floats) -> Mesh:
    """A closed prism between convex rings (n, 3), counter-clockwise seen from the top."""
    n = len(foot)
    i = np.arange(n)
    j = (i + 1) % n
    fan = np.stack([np.zeros(n - 2, dtype=np.int64), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    sides = [np.stack([i, j, j + n], axis=1), np.stack([i, j + n, i + n], axis=1)]
    return Mesh(np.concatenate([foot, top]), np.concatenate([*sides, fan[:, ::-1], fan + n]).astype(np.int64))


def _cargo(ship: _Drawing) -> None:
    """House and funnel aft, hatches, a mast on either end, a crane or two."""
    deck, roof = ship.deck, ship.roof
    tier = (roof - deck) / 4.0
    front = ship.near(-0.66)
    ship.block((-0.86, 0.86), (-0.92, front), (deck, roof - tier))
    ship.block((-0.62, 0.62), (-0.86, front - 0.03), (roof - tier, roof))
    ship.block((-0.98, 0.98), (front - 0.09, front - 0.05), (roof - 0.7 * tier, roof - 0.3 * tier), 2.0)
    ship.block((-0.22, 0.22), (-0.91, -0.85), (roof - tier, ship.near(1.1 * roof)), 2.0)
    ship.pole(0.0, front - 0.08, (roof, ship.near(1.4 * roof)))
    ship.pole(0.0, 0.84, (deck, ship.near(roof)))
    count, high = int(ship.rng.integers(2, 5)), ship.near(0.12 * roof)
    edges = np.linspace(front + 0.05, 0.62, count + 1)
    for aft, fore in zip(edges[:-1], edges[1:], strict=True):
        ship.block((-0.62, 0.62), (aft + 0.03, fore - 0.03), (deck, deck + high))
        side = float(ship.rng.choice([-1.0, 1.0]))
        ship.block((side * 0.72 - 0.07, side * 0.72 + 0.07), (fore - 0.02, fore + 0.02), (deck, deck + 1.2 * high), 2.0)
    for aft in edges[1:-1:2]:
        ship.pole(0.0, float(aft), (deck, ship.near(0.9 * roof)), 3.0 * ship.pole_half)
    ship.block((-0.2, 0.2), (0.72, 0.77), (deck, deck + 0.7 * high), 2.0)
    ship.rails((-0.98, -0.6), 5)


def _ferry(ship: _Drawing) -> None:
    """A house nearly all along, a wheelhouse with wings ahead, funnels aft, boats at its sides."""
    deck, roof = ship.deck, ship.roof
    tier, aft, fore = (roof - deck) / 3.0, ship.near(-0.8), ship.near(0.55)
    ship.block((-0.92, 0.92), (aft, fore), (deck, deck + 2.0 * tier))
    ship.block((-0.6, 0.6), (fore - 0.3, fore - 0.06), (deck + 2.0 * tier, roof), 2.0)
    ship.block((-0.99, 0.99), (fore - 0.14, fore - 0.1), (roof - 0.7 * tier, roof - 0.3 * tier), 2.0)
    for side in (-0.45, 0.45):
        ship.block((side - 0.12, side + 0.12), (aft + 0.1, aft + 0.2), (deck + 2.0 * tier, ship.near(1.15 * roof)), 2.0)
    for place in np.linspace(aft + 0.35, fore - 0.5, 3):
        ship.block((-0.9, -0.74), (place, place + 0.12), (deck + 2.0 * tier, roof - 0.5 * tier), 2.0)
        ship.block((0.74, 0.9), (place, place + 0.12), (deck + 2.0 * tier, roof - 0.5 * tier), 2.0)
    ship.pole(0.0, fore - 0.2, (roof, ship.near(1.4 * roof)))
    ship.block((-0.3, 0.3), (fore + 0.08, fore + 0.14), (deck, deck + 0.4 * tier), 2.0)
    ship.pole(0.0, fore + 0.2, (deck, roof))
    ship.rails((-0.98, aft - 0.03), 3)


def _fishing(ship: _Drawing) -> None:
    """A wheelhouse ahead or aft, a gallows at the stern, winches, hatch and lockers, a mast."""
    deck, roof = ship.deck, ship.roof
    middle = 0.32 if ship.rng.uniform() < 0.6 else -0.5
    ship.block((-0.66, 0.66), (middle - 0.2, middle + 0.2), (deck, 0.5 * (deck + roof)))
    ship.block((-0.5, 0.5), (middle - 0.12, middle + 0.17), (0.5 * (deck + roof), roof))
    ship.pole(0.0, middle - 0.05, (roof, ship.near(1.7 * roof)))
    for side in (-0.7, 0.7):
        ship.pole(side, -0.9, (deck, ship.near(0.9 * roof, 0.03)), 1.5 * ship.pole_half)
        ship.block(
            (side * 0.55 - 0.1, side * 0.55 + 0.1), (middle + 0.25, middle + 0.31), (deck, deck + ship.near(0.2 * roof))
        )
    post = 0.35 * ship.beam
    ship.bar(np.array([-post, -0.45 * ship.length, 0.85 * roof]), np.array([post, -0.45 * ship.length, 0.86 * roof]),
             ship.pole_half)  # fmt: skip
    ahead = 0.0 if middle > 0.0 else 0.35
    ship.block((-0.3, 0.3), (ahead - 0.16, ahead - 0.02), (deck, deck + ship.near(0.2 * roof)))
    ship.block((-0.15, 0.5), (ahead - 0.4, ahead - 0.25), (deck, deck + ship.near(0.15 * roof)))
    ship.rails((-0.8, 0.7), 5)


def _yacht(ship: _Drawing) -> None:
    """A low cabin, a tall mast with a boom, stanchions all along."""
    deck, roof = ship.deck, ship.roof
    step = ship.near(0.12, 0.3)
    ship.block((-0.55, 0.55), (step - 0.5, step + 0.25), (deck, roof), 4.0)
    ship.pole(0.0, step, (roof, ship.near(1.25) * ship.length), 1.5 * ship.pole_half, 1.0)
    ship.bar(np.array([0.0, (step - 0.65) * ship.length / 2.0, roof + 0.9]),
             np.array([0.0, (step - 0.02) * ship.length / 2.0, roof + 0.8]), ship.pole_half)  # fmt: skip
    ship.rails((-0.95, 0.85), 7)


def _pilot(ship: _Drawing) -> None:
    """A wheelhouse amidships, a mast with gear on its roof, rails around the deck."""
    deck, roof = ship.deck, ship.roof
    middle = ship.near(0.08, 1.0)
    ship.block((-0.6, 0.6), (middle - 0.3, middle + 0.26), (deck, deck + 0.5 * (roof - deck)), 2.0)
    ship.block((-0.5, 0.5), (middle - 0.2, middle + 0.18), (deck + 0.5 * (roof - deck), roof), 4.0)
    ship.pole(0.0, middle - 0.1, (roof, ship.near(1.6 * roof)))
    ship.block((-0.2, 0.2), (middle - 0.16, middle - 0.12), (roof, ship.near(1.12 * roof)), 2.0)
    ship.rails((-0.9, 0.75), 6)


class _HullType(NamedTuple):
    """Proportions. deck: its height over that of the roof; draught: over the beam; rake, sheer: of stem and deck, over the
    height of the deck."""

    stations: Stations
    deck: float
    draught: float
    rake: float
    sheer: float
    draw: Callable[[_Drawing], None]


_TYPES = {
    "cargo": _HullType(SHIP, 0.32, 0.40, 0.8, 0.35, _cargo),
    "ferry": _HullType(SHIP, 0.45, 0.28, 0.8, 0.20, _ferry),
    "fishing": _HullType(BOAT, 0.38, 0.40, 0.7, 0.55, _fishing),
    "yacht": _HullType(BOAT, 0.62, 0.30, 0.9, 0.15, _yacht),
    "pilot": _HullType(BOAT, 0.42, 0.30, 1.0, 0.30, _pilot),
}
PLAIN = "plain"
HULL_TYPES = (PLAIN, *_TYPES)


def hull_mesh(hull_type: str, seed: int, length: float, beam: float, height: float) -> Mesh:
    """Returns a hull: length along y (bow ahead) and beam of the deck, height from the waterline to the roof of the house [m].

    hull_type: one of HULL_TYPES; `plain` is `shapes.hull`, whose foot is the waterline. seed: of the parts of the others, which
    reach below the waterline, and with masts above the roof.
    """
    from radar_service.numerics import HULL_PARTS, generator  # here: it needs scipy, and scene files only the names

    if hull_type == PLAIN:
        return hull(length, beam, height)
    kind = _TYPES[hull_type]
    rng = generator(seed, HULL_PARTS)
    ship = _Drawing(length, beam, kind.deck * height, height, kind.stations, rng)
    ship.shell(kind.draught * beam, kind.rake, kind.sheer)
    kind.draw(ship)
    return ship.mesh()
