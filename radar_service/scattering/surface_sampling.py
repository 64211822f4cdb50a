"""Fixed scatterers: points on the surface of a body, drawn once in its own frame, each standing for some area.

Because they are fixed, phases repeat when nothing moves, and change with the geometry when something moves.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Complexes, Floats, Indices
from radar_service.records import MIN_SCATTERERS
from radar_service.world import Mesh

MAX_SCATTERERS = 1_500_000  # on one body: some 250 MB while they are spread
TRIANGLES = 2**18  # at a time: arrays of all triangles of a large mesh do not stay in any cache
MAX_STRATA = 512  # more points than that stand for so little that strata do not pay: they are sampled along the mesh
CANDIDATES = 32  # points of a stratum, from which one is drawn, and by which its heights are known
R2 = (0.7548776662466927, 0.5698402909980532)  # steps of the evenest sequence in a square (Roberts 2018)
SMALL = 4096  # triangles of a mesh whose normals are kept
MAX_FACES = 16  # plane faces that are sampled one by one
ONE_PER_CELL = 0.93  # dB, error and spread of the mean power of surfaces; chart of the basin: 0.98, with 4 0.44, 16 0.23
# dB, rms error of the mean power of hulls, spheres, cylinders and boxes: 24 / N, and 2 / sqrt(N)
STRATIFIED, LOBES = 24.0, 2.0
RANDOM, RANDOM_LOBES = 4.3, 7.5  # dB over sqrt(N), of more points than strata (tests/plan/test_power.py has all four)


def density_db(per_cell: float) -> float:
    """Predicted error [dB] of the mean power of a surface a few cells large: it goes as one over the root of its points."""
    return ONE_PER_CELL / math.sqrt(per_cell)


def surface_db(scatterers: float, multipath: bool) -> float:
    """Predicted error [dB] of the mean power of a surface with so many scatterers; multipath: in the lobes of sea reflection.

    One point drawn from each of N strata errs as 1 / N. In lobes the heights of curved strata add 1 / sqrt(N).
    """
    if scatterers > MAX_STRATA:
        return (RANDOM_LOBES if multipath else RANDOM) / math.sqrt(scatterers)
    return math.hypot(STRATIFIED / scatterers, LOBES / math.sqrt(scatterers) if multipath else 0.0)


@dataclass(frozen=True)
class Scatterers:
    """Scatterers (E,) in a body's frame.

    position: (E, 3) [m].
    normal: (E, 3), of unit length; 0 for a point.
    area: (E,) that each stands for [m^2].
    triangle: (E,) index in the mesh, -1 for a point.
    phasor: (E,) of unit length: the random phase.
    middle: (E,) mean height of what each stands for, in the body's frame [m].
    span: (E,) its vertical extent [m]: that of even heights with the same variance.
    """

    position: Floats
    normal: Floats
    area: Floats
    triangle: Indices
    phasor: Complexes
    middle: Floats
    span: Floats

    def __post_init__(self) -> None:
        count = len(self.area)
        assert self.position.shape == self.normal.shape == (count, 3)
        assert self.triangle.shape == self.phasor.shape == self.middle.shape == self.span.shape == (count,)

    def __len__(self) -> int:
        return len(self.area)

    @classmethod
    def joined(cls, parts: "Sequence[Scatterers]") -> "Scatterers":
        """One after the other."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__dataclass_fields__))


def point_scatterer(position: Floats, span: float = 0.0) -> Scatterers:
    """The single scatterer of a body that counts as a point, at `position` (3,) in its frame [m]; span: its height [m]."""
    ones, none = np.ones(1), np.full(1, -1)
    place = position[None, :].copy()
    return Scatterers(place, np.zeros((1, 3)), ones, none, ones.astype(complex), position[2:].copy(), span * ones)


def triangle_middles(mesh: Mesh) -> Floats:
    """Centroids (F, 3) [m] of the triangles of a mesh."""
    total = mesh.vertices.take(mesh.faces[:, 0], axis=0)
    for corner in (1, 2):
        total += mesh.vertices.take(mesh.faces[:, corner], axis=0)
    total /= 3.0
    return total


def normals_and_areas(mesh: Mesh) -> tuple[Floats, Floats]:
    """Unit normals (F, 3) and areas (F,) [m^2] of the triangles of a mesh."""
    normal, area = np.empty((len(mesh.faces), 3)), np.empty(len(mesh.faces))
    for start in range(0, len(mesh.faces), TRIANGLES):
        part = slice(start, start + TRIANGLES)
        a, b, c = (mesh.vertices.take(mesh.faces[part, i], axis=0) for i in range(3))
        (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        double = np.sqrt(x * x + y * y + z * z)
        normal[part] = (np.stack([x, y, z]) / np.where(double > 0, double, 1.0)).T
        area[part] = double / 2.0
    return normal, area


def sample_surface(
    mesh: Mesh,
    density: Floats,
    rng: np.random.Generator,
    min_scatterers: int = MIN_SCATTERERS,
    *,
    max_scatterers: int = MAX_SCATTERERS,
    sea: float = -np.inf,
) -> Scatterers:
    """Scatterers drawn over a mesh with an expected `density` (F,) on each triangle [per m^2].

    sea: height of the sea in the body's frame [m]; below it no heights count. The density is scaled to keep the total between
    `min_scatterers` and `max_scatterers`. Up to MAX_STRATA points are drawn one from each stratum of equal expectation. More
    are drawn along the mesh: each triangle gets its expected number to within one.
    """
    surface = _small_surface(mesh) if len(mesh.faces) <= SMALL else _Surface(*normals_and_areas(mesh))
    normal, area = surface.normal, surface.area
    expected = area * density
    total = expected.sum()
    expected *= np.clip(total, min_scatterers, max_scatterers) / total
    total = expected.sum()
    count = int(np.ceil(total * (1.0 - 1e-12)))
    if count <= MAX_STRATA:
        share, plane = count / total * expected, surface.plane
        planes = int(plane.max()) + 1
        if planes == 1 or planes > min(MAX_FACES, count // 4):  # too many for the points to be shared among them
            return _stratified(mesh, normal, area, share, rng, sea)
        parts = (np.where(plane == k, share, 0.0) for k in np.unique(plane[share > 0.0]))
        return Scatterers.joined([_stratified(mesh, normal, area, part, rng, sea) for part in parts])
    drawn = _along_mesh(mesh, area, expected, count, rng, None)
    middle, span = _patch_heights(mesh, normal, drawn, sea)
    phasor = np.exp(2j * np.pi * rng.random(count))
    return Scatterers(drawn.position, normal[drawn.triangle], drawn.area, drawn.triangle, phasor, middle, span)


class _SurfaceSamples(NamedTuple):
    """Points (M,) on a mesh: position (M, 3) [m], triangle (M,), and area (M,) that each stands for [m^2]."""

    position: Floats
    triangle: Indices
    area: Floats


@dataclass(frozen=True)
class _Surface:
    """What a mesh is sampled by: unit normals (F, 3) and areas (F,) [m^2]."""

    normal: Floats
    area: Floats

    @cached_property
    def plane(self) -> Indices:
        """The plane face (F,) of each triangle."""
        _, plane = np.unique(np.round(self.normal, 2) + 0.0, axis=0, return_inverse=True)
        return plane.ravel()


@lru_cache(maxsize=64)
def _small_surface(mesh: Mesh) -> _Surface:
    """The surface of a small mesh, which many bodies may have."""
    return _Surface(*normals_and_areas(mesh))


def _along_mesh(
    mesh: Mesh, area: Floats, expected: Floats, count: int, rng: np.random.Generator, uv: Floats | None
) -> _SurfaceSamples:
    """Systematic sampling along the cumulated expectation (F,). A triangle that expects less than one point is represented by
    its neighbours, so the area is right in the mean. uv: (2, count) of 0 to 1, positions within the triangles; None: random."""
    cumulated = np.cumsum(expected)
    steps = (np.arange(count) + rng.random(count)) * (cumulated[-1] / count)
    triangle, position = points_in_triangles(mesh, cumulated, steps, rng.random((2, count)) if uv is None else uv)
    return _SurfaceSamples(
        position, triangle, cumulated[-1] / count * (area / np.where(expected > 0, expected, 1.0))[triangle]
    )


def points_in_triangles(mesh: Mesh, cumulated: Floats, steps: Floats, uv: Floats) -> tuple[Indices, Floats]:
    """Triangles (N,) where rising steps (N,) lie in their cumulated expectation (F,), and positions (N, 3) at uv (2, N) in
    them."""
    position, triangle = np.empty((len(steps), 3)), np.empty(len(steps), dtype=np.int64)
    taken = (np.ascontiguousarray(part) for part in (mesh.vertices, mesh.faces, cumulated, steps, uv))
    KERNELS.surface_points(len(steps), len(mesh.faces), len(mesh.vertices), *taken, position, triangle)
    return triangle, position


def _stratified(
    mesh: Mesh, normal: Floats, area: Floats, expected: Floats, rng: np.random.Generator, sea: float
) -> Scatterers:
    """At least as many points as are `expected` (F,), one drawn from each of as many strata of equal expectation, compact in
    position and normal."""
    parts, halvings = _split_counts(max(1, round(float(expected.sum()))))
    number = parts * 2**halvings * CANDIDATES
    uv = rng.random((2, 1)) + _even_steps(number)
    points = _along_mesh(mesh, area, expected, number, rng, uv - np.floor(uv))
    pick = rng.integers(CANDIDATES, size=number // CANDIDATES)
    direction = normal.take(points.triangle, axis=0)
    chosen, carried, middle, span = _strata(points, direction, parts, halvings, pick, sea)
    phasor = np.exp(2j * np.pi * rng.random(len(pick)))
    return Scatterers(points.position[chosen], direction[chosen], carried, points.triangle[chosen], phasor, middle, span)


@lru_cache(maxsize=16)
def _even_steps(number: int) -> Floats:
    """The evenest sequence of points in a square (2, N), not wrapped."""
    return np.outer(R2, np.arange(number))


def _strata(
    points: _SurfaceSamples, direction: Floats, parts: int, halvings: int, pick: Indices, sea: float
) -> tuple[Indices, Floats, Floats, Floats]:
    """Of points (N,) with normals `direction` (N, 3), the one of number `pick` (S,) in each of as many strata, the area that it
    stands for, and that area's middle height and vertical extent [m]; sea: its height in the body's frame [m]."""
    chosen, results = np.empty(len(pick), dtype=np.int64), np.empty((3, len(pick)))
    taken = points.position, direction, points.area, sea, pick
    KERNELS.strata(len(direction), parts, halvings, len(pick), *taken, chosen, *results)
    return chosen, results[0], results[1], results[2]


def _split_counts(count: int) -> tuple[int, int]:
    """p and h of the least p 2^h, at least `count`, with p of 1 to 8: at most a quarter more than `count`."""
    halvings = max(0, int(np.ceil(np.log2(count / 8.0))))
    return int(np.ceil(count / 2**halvings)), halvings


def _patch_heights(mesh: Mesh, normal: Floats, points: _SurfaceSamples, sea: float) -> tuple[Floats, Floats]:
    """Middle heights and vertical extents (M,) [m] of square patches about points, kept within their triangles."""
    begins = np.flatnonzero(np.diff(points.triangle, prepend=-1))  # points of a triangle follow each other
    face, counts = points.triangle[begins], np.diff(begins, append=len(points.triangle))
    a, b, c = (mesh.vertices[:, 2].take(mesh.faces[:, corner].take(face)) for corner in range(3))
    low, high = (np.maximum(end(end(a, b), c), sea).repeat(counts) for end in (np.minimum, np.maximum))
    slope = np.sqrt(np.maximum(0.0, 1.0 - normal[face, 2] ** 2)).repeat(counts)
    span = np.minimum(np.sqrt(points.area) * slope, high - low)
    return np.clip(points.position[:, 2], low + span / 2.0, high - span / 2.0), span


def cell_density(distance: Floats, range_step: float, beamwidth: float, per_cell: float) -> Floats:
    """Points per m^2 of surface at `distance` (F,) [m] that put `per_cell` of them into a cell of range step by beam."""
    across = np.maximum(beamwidth * distance, range_step)
    return per_cell / (range_step * across)
