"""Plating: walls of ships, dented inward between their frames, by physical optics.

Between two frames a plate is w sin^2(pi x / s) deep: it is clamped at them. s is the distance of frames and w is drawn for each
panel, so the dents are periodic along the hull and constant over a deck's height. A wave of two-way phase k g . n w = a then has
Bessel orders (Jacobi-Anger): the specular one loses |J0(a / 2)|^2, and the others go into lobes at multiples of lambda / (2 s) in
azimuth, 1.3 degrees. So dents matter within some degrees of a wall's normal alone. There, pieces are cut into strips of a
quarter of a panel, over each of which the dent is quadratic.

Of bounces only the coherent part counts: its field is lowered at each plated wall.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.special import j0

from radar_service.numerics import Floats, Indices
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.world import Body, Environment, Mesh, Plating, is_metal, mesh_sample

STEEPEST = 0.5  # of a wall's normal, its rise: flatter surfaces are decks and roofs, which waves graze
UPRIGHT = np.deg2rad(0.1)  # off upright: a wall 10 m high then leans by half a wavelength of X band
MOST_UPRIGHT = 0.2  # of the area of walls: plain hulls and shipped meshes have 0.27 to 0.84, other hull types 0.04 to 0.13
FACING = np.deg2rad(5.0)  # off a wall's normal: farther off the echo of a flat wall is 50 dB below its flash
MOST_DARK = 0.5  # of all aspects: plain hulls have 0.55 to 0.71, shipped meshes 0.04 to 0.36, other hull types 0.01 to 0.2
ASPECTS = 720
NAMED = 2  # bodies that a common sentence names
SMALLEST = 2.0  # panels side by side: shorter patches are not plated, nor those less high than a frame's distance
SPREAD = 0.25  # standard deviation of the depths of panels over their mean; they are uniform
# Dents count up to so many orders, and two for each radian of J0's argument; over so many more they fade (`zone`). Beyond it
# orders of dents of 4 and 8 mm have 0.003 of the field, and less.
ORDERS, FADING = 2.0, 1.5
NODES = 9  # of the mean over depths
COSINES = 129  # of a table: between them fields are linear within 1e-4


def vessel_remarks(body: Body) -> list[str]:
    """Sentences about the walls of a vessel; none about other bodies."""
    walls = _walls(body)
    share = 0.0 if walls is None else dark_share(walls[0])
    if share <= MOST_DARK:
        return []
    return [
        f"flat plates: echo at broadside alone; no wall faces {100.0 * share:.0f} % of the aspects within "
        f"{np.rad2deg(FACING):.0f} degrees: take a hull_type, model masts and rails, or declare rcs_dbsm"
    ]


def upright_warnings(bodies: Sequence[Body], environment: Environment) -> list[str]:
    """A sentence about those of bodies by physical optics that are metal vessels and stand upright over a reflecting sea."""
    if not environment.multipath:
        return []
    shares = {
        body.name: share
        for body in bodies
        if is_metal(body.material) and body.motion.sway is None
        if (walls := _walls(body)) is not None and (share := upright_share(*walls)) > MOST_UPRIGHT
    }
    if not shares:
        return []
    names, low, high = list(shares), *(f"{100.0 * end(shares.values()):.0f}" for end in (min, max))
    portion = low if low == high else f"{low} to {high}"
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return [
        f"{', '.join(names[:NAMED])}{more}: metal, upright, over a reflecting sea: {portion} % of walls "
        "make right corners with the sea, which lifts echoes by some 10 dB at all aspects; add seaway = true to "
        "[environment], or list_deg and trim_deg"
    ]


def _walls(body: Body) -> tuple[Floats, Floats] | None:
    """Unit normals (F, 3) and areas (F,) [m^2] of the walls of a vessel above the sea; None where there are none."""
    if not body.is_vessel or body.mesh is None:
        return None
    mesh = mesh_sample(body.mesh)
    normal, area = normals_and_areas(mesh)
    dry = mesh.vertices[:, 2][mesh.faces].max(axis=1) + float(body.motion.position[0, 2]) > 0.0
    walls = dry & (np.abs(normal[:, 2]) < STEEPEST)
    return (normal[walls], area[walls]) if walls.any() else None


def upright_share(normal: Floats, area: Floats) -> float:
    """The share of the area of walls that is upright. normal: (F, 3) unit normals; area: (F,) [m^2]."""
    return float(area[np.abs(normal[:, 2]) < np.sin(UPRIGHT)].sum() / area.sum())


def dark_share(normal: Floats) -> float:
    """The share of all aspects that no wall faces within FACING. normal: (F, 3) of walls."""
    faced = np.unique(np.round(np.arctan2(normal[:, 0], normal[:, 1]), 4))
    aspect = 2.0 * np.pi * np.arange(ASPECTS) / ASPECTS
    gaps = np.diff(np.concatenate([faced, faced[:1] + 2.0 * np.pi]))
    number = np.searchsorted(faced, np.mod(aspect - faced[0], 2.0 * np.pi) + faced[0], side="right") - 1
    past = np.mod(aspect - faced[number], 2.0 * np.pi)
    return float((np.minimum(past, gaps[number] - past) > FACING).mean())


@dataclass(frozen=True)
class PlatedWalls:
    """The plated triangles of a mesh, or its planar pieces, and their dents, in the body's own frame.

    plating: what the owner tells. wavenumber: [rad/m].
    axis: (F,) along which frames follow each other, 0 or 1, -1 of triangles that are not plated.
    wall: (F,) which of four ways it faces.
    drawn: (4, B, T) largest depth of each panel, by wall, bay between frames, and tier [m].
    first: numbers of the first bay and tier.
    """

    plating: Plating
    wavenumber: float
    axis: Indices
    wall: Indices
    drawn: Floats
    first: tuple[int, int]

    @classmethod
    def of(cls, mesh: Mesh, normal: Floats, spans: Floats, plating: Plating | None, wavelength: float) -> Self | None:
        """Of a mesh with unit normals (F, 3) and boxes about patches (F, 3) [m]; None where nothing is dented."""
        if plating is None or plating.depth <= 0.0:
            return None
        long, high = np.hypot(spans[:, 0], spans[:, 1]) > SMALLEST * plating.frame, spans[:, 2] > plating.frame
        plated = (np.abs(normal[:, 2]) < STEEPEST) & long & high
        if not plated.any():
            return None
        along = np.where(np.abs(normal[:, 0]) >= np.abs(normal[:, 1]), 1, 0)
        across = np.take_along_axis(normal, 1 - along[:, None], axis=1)[:, 0]
        least, most = mesh.used_vertices.min(axis=0), mesh.used_vertices.max(axis=0)
        bays, tiers = (
            np.arange(math.floor(least[axes].min() / size) - 1, math.floor(most[axes].max() / size) + 2)
            for axes, size in ((slice(2), plating.frame), (slice(2, 3), plating.tier))
        )
        drawn = _drawn(plating, *np.meshgrid(np.arange(4), bays, tiers, indexing="ij"))
        first = int(bays[0]), int(tiers[0])
        return cls(plating, 2.0 * np.pi / wavelength, np.where(plated, along, -1), 2 * along + (across > 0.0), drawn, first)

    @property
    def zone(self) -> tuple[float, float]:
        """Turns of the two-way phase along a panel beyond which facets are flat, and below which they are wholly dented."""
        dented = ORDERS + 2.0 * self.wavenumber * self.plating.depth
        return dented + FADING, dented

    @cached_property
    def kept_by_facing(self) -> Floats:
        """The share (COSINES,) of the field that a bounce on plating keeps, by cosines from 0 to 1."""
        node, weight = np.polynomial.legendre.leggauss(NODES)
        depth = self.plating.depth * (1.0 + SPREAD * np.sqrt(3.0) * node)
        phase = self.wavenumber * np.linspace(0.0, 1.0, COSINES)[:, None] * depth
        mean = (weight / 2.0 * j0(phase) * np.exp(1j * phase)).sum(axis=1)
        return np.asarray(np.abs(mean))


def _drawn(plating: Plating, wall: Indices, bay: Indices, tier: Indices) -> Floats:
    """Depths [m] of panels by their numbers, mixed to bits that look drawn (splitmix64), so each has its own for ever."""
    bits = np.full(wall.shape, plating.seed, dtype=np.uint64)
    for part in (wall, bay, tier):
        bits = bits + part.astype(np.int64).view(np.uint64) + np.uint64(0x9E3779B97F4A7C15)
        bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        bits = bits ^ (bits >> np.uint64(31))
    uniform = (bits >> np.uint64(11)).astype(np.float64) * 2.0**-53
    return np.asarray(plating.depth * (1.0 + SPREAD * np.sqrt(12.0) * (uniform - 0.5)))
