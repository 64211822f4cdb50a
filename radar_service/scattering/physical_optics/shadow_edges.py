"""Shadow edges: facets that are partly visible are cut along the edge of the shadow.

Each facet is sampled at several points. Where they differ, the edge of the shadow is found by search along two edges of the
facet, and the facet is cut along a straight line, if that explains every sample. Otherwise it is halved, and so on. Facets that
are still mixed at the end count by their visible share.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facets import areas

Visible = Callable[[Floats, Indices], Flags]  # which points (M, 3) on triangles (M,) a leg reaches past all bodies
Edges = Callable[[Floats, Floats, Indices], Floats]  # as `own_shadows.OwnShadows.edges`

INSET = 0.002  # of the way from a corner to the centroid: samples stay off edges, where neighbours would occlude them
FEWEST = 2  # rows of the coarsest lattice of samples: three corners; the centroid goes with them
MAX_ROWS = 14
MAX_SAMPLES = 6_000  # for the first pass over one body, where that is more than the coarsest lattice
PITCH = 0.25  # m between samples where they are few: thin masts


class Effort(NamedTuple):
    """How precisely mixed facets are resolved.

    rows: of their lattice of samples.
    sections: parts of an edge, one of which each search finds.
    searches: one after the other along an edge, until it is known to `precision` [m].
    halvings: how often a facet is halved before it counts by its visible share.
    """

    rows: int
    sections: int
    searches: int
    precision: float
    halvings: int


SMALLEST = 1e-6  # of the body's area: facets below it count by their visible share, where its own parts shade them
MANY = 200  # mixed facets on a body: from then on they are resolved as its own shadows are
FINE = Effort(5, 10, 4, 0.0, 4)  # shadows of other bodies: their edges are found to 1/10,000 of a facet's edge
# Shadows of the body's own parts, which are many and small. Halved once, half-hidden corners lose 1 dB (tests/reference).
COARSE = Effort(2, 4, 3, 0.05, 3)


class Parts(NamedTuple):
    """Parts (N,) of facets: corners (N, 3, 3) [m], the facet each comes from (N,), and the share of it that is visible (N,)."""

    corners: Floats
    origin: Indices
    share: Floats


def lattice_over(corners: Floats, crowded: bool) -> Floats:
    """Barycentric coordinates (S, 3) of the samples that find the shadows on facets (M, 3, 3); crowded: as of `visible_parts`."""
    return _lattice(_rows(corners) if crowded else FEWEST)


def smallest_area(crowded: bool, area: float) -> float:
    """The area [m^2] below which facets are not cut; arguments as `visible_parts`."""
    return 0.0 if crowded else SMALLEST * area


def visible_share(flags: Flags, uncut: Flags | bool) -> Floats:
    """Shares (M,) of facets that are visible, by their samples (M, S). NaN where these are mixed, but for `uncut` (M,), those
    that are not to be cut."""
    share = flags.mean(axis=1)
    return np.where((share % 1.0 == 0.0) | uncut, share, np.nan)


def visible_parts(
    corners: Floats, triangle: Indices, visible: Visible, crowded: bool, area: float, edges: Edges | None = None
) -> Parts:
    """The parts of mixed facets (M,).

    corners: (M, 3, 3) [m]; triangle: (M,) of the mesh; crowded: whether other bodies may cast shadows, of which the edges are
    found precisely; area: of the whole body [m^2]; edges: finds them exactly, where it can.
    """
    effort = FINE if crowded and len(corners) < MANY else COARSE
    smallest = smallest_area(crowded, area)
    return _resolved(corners, np.arange(len(corners)), triangle, visible, edges, effort, smallest)


def _rows(corners: Floats) -> int:
    """Rows of the lattice: as many as its pitch asks, and the budget allows."""
    if not len(corners):
        return FEWEST
    longest = float(np.sqrt(((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=2).max()))
    rows = min(MAX_ROWS, 1 + int(np.ceil(longest / PITCH)))
    allowed = int(np.sqrt(2.0 * MAX_SAMPLES / len(corners)))
    return max(FEWEST, min(rows, allowed))


@cache
def _lattice(rows: int) -> Floats:
    """Barycentric coordinates (S, 3) of samples: a triangular lattice, the corners INSET first, and the centroid last."""
    i, j = np.meshgrid(np.arange(rows), np.arange(rows), indexing="ij")
    inside = i + j < rows
    steps = np.stack([i[inside], j[inside], rows - 1 - i[inside] - j[inside]], axis=1) / (rows - 1.0)
    steps = steps[np.argsort(-steps.max(axis=1), kind="stable")]
    first = np.eye(3)
    samples = np.concatenate([first, steps[3:], np.full((1, 3), 1.0 / 3.0)])
    return np.asarray(samples + INSET * (1.0 / 3.0 - samples))


def sampled(corners: Floats, triangle: Indices, lattice: Floats, visible: Visible) -> Flags:
    """Which samples (M, S) of facets are visible."""
    points = np.einsum("sc,mcx->msx", lattice, corners)
    flags = visible(points.reshape(-1, 3), np.repeat(triangle, len(lattice)))
    return flags.reshape(len(corners), len(lattice))


def _resolved(
    corners: Floats,
    origin: Indices,
    triangle: Indices,
    visible: Visible,
    edges: Edges | None,
    effort: Effort,
    smallest: float,
) -> Parts:
    """The parts of mixed facets; those whose area is below `smallest` [m^2] are not cut."""
    done: list[Parts] = [Parts(np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64), np.zeros(0))]
    lattice = _lattice(effort.rows)
    for level in range(effort.halvings + 1):
        flags = sampled(corners, triangle[origin], lattice, visible)
        count = flags.sum(axis=1)
        pure = (count == 0) | (count == len(lattice)) | (level == effort.halvings)
        pure |= areas(corners) < smallest
        done.append(Parts(corners[pure], origin[pure], count[pure] / len(lattice)))
        mixed = np.flatnonzero(~pure)
        if not len(mixed):
            break
        cut, corners, rest = _cut_along_edges(corners[mixed], origin[mixed], triangle, flags[mixed], visible, edges, effort)
        done.append(cut)
        origin = np.tile(origin[mixed[rest]], 2)
    return Parts(*(np.concatenate(column) for column in zip(*done, strict=True)))


def _cut_along_edges(
    corners: Floats, origin: Indices, triangle: Indices, flags: Flags, visible: Visible, edges: Edges | None, effort: Effort
) -> tuple[Parts, Floats, Indices]:
    """Parts of the facets (K, 3, 3) that one straight line explains, and halves (2 R, 3, 3) and indices (R,) of the others."""
    count, lattice = len(corners), _lattice(effort.rows)
    facets = np.ascontiguousarray(corners), np.ascontiguousarray(flags)
    which, tip, begin, end = (
        np.empty(count, dtype=np.int64), np.empty(count, dtype=np.bool_), np.empty((2 * count, 3)), np.empty((2 * count, 3))
    )  # fmt: skip
    odd = KERNELS.shadow_tips(count, len(lattice), *facets, which, tip, begin, end)
    on = np.repeat(triangle[origin[which[:odd]]], 2)
    crossing = _crossings(begin[: 2 * odd], end[: 2 * odd], on, np.repeat(tip[:odd], 2), visible, edges, effort)
    parts, of_part, share = np.empty((3 * odd, 3, 3)), np.empty(3 * odd, dtype=np.int64), np.empty(3 * odd)
    halved, rest = np.empty((2 * count, 3, 3)), np.empty(count, dtype=np.int64)
    lines = which[:odd], tip[:odd], crossing.reshape(-1, 2)
    explained = KERNELS.shadow_cuts(count, len(lattice), odd, *facets, lattice, *lines, parts, of_part, share, halved, rest)
    cut, left = 3 * explained, count - explained
    return Parts(parts[:cut], origin[of_part[:cut]], share[:cut]), halved[: 2 * left], rest[:left]


def _crossings(
    begin: Floats, end: Floats, triangle: Indices, tip: Flags, visible: Visible, edges: Edges | None, effort: Effort
) -> Floats:
    """Where the edges of shadows cross the ways from `begin` (N, 3), visible or not (`tip`), to `end`: shares (N,) of these."""
    crossing = np.full(len(begin), np.nan)
    if edges is not None:
        first = tip[:, None]
        share = edges(np.where(first, end, begin), np.where(first, begin, end), triangle)
        crossing = np.where(tip, 1.0 - share, share)
    left = np.flatnonzero(np.isnan(crossing))
    crossing[left] = _searched(begin[left], end[left] - begin[left], triangle[left], tip[left], visible, effort)
    return crossing


def _searched(begin: Floats, way: Floats, triangle: Indices, tip: Flags, visible: Visible, effort: Effort) -> Floats:
    """Shares (N,) of ways (N, 3) at which visibility changes from that of their begins, `tip` (N,)."""
    length, share = np.linalg.norm(way, axis=1), np.arange(1, effort.sections) / effort.sections
    low, width = np.zeros(len(way)), np.ones(len(way))
    for _ in range(effort.searches):
        wide = np.flatnonzero(width * length > effort.precision)
        if not len(wide):
            break
        inner = low[wide, None] + width[wide, None] * share
        points = begin[wide, None] + inner[:, :, None] * way[wide, None]
        seen = visible(points.reshape(-1, 3), np.repeat(triangle[wide], len(share))).reshape(inner.shape)
        passed = np.logical_and.accumulate(seen == tip[wide, None], axis=1).sum(axis=1)
        width[wide] /= effort.sections
        low[wide] += passed * width[wide]
    return np.asarray(low + width / 2.0)
