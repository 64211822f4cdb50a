"""Parts of ships for `make_ships`: sheets, boxes, bars, and what of them makes a hull, a deckhouse, a mast, a hatch.

What returns radar waves from a ship over wide angles is not its smooth sides but the corners of its fittings: bulwarks
with stays, coamings, tiers of a deckhouse, wings, masts, winches; so these are drawn, down to a quarter of a metre. x to
starboard, y ahead, z up from the waterline [m]; single sheets are seen from either side.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SECTION = 11.5  # m, of long thin parts: two halvings make them as short as a resolution cell of 3 m
# y as a share of half the length from the stern (-1) to the stem (1), half breadths of deck and waterline, of half the beam
STATIONS = ((-1.0, 0.86, 0.62), (-0.8, 0.96, 0.86), (-0.5, 1.0, 0.97), (-0.1, 1.0, 1.0), (0.3, 1.0, 0.98), (0.5, 0.96, 0.86),
            (0.65, 0.86, 0.66), (0.78, 0.68, 0.42), (0.88, 0.46, 0.22), (0.95, 0.24, 0.08), (1.0, 0.02, 0.0))  # fmt: skip


class Drawing:
    """Triangles gathered one part after the other."""

    def __init__(self) -> None:
        self.parts: list[Floats] = []

    @property
    def triangles(self) -> Floats:
        """All of them (F, 3, 3), without those that have no area."""
        joined = np.concatenate(self.parts)
        cross = np.cross(joined[:, 1] - joined[:, 0], joined[:, 2] - joined[:, 0])
        return np.asarray(joined[np.linalg.norm(cross, axis=1) > 1e-9])

    def sheet(self, a: Sequence[float], b: Sequence[float], c: Sequence[float], d: Sequence[float]) -> None:
        """A quadrangle, corner after corner."""
        p, q, r, s = (np.array(x, dtype=np.float64) for x in (a, b, c, d))
        self.parts.append(np.stack([np.stack([p, q, r]), np.stack([p, r, s])]))

    def box(self, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> None:
        """A closed box between two x, two y and two z."""
        (x0, x1), (y0, y1), (z0, z1) = sorted(x), sorted(y), sorted(z)
        ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
            self.sheet((ax, ay, z0), (bx, by, z0), (bx, by, z1), (ax, ay, z1))
        self.sheet(*((px, py, z1) for px, py in ring))
        self.sheet(*((px, py, z0) for px, py in reversed(ring)))

    def post(self, foot: Sequence[float], top: Sequence[float], radius: float, sides: int = 12) -> None:
        """A round bar from foot to top, open at its ends."""
        low, high = np.array(foot, dtype=np.float64), np.array(top, dtype=np.float64)
        along = (high - low) / np.linalg.norm(high - low)
        across = np.cross(along, [1.0, 0, 0] if abs(along[0]) < 0.8 else [0, 1.0, 0])
        across *= radius / np.linalg.norm(across)
        other = np.cross(along, across)
        turn = 2.0 * np.pi * np.arange(sides + 1) / sides
        ring = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * other
        for p, q in zip(ring[:-1], ring[1:], strict=True):
            self.sheet(low + p, low + q, high + q, high + p)


def hull(drawing: Drawing, length: float, beam: float, deck: float, forecastle: float) -> None:
    """Sides, transom and deck; the deck rises to the forecastle ahead of y = 0.72 of half the length."""
    y, wide, low = (np.array(column) for column in zip(*STATIONS, strict=True))
    y, wide, low = y * length / 2, wide * beam / 2, low * beam / 2
    rake = 0.03 * length * np.clip(y / length * 2, 0.0, 1.0) ** 3  # the stem leans forward
    top = np.where(y > 0.36 * length, forecastle, deck)
    for k in range(len(y) - 1):
        z = top[k]
        for side in (1.0, -1.0):
            drawing.sheet((side * low[k], y[k] - rake[k], 0), (side * low[k + 1], y[k + 1] - rake[k + 1], 0),
                          (side * wide[k + 1], y[k + 1], z), (side * wide[k], y[k], z))  # fmt: skip
        drawing.sheet((-wide[k], y[k], z), (wide[k], y[k], z), (wide[k + 1], y[k + 1], z), (-wide[k + 1], y[k + 1], z))
        if top[k + 1] != z:
            w = wide[k + 1]
            drawing.sheet((-w, y[k + 1], z), (w, y[k + 1], z), (w, y[k + 1], top[k + 1]), (-w, y[k + 1], top[k + 1]))
    drawing.sheet((-low[0], y[0], 0), (low[0], y[0], 0), (wide[0], y[0], deck), (-wide[0], y[0], deck))


def bulwarks(drawing: Drawing, length: float, beam: float, deck: float, forecastle: float, high: float) -> None:
    """Plates a metre high along the deck's edge, with stays to the deck every few metres."""
    y, wide, _ = (np.array(column) for column in zip(*STATIONS, strict=True))
    y, wide = y * length / 2, wide * beam / 2
    for side in (1.0, -1.0):
        for k in range(1, len(y) - 1):
            z = forecastle if y[k] > 0.36 * length else deck
            drawing.sheet((side * wide[k], y[k], z), (side * wide[k + 1], y[k + 1], z),
                          (side * wide[k + 1], y[k + 1], z + high), (side * wide[k], y[k], z + high))  # fmt: skip
            count = int((y[k + 1] - y[k]) / 2.4)
            for share in (np.arange(count) + 0.5) / max(count, 1):
                at, edge = y[k] + share * (y[k + 1] - y[k]), side * (wide[k] + share * (wide[k + 1] - wide[k]))
                head = z + 0.9 * high
                drawing.sheet((edge, at, z), (edge - side * 0.4, at, z), (edge - side * 0.15, at, head), (edge, at, head))


def coaming(drawing: Drawing, x: float, y: tuple[float, float], deck: float, high: float) -> None:
    """A hatch: coaming with stays and a flange at its sides, covered by panels with gaps between them."""
    drawing.box((-x, x), y, (deck, deck + high))
    top = deck + high
    for side in (x, -x):
        for at in np.arange(y[0] + 0.9, y[1], 1.9):
            fin(drawing, side, 0.35, at, (deck, top - 0.3))
        out = side + np.sign(side) * 0.3
        drawing.sheet((side, y[0], top), (out, y[0], top), (out, y[1], top), (side, y[1], top))
    for at in np.arange(y[0] + 0.1, y[1] - 5.0, 5.2):
        drawing.box((-x + 0.2, x - 0.2), (at, at + 5.0), (top, top + 0.55))


def fin(drawing: Drawing, x: float, wide: float, y: float, z: tuple[float, float]) -> None:
    """An upright plate athwartships that stands `wide` out from x, away from the middle."""
    out = x + np.sign(x) * wide
    drawing.sheet((x, y, z[0]), (out, y, z[0]), (out, y, z[1]), (x, y, z[1]))


def deckhouse(drawing: Drawing, beam: float, y: tuple[float, float], deck: float, tiers: int) -> float:
    """Tiers, each a little smaller, with ledges and frames a hand deep; a wheelhouse with wings on top. Returns its roof."""
    z, half, (aft, fore) = deck, 0.42 * beam, y
    for tier in range(tiers):
        top, frame = z + 2.6, (z + 0.9, z + 1.9)
        drawing.box((-half, half), (aft, fore), (z, top))
        out = half + 0.5
        drawing.sheet((-out, fore + 0.5, top), (out, fore + 0.5, top), (out, fore, top), (-out, fore, top))
        for at in np.arange(-half + 0.6, half - 0.5, 2.3):
            drawing.sheet(
                (at, fore, frame[0]), (at, fore + 0.12, frame[0]), (at, fore + 0.12, frame[1]), (at, fore, frame[1])
            )
        for at in np.arange(aft + 1.0, fore - 0.8, 2.3):
            fin(drawing, half, 0.12, at, frame)
            fin(drawing, -half, 0.12, at, frame)
        z, half, aft, fore = top, half - 0.35, aft + 0.6, fore - 0.3 * (tier > 0)
    wheelhouse(drawing, half - 0.3, beam / 2, fore - 0.6, z)
    return z + 2.5


def wheelhouse(drawing: Drawing, half: float, wing: float, fore: float, z: float) -> None:
    """A box 4.4 m long, and wings on either side with their rail plates."""
    drawing.box((-half, half), (fore - 4.4, fore), (z, z + 2.5))
    aft, ahead, rail = fore - 2.4, fore - 0.4, z + 1.1
    for side in (1.0, -1.0):
        inner, outer = side * half, side * wing
        drawing.box((inner, outer), (aft, ahead), (z - 0.15, z))
        for at in (aft, ahead):
            drawing.sheet((inner, at, z), (outer, at, z), (outer, at, rail), (inner, at, rail))
        drawing.sheet((outer, aft, z), (outer, ahead, z), (outer, ahead, rail), (outer, aft, rail))


def funnel(drawing: Drawing, half: float, y: tuple[float, float], z: tuple[float, float]) -> None:
    """A casing with an exhaust."""
    drawing.box((-half, half), y, z)
    middle = (y[0] + y[1]) / 2.0
    drawing.post((0.6, middle, z[1]), (0.6, middle, z[1] + 1.2), 0.35, 16)


def winches(drawing: Drawing, y: float, deck: float) -> None:
    """A pair of boxes with drums ahead of them."""
    for side in (1.0, -1.0):
        drawing.box((side * 1.2, side * 3.0), (y, y + 1.7), (deck, deck + 1.3))
        drawing.post((side * 0.8, y + 2.7, deck + 0.7), (side * 3.2, y + 2.7, deck + 0.7), 0.45, 16)


def mast(drawing: Drawing, y: float, foot: float, top: float, radius: float) -> None:
    """A pole with two platforms and a yard."""
    drawing.post((0, y, foot), (0, y, top), radius, 16)
    for share in (0.45, 0.75):
        z = foot + share * (top - foot)
        drawing.box((-0.7, 0.7), (y, y + 1.1), (z, z + 0.12))
        drawing.sheet((-0.02, y, z - 0.8), (-0.02, y + 1.0, z), (0.02, y + 1.0, z), (0.02, y, z - 0.8))
        drawing.box((-0.3, 0.3), (y + 0.3, y + 0.8), (z + 0.12, z + 0.7))
    drawing.post((-2.2, y, top - 0.6), (2.2, y, top - 0.6), 0.06, 8)


def derricks(drawing: Drawing, x: float, y: float, deck: float, reach: float) -> None:
    """A pair of posts with a crosstree and a winch house between, two stowed booms ahead and two abaft of them."""
    top = deck + 15.0
    drawing.box((-x + 0.9, x - 0.9), (y - 0.8, y + 0.8), (deck, deck + 3.4))
    for side in (x, -x):
        drawing.post((side, y, deck), (side, y, top), 0.45)
        for ahead in (1.0, -1.0):
            heel, head = (side, y + 0.7 * ahead, deck + 4.2), (side, y + reach * ahead, deck + 5.4)
            drawing.post(heel, head, 0.25, 6)
        drawing.box((side - 0.7, side + 0.7), (y - 0.7, y + 0.7), (top - 0.9, top))
        drawing.box((side - 0.8, side + 0.8), (y - 0.8, y + 0.8), (deck + 3.4, deck + 4.6))
    drawing.box((-x, x), (y - 0.3, y + 0.3), (top - 2.2, top - 1.6))


def rails(drawing: Drawing, length: float, beam: float, deck: float, forecastle: float) -> None:
    """A bar on flat stanchions along the deck's edge, over a gutter plate a hand high."""
    y, wide, _ = (np.array(column) for column in zip(*STATIONS, strict=True))
    y, wide = y * length / 2, wide * beam / 2
    for side in (1.0, -1.0):
        for k in range(len(y) - 1):
            z = forecastle if y[k] > 0.36 * length else deck
            near, far = (side * wide[k], y[k]), (side * wide[k + 1], y[k + 1])
            for low, high in ((0.0, 0.2), (1.05, 1.11)):
                drawing.sheet((*near, z + low), (*far, z + low), (*far, z + high), (*near, z + high))
            count = int((y[k + 1] - y[k]) / 3.0)
            for share in (np.arange(count) + 0.5) / max(count, 1):
                at, edge = y[k] + share * (y[k + 1] - y[k]), side * (wide[k] + share * (wide[k + 1] - wide[k]))
                fin(drawing, edge - side * 0.1, 0.1, at, (z, z + 1.1))


def pipes(drawing: Drawing, y: tuple[float, float], deck: float) -> None:
    """Cargo lines along the deck, in lengths of SECTION with a gap between, on saddles."""
    for aft in np.arange(y[0], y[1] - SECTION, SECTION + 0.3):
        for x in (-4.3, -3.0, 3.0, 4.3):
            drawing.post((x, aft, deck + 1.1), (x, aft + SECTION, deck + 1.1), 0.22, 6)
    for at in np.arange(y[0] + 2.0, y[1], 6.0):
        for side in (1.0, -1.0):
            drawing.box((side * 2.4, side * 4.8), (at, at + 0.25), (deck, deck + 0.85))


def catwalk(drawing: Drawing, y: tuple[float, float], deck: float) -> None:
    """A gangway in the middle, in lengths of SECTION on frames, with a plate along either side of it."""
    z = deck + 2.6
    for aft in np.arange(y[0], y[1] - SECTION, SECTION):
        fore = aft + SECTION
        drawing.sheet((-0.8, aft, z), (0.8, aft, z), (0.8, fore, z), (-0.8, fore, z))
        drawing.box((-1.0, 1.0), (aft, aft + 0.3), (deck, z))
        for side in (0.8, -0.8):
            drawing.sheet((side, aft, z), (side, fore, z), (side, fore, z + 0.5), (side, aft, z + 0.5))


def manifold(drawing: Drawing, y: float, beam: float, deck: float) -> None:
    """Pipes athwartships that end in flanges over drip trays, and a hose crane on either side."""
    edge = beam / 2.0 - 4.0
    for at in y + np.arange(-6.0, 7.0, 2.0):
        drawing.post((-edge, at, deck + 1.7), (edge, at, deck + 1.7), 0.25, 8)
        for side in (edge, -edge):
            drawing.box((side - 0.06, side + 0.06), (at - 0.45, at + 0.45), (deck + 1.25, deck + 2.15))
    for side in (1.0, -1.0):
        drawing.box((side * (edge - 1.5), side * (edge + 1.5)), (y - 7.5, y + 7.5), (deck, deck + 0.7))
        foot, head = (side * 5.6, y + 9.0, deck), (side * 5.6, y + 9.0, deck + 11.0)
        drawing.post(foot, head, 0.6)
        drawing.box((side * 4.6, side * 6.6), (y + 8.0, y + 10.0), (deck + 9.0, deck + 11.0))
        drawing.post((side * 5.6, y + 9.0, deck + 10.0), (side * 5.6, y - 6.0, deck + 6.0), 0.3, 8)
