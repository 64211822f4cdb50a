"""Hulls of several types as closed meshes: flared sides, superstructure, masts and rails, drawn about proportions by a seed.

The frame is that of `world.shapes`: y ahead, z up from the waterline at 0. Each part is closed, and reaches a little into what it
stands on: no two facets coincide. Walls and bars lean by drawn angles: exact corners of this size return far more than ships do.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from radar_service.numerics import Floats, Indices
from radar_service.world.body import Mesh
from radar_service.world.shapes import hull, loft

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
        self._add(_prism(np.column_stack([foot, np.full(4, low)]), np.column_stack([top, np.full(4, high)])))

    def bar(self, foot: Floats, top: Floats, half: float = BAR, sides: int = 4) -> None:
        """A bar of regular section from foot to top (3,) [m], turned about its axis as drawn. half: its radius [m]."""
        along = (top - foot) / np.linalg.norm(top - foot)
        across = np.cross(along, [1.0, 0.0, 0.0] if abs(along[0]) < 0.8 else [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        turn = 2.0 * np.pi * (np.arange(sides) + self.rng.uniform()) / sides
        ring = half * (np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * np.cross(along, across))
        self._add(_prism(foot + ring, top + ring))

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


def _prism(foot: Floats, top: Floats) -> Mesh:
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
