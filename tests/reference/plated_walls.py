"""Slow reference: walls dented between frames, element by element with the dents in their positions (`metal_on_water`).

Draws of walls as ships have them: size, frames, depth of dents, distance, aspect, lean, sea. Which walls of a mesh are dented.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tests.reference import metal_on_water as oracle
from tests.reference.metal_on_water import Complexes, Floats, Setting

COPLANAR = 1e-6  # rad
NODES_A_BAY = 10  # Gauss-Legendre: the phase turns by 9 rad over a bay at most
MAX_TURN, MAX_LEAN = 5.0, 2.0  # degrees off the wall's normal, and off upright


@dataclass(frozen=True)
class Wall:
    """A wall about the middle of its foot line: width and height [m], facing the antenna from a distance [m].

    sunk: how deep its foot is below the sea [m]. turn, lean: off its normal and off upright [rad].
    dent, frame, tier: of its plating [m]. seed: of the dents.
    """

    width: float
    height: float
    distance: float
    sunk: float
    turn: float
    lean: float
    dent: float
    frame: float
    tier: float
    seed: int
    setting: Setting

    @property
    def middle(self) -> Floats:
        """Of the wall (3,), on the map about the foot of the antenna [m]."""
        return np.array([0.0, self.distance, self.height / 2.0 - self.sunk])

    @property
    def axes(self) -> Floats:
        """Rows (3, 3) of the wall's own frame: to the left of one who faces it, upward along it, and its outward normal."""
        ahead, left = (
            np.array([np.sin(self.turn), -np.cos(self.turn), 0.0]),
            np.array([-np.cos(self.turn), -np.sin(self.turn), 0.0]),
        )
        normal = np.cos(self.lean) * ahead + np.sin(self.lean) * np.array([0.0, 0.0, 1.0])
        return np.array([left, np.cross(left, normal), normal])

    def body(self) -> dict[str, Any]:
        """Of a scene file."""
        heading = float(np.rad2deg(np.pi - self.turn) % 360.0)
        plating = {"dent_m": self.dent, "frame_m": self.frame, "panel_height_m": self.tier, "seed": self.seed}
        return {"name": "wall", "shape": "plate", "width_m": self.width, "height_m": self.height, "heading_deg": heading,
                "trim_deg": float(np.rad2deg(self.lean)), "position_m": self.middle.tolist(), "plating": plating}  # fmt: skip


def drawn_wall(seed: int, upright: bool = False) -> Wall:
    """Wall number `seed`. upright: exactly so, and seen along its normal over no sea."""
    rng = np.random.default_rng((71, seed))
    sea = bool(rng.uniform() < 0.7) and not upright
    setting = Setting(polarization=str(rng.choice(["h", "v"])), sea=sea, sea_state=int(rng.integers(0, 4)) if sea else 0,
                      antenna_height=float(rng.uniform(8.0, 25.0)))  # fmt: skip
    turn, lean = np.deg2rad(rng.uniform(-1.0, 1.0, 2) * [MAX_TURN, MAX_LEAN]) * (not upright)
    height = float(rng.uniform(2.0, 6.0))
    return Wall(
        float(rng.uniform(8.0, 40.0)), height, float(rng.uniform(700.0, 2500.0)), 0.0 if upright else 0.1 * height, turn, lean,
        float(rng.uniform(0.002, 0.008)), float(rng.uniform(0.6, 0.8)), float(rng.uniform(1.5, 3.0)), seed, setting,
    )  # fmt: skip


def field(wall: Wall, depths: Floats, first: tuple[int, int]) -> complex:
    """The root of the effective cross-section [m] of a wall. depths: (B, T) the largest of its panels [m], the first of which has
    the numbers `first`, counted from the middle; all 0: a flat wall."""
    left, up, normal = wall.axes
    low, high, half = max(-wall.height / 2.0, (1e-9 - wall.middle[2]) / up[2]), wall.height / 2.0, wall.width / 2.0
    corners = np.array(
        [wall.middle + x * left + z * up for x, z in ((half, low), (-half, low), (-half, high), (half, high))]
    )
    _, phase = oracle.turns(corners, wall.setting)
    bays = int(np.ceil(wall.width / wall.frame))
    elements = oracle.bilinear(corners, oracle.gauss(bays, NODES_A_BAY), oracle.gauss_for(phase + 8.0))
    offset = elements.position - wall.middle
    across, above = offset @ left / wall.frame, offset @ up / wall.tier - 0.5
    bay, tier = np.floor(across).astype(int) - first[0], np.floor(above).astype(int) - first[1]
    share = above - np.floor(above)
    depth = ((1.0 - share) * depths[bay, tier] + share * depths[bay, tier + 1]) * np.sin(np.pi * across) ** 2
    dented = elements._replace(position=elements.position - depth[:, None] * normal)
    total: Complexes = np.zeros(1, dtype=np.complex128)
    for part in oracle.chunks(dented):
        total = total + oracle.contributions(part, False, wall.setting).amplitude.sum()
    slant = float(np.hypot(np.hypot(*wall.middle[:2]), wall.middle[2] - wall.setting.antenna_height))
    return complex(total[0]) * slant**2


def ways_of_walls(triangles: Floats, frame: float) -> np.ndarray:
    """Which of four ways each wall faces (F,), -1 of what has no plating: flat patches within 30 degrees of upright that are
    longer than two panels and higher than frames are apart. Sides along the hull are 2 and 3, across it 0 and 1."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal = across / np.linalg.norm(across, axis=1, keepdims=True)
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
