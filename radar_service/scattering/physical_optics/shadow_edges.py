"""Shadow edges: facets that are partly visible are cut along the edge of the shadow.

Each facet is sampled at several points. Where they differ, the edge of the shadow is found by search along two edges of the
facet, and the facet is cut along a straight line, if that explains every sample. Otherwise it is halved, and so on. Facets that
are still mixed at the end count by their visible share.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facets import areas

Visible = Callable[[Floats, Indices], Flags]  # which points (M, 3) on triangles (M,) a leg reaches past all bodies
Edges = Callable[[Floats, Floats, Indices], Floats]  # as `own_shadows.OwnShadows.edges`

INSET = 0.002  # of the way from a corner to the centroid: samples stay off edges, where neighbours would occlude them
SAMPLES = np.concatenate([np.eye(3), np.full((1, 3), 1.0 / 3.0)])  # barycentric: the corners, INSET, and the centroid
SAMPLES += INSET * (1.0 / 3.0 - SAMPLES)


class Effort(NamedTuple):
    """How precisely mixed facets are resolved.

    sections: parts of an edge, one of which each search finds.
    searches: one after the other along an edge, until it is known to `precision` [m].
    halvings: how often a facet is halved before it counts by its visible share.
    """

    sections: int
    searches: int
    precision: float
    halvings: int


SMALLEST = 1e-6  # of the body's area: facets below it count by their visible share
# Shadows of the body's own parts, which are many and small. Halved once, half-hidden corners lose 1 dB (tests/reference).
COARSE = Effort(4, 3, 0.05, 3)


class Parts(NamedTuple):
    """Parts (N,) of facets: corners (N, 3, 3) [m], the facet each comes from (N,), and the share of it that is visible (N,)."""

    corners: Floats
    origin: Indices
    share: Floats


def visible_share(flags: Flags, uncut: Flags | bool) -> Floats:
    """Shares (M,) of facets that are visible, by their samples (M, S). NaN where these are mixed, but for `uncut` (M,), those
    that are not to be cut."""
    share = flags.mean(axis=1)
    return np.where((share % 1.0 == 0.0) | uncut, share, np.nan)


def visible_parts(corners: Floats, triangle: Indices, visible: Visible, area: float, edges: Edges | None = None) -> Parts:
    """The parts of mixed facets (M,).

    corners: (M, 3, 3) [m]; triangle: (M,) of the mesh; area: of the whole body [m^2]; edges: finds them exactly, where it can.
    """
    return _resolved(corners, np.arange(len(corners)), triangle, visible, edges, COARSE, SMALLEST * area)


def sampled(corners: Floats, triangle: Indices, visible: Visible) -> Flags:
    """Which samples (M, S) of facets are visible."""
    points = np.einsum("sc,mcx->msx", SAMPLES, corners)
    flags = visible(points.reshape(-1, 3), np.repeat(triangle, len(SAMPLES)))
    return flags.reshape(len(corners), len(SAMPLES))


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
    for level in range(effort.halvings + 1):
        flags = sampled(corners, triangle[origin], visible)
        count = flags.sum(axis=1)
        pure = (count == 0) | (count == len(SAMPLES)) | (level == effort.halvings)
        pure |= areas(corners) < smallest
        done.append(Parts(corners[pure], origin[pure], count[pure] / len(SAMPLES)))
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
    count = len(corners)
    facets = np.ascontiguousarray(corners), np.ascontiguousarray(flags)
    which, tip, begin, end = (
        np.empty(count, dtype=np.int64), np.empty(count, dtype=np.bool_), np.empty((2 * count, 3)), np.empty((2 * count, 3))
    )  # fmt: skip
    odd = KERNELS.shadow_tips(count, len(SAMPLES), *facets, which, tip, begin, end)
    on = np.repeat(triangle[origin[which[:odd]]], 2)
    crossing = _crossings(begin[: 2 * odd], end[: 2 * odd], on, np.repeat(tip[:odd], 2), visible, edges, effort)
    parts, of_part, share = np.empty((3 * odd, 3, 3)), np.empty(3 * odd, dtype=np.int64), np.empty(3 * odd)
    halved, rest = np.empty((2 * count, 3, 3)), np.empty(count, dtype=np.int64)
    lines = which[:odd], tip[:odd], crossing.reshape(-1, 2)
    explained = KERNELS.shadow_cuts(count, len(SAMPLES), odd, *facets, SAMPLES, *lines, parts, of_part, share, halved, rest)
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
