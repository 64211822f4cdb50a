"""Witnesses of the kernels of shadows, as those of `kernel_witnesses`."""

import itertools
from typing import Any

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.propagation.multipath import reflection_distance
from radar_service.scattering.physical_optics import shadow_edges
from radar_service.scattering.physical_optics.cast_shadows import NEAR, NEAR_SHARE
from radar_service.scattering.physical_optics.facets import centroids
from radar_service.scattering.physical_optics.own_shadows import MARGIN
from radar_service.scattering.physical_optics.picture import Picture, Windows
from radar_service.scattering.physical_optics.triangle_cuts import cut
from radar_service.trace.occluder import NO_TRIANGLE, RELATIVE_TOLERANCE, TOLERANCE
from tests.reference.tube_witness import first_largest, line_through

EDGE_ON = 1e-9  # of the distance: triangles whose plane passes nearer by the antenna cast no shadow
ON_PLANE, BESIDE, ALONG = 1e-6, 1e-9, 1e-5  # m from a plane; rad outside a triangle, and off its side
SAME_POINT = 1e-5  # m within which corners of triangles are one
OUTSIDE = 2.1  # radii before a point where its ray begins


def curved(points: Floats, earth_radius: float) -> Floats:
    """Points (..., 3) as the earth curves away from their origin [m]."""
    drop = (points[..., 0] ** 2 + points[..., 1] ** 2) / (2.0 * earth_radius)
    return np.stack([points[..., 0], points[..., 1], points[..., 2] - drop], axis=-1)


def own_shadow_rays(
    count: int, by_sea: int, points: Floats, at_x: float, at_y: float, height: float, water: float, earth_radius: float,
    centre: Floats, radius: float, lean: Floats, end: Floats, line: Floats, origin: Floats, begin: Any, direction: Any,
    reflection: Floats, beyond: Floats,
) -> int:  # fmt: skip
    share, start = np.zeros(count), np.tile([at_x, at_y, height + water], (count, 1))
    if by_sea:
        distance = np.hypot(points[:, 0] - at_x, points[:, 1] - at_y)
        share = reflection_distance(distance, points[:, 2] - water, height, earth_radius) / np.maximum(distance, MARGIN)
        start[:, :2] += share[:, None] * (points[:, :2] - [at_x, at_y])
        start[:, 2] = water
        reflection[:], beyond[:] = start, distance * (1.0 - share)
    end[:], start = curved(points, earth_radius) @ lean, curved(start, earth_radius) @ lean
    line[:] = end - start
    length = np.maximum(np.linalg.norm(line, axis=1), TOLERANCE)
    part = np.minimum((OUTSIDE * radius + TOLERANCE) / length, 1.0)
    begin[:], direction[:] = end - line * part[:, None] - centre, line
    origin[:] = end - line / np.maximum(1.0 - share, 1e-6)[:, None]
    return count


def own_shadow_hits(
    count: int,
    hit: Indices,
    triangle: Indices,
    end: Floats,
    line: Floats,
    normal: Floats,
    offset: Floats,
    occluding: Indices,
) -> int:
    along = np.einsum("ij,ij->i", normal[hit], line)
    above = np.einsum("ij,ij->i", normal[hit], end) - offset[hit]
    before = np.divide(above, along, out=np.full(count, -np.inf), where=along != 0.0)
    least = TOLERANCE / np.maximum(np.linalg.norm(line, axis=1), TOLERANCE) + RELATIVE_TOLERANCE
    occluding[:] = np.where((hit >= 0) & (hit != triangle) & (before > least), hit, NO_TRIANGLE)
    return count


def shadow_edge_step(
    count: int, vertex_count: int, growth: float, left: Indices, occluding: Indices, end: Floats, origin: Floats, way: Floats,
    curved_way: Floats, hidden: Floats, triangle: Indices, onward: Floats, vertices: Floats, faces: Indices, share: Floats,
    edge: Floats, result: Floats, points: Floats, on: Indices,
) -> int:  # fmt: skip
    now = left[:count]
    free = now[occluding == NO_TRIANGLE]
    result[free] = edge[free]
    known = np.flatnonzero(occluding >= 0)
    now, corners = now[known], vertices[faces[occluding[known]]]
    further = [_way_out(*each) for each in zip(corners, end[known], origin[known], curved_way[now], strict=True)]
    edge[now] = np.minimum(share[now] + np.array(further), 1.0)
    share[now] = np.minimum(edge[now] + growth * onward[now], 1.0)
    going = len(now)
    left[:going], on[:going] = now, triangle[now]
    points[:going] = hidden[now] + share[now, None] * way[now]
    return going


def _way_out(corners: Floats, begin: Floats, origin: Floats, way: Floats) -> float:
    """Where a way from a point in the shadow of a triangle leaves it: at a plane through `origin` and an edge."""
    result, ends = np.inf, corners - origin
    for a, b, c in zip(ends, np.roll(ends, -1, axis=0), np.roll(ends, -2, axis=0), strict=True):
        plane = np.cross(a, b)
        if (plane @ way) * (plane @ c) < 0.0:
            result = min(result, max(-(plane @ (begin - origin)) / (plane @ way), 0.0))
    return float(result)


def shadow_tips(
    count: int, samples: int, corners: Floats, flags: Flags, which: Indices, tip: Flags, begin: Floats, end: Floats
) -> int:
    odd = np.flatnonzero(flags[:, :3].sum(axis=1) % 3 != 0)
    ordered, seen = _ordered(corners[odd], flags[odd])
    inset = ordered + shadow_edges.INSET * (centroids(ordered)[:, None] - ordered)
    which[: len(odd)], tip[: len(odd)] = odd, seen
    begin[: 2 * len(odd)], end[: 2 * len(odd)] = np.repeat(inset[:, 0], 2, axis=0), inset[:, 1:].reshape(-1, 3)
    return len(odd)


def _turn(flags: Flags) -> Indices:
    """The order of corners (K, 3) that puts the one first that differs."""
    seen = flags[:, :3]
    alone = np.where(seen.sum(axis=1) == 1, seen.argmax(axis=1), (~seen).argmax(axis=1))
    return np.asarray((alone[:, None] + np.arange(3)) % 3)


def _ordered(corners: Floats, flags: Flags) -> tuple[Floats, Flags]:
    """Facets (K, 3, 3) whose first corner is the one that differs, and whether it is visible."""
    turn = _turn(flags)
    return np.take_along_axis(corners, turn[:, :, None], axis=1), np.take_along_axis(flags, turn[:, :1], axis=1)[:, 0]


def shadow_cuts(
    count: int, samples: int, odd: int, corners: Floats, flags: Flags, lattice: Floats, which: Indices, tip: Flags,
    crossing: Floats, parts: Floats, origin: Indices, share: Floats, halved: Floats, rest: Indices,
) -> int:  # fmt: skip
    line, turn = line_through(crossing.T, shadow_edges.INSET).T, _turn(flags[which])
    along = np.stack([lattice[:, turn[:, 1]].T, lattice[:, turn[:, 2]].T])
    reach = along[0] / np.maximum(line[:, :1], 1e-9) + along[1] / np.maximum(line[:, 1:], 1e-9)
    near = np.abs(reach - 1.0) * line.min(axis=1, keepdims=True) < 0.01
    explained = (((reach < 1.0) == (flags[which] == tip[:, None])) | near).all(axis=1)
    left = np.setdiff1d(np.arange(count), which[explained], assume_unique=True)
    a, b, c = _ordered(corners[which[explained]], flags[which[explained]])[0].transpose(1, 0, 2)
    ab, ac = a + line[explained, :1] * (b - a), a + line[explained, 1:] * (c - a)
    cut_off = np.concatenate([np.stack(part, axis=1) for part in ([a, ab, ac], [ab, b, c], [ab, c, ac])])
    tips, number = tip[explained], len(cut_off)
    parts[:number], origin[:number] = cut_off, np.tile(which[explained], 3)
    share[:number] = np.concatenate([tips, ~tips, ~tips])
    halved[: 2 * len(left)], rest[: len(left)] = halves(corners[left]), left
    return number // 3


def shadow_planes(count: int, corners: Floats, kept: Floats, plane: Floats, offset: Floats, distance: Floats) -> int:
    a, b, c = corners.transpose(1, 0, 2)
    planes = np.stack([np.cross(a, b), np.cross(b, c), np.cross(c, a), np.cross(b - a, c - a)], axis=1)
    planes /= np.maximum(np.linalg.norm(planes, axis=2, keepdims=True), 1e-30)
    far, away = np.linalg.norm(a, axis=1), np.einsum("tx,tx->t", planes[:, 3], a)
    turn = np.sign(np.einsum("tx,tx->t", planes[:, 0], c))
    planes[:, :3] *= turn[:, None, None]
    planes[:, 3] *= np.sign(away)[:, None]
    casts = np.flatnonzero((np.abs(away) > EDGE_ON * far) & (turn != 0.0))
    total = len(casts)
    kept[:total], plane[:total], offset[:total] = corners[casts], planes[casts], 0.0
    offset[:total, 3] = (np.abs(away) * (1.0 + NEAR / np.maximum(far, NEAR) + NEAR_SHARE))[casts]
    distance[:total] = np.linalg.norm(corners[casts], axis=2).min(axis=1)
    return total


def silhouettes(count: int, corners: Floats, plane: Floats, offset: Floats) -> int:
    points, number = np.unique(np.round(corners.reshape(-1, 3) / SAME_POINT), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    ends = np.sort(np.concatenate([number[:, [0, 1]], number[:, [1, 2]], number[:, [2, 0]]]), axis=1)
    third = corners[:, [2, 0, 1]].transpose(1, 0, 2).reshape(-1, 3)
    total = 0
    for edge in np.unique(ends, axis=0):
        a, b = points[edge] * SAME_POINT
        normal = _unit(np.cross(a, b))
        side = third[(ends == edge).all(axis=1)] @ normal
        if not normal.any() or ((side > ON_PLANE).any() and (side < -ON_PLANE).any()):
            continue
        ahead = _unit(a + b)
        plane[total] = normal, _unit(np.cross(normal, a)), _unit(np.cross(b, normal)), ahead
        offset[total] = 0.0, 0.0, 0.0, min(a @ ahead, b @ ahead)
        total += 1
    return total


def _unit(vector: Floats) -> Floats:
    """A vector (3,) of length 1; 0 for one shorter than 1e-9."""
    length = np.linalg.norm(vector)
    return np.asarray(vector / length if length > 1e-9 else 0.0 * vector)


def stand_before(
    count: int, corners: int, legs: int, points: Floats, matrix: Floats, position: Floats, antenna: Floats, earth_radius: float,
    moved: float, own: Floats, stand: Flags,
) -> int:  # fmt: skip
    stand[:] = False
    for leg in range(legs):
        seen = Windows.of(points @ matrix.T + position, Picture(antenna, earth_radius, leg > 0)).widened(moved)
        for window in own[leg:]:
            middle, half, low, high, nearest, farthest = window
            turns = (seen.middle - middle) / (2.0 * np.pi)
            apart = np.abs(turns - np.rint(turns)) * 2.0 * np.pi > seen.half + half + 1e-9
            apart |= (seen.nearest >= farthest) | (seen.low > high + 1e-9) | (seen.high < low - 1e-9)
            stand |= ~apart
    return count


def skyline(
    count: int, room: int, left: float, right: float, low: float, high: float, tolerance: float, ahead: Floats, corners: Floats,
    shift: Floats, chords: Floats,
) -> int:  # fmt: skip
    """Exact, where the kernel keeps within the tolerance: a chord between any two u where an edge ends or meets another."""
    lines = [_edge_in_picture(*ends, ahead, left, right) + [[at, 0.0]] for triangle, at in zip(corners, shift, strict=True)
             for ends in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)]  # fmt: skip
    lines = [line for line in lines if line[0, 0] < line[1, 0]]
    slope = np.array([(line[1, 1] - line[0, 1]) / (line[1, 0] - line[0, 0]) for line in lines])
    level = np.array([line[0, 1] for line in lines]) - slope * np.array([line[0, 0] for line in lines])
    slope, level = np.append(slope, [0.0, 0.0]), np.append(level, [low, high])
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = (level - level[:, None]) / (slope[:, None] - slope)
    cuts = np.unique(np.concatenate([*(line[:, 0] for line in lines), crossing[np.isfinite(crossing)]]))
    total = 0
    for begin, end in itertools.pairwise(cuts):
        over = [k for k, line in enumerate(lines) if line[0, 0] <= (begin + end) / 2.0 <= line[1, 0]]
        best = max(over, key=lambda k: level[k] + slope[k] * (begin + end) / 2.0, default=-1)
        if best < 0 or level[best] + slope[best] * (begin + end) / 2.0 < low:
            continue
        if total < room:
            chords[total] = [(u, min(level[best] + slope[best] * u, high)) for u in (begin, end)]
        total += 1
    return total


def _edge_in_picture(p: Floats, q: Floats, ahead: Floats, left: float, right: float) -> Floats:
    """An edge in the picture of `skyline` from left to right (2, 2), (u, v) at both ends; without width where it is not there."""
    along = np.array([[ahead[1], -ahead[0], 0.0], [*ahead, 0.0], [0.0, 0.0, 1.0]])
    begin, end = along @ p, along @ q
    share = [0.0, 1.0]
    for side in ([0.0, 1.0, 0.0], [1.0, -left, 0.0], [-1.0, right, 0.0]):
        least = 1e-3 if side[0] == 0.0 else 0.0
        at = np.dot(side, begin) - least, np.dot(side, end) - least
        if max(at) < 0.0:
            return np.zeros((2, 2))
        if min(at) < 0.0:
            share[int(at[1] < 0.0)] = (max if at[0] < 0.0 else min)(share[int(at[1] < 0.0)], at[0] / (at[0] - at[1]))
    ends = np.array([begin + part * (end - begin) for part in share])
    ends = ends[:, [0, 2]] / ends[:, 1:2]
    return np.asarray(ends[np.argsort(ends[:, 0])] if share[0] < share[1] else np.zeros((2, 2)))


def _inside(points: Floats, plane: Floats, offset: Floats) -> Flags:
    """Which points (..., 3) lie in the shadow of each triangle (..., T)."""
    return np.asarray((np.einsum("tkx,...x->...tk", plane, points) >= offset).all(axis=-1))


def cast_lit(count: int, triangles: int, virtual: Floats, plane: Floats, offset: Floats, lit: Flags) -> int:
    lit[:] = ~_inside(virtual, plane, offset).any(axis=1)
    return count


def cast_dark(count: int, triangles: int, virtual: Floats, plane: Floats, offset: Floats, dark: Flags) -> int:
    dark[:] = _inside(virtual, plane, offset).all(axis=1).any(axis=1)
    return int(dark.sum())


def cast_cuts(
    count: int, edges: int, triangles: int, room: int, corners: Floats, virtual: Floats, edge_plane: Floats, edge_offset: Floats,
    plane: Floats, offset: Floats, parts: Floats, origin: Indices, bright: Flags,
) -> int:  # fmt: skip
    before = plane[_behind(virtual, plane, offset)]
    pieces, of = np.concatenate([corners, virtual], axis=2), np.arange(count)
    for number in range(edges):
        if number < edges - triangles and is_covered(edge_plane[number], before):
            continue
        side = pieces[:, :, 3:] @ edge_plane[number].T - edge_offset[number]
        crossed = (side.max(axis=1) > ON_PLANE).all(axis=1) & (side[..., 0].min(axis=1) < -ON_PLANE)
        which, value = np.flatnonzero(crossed), side[crossed, :, 0]
        if len(which):
            value[np.abs(value) < ON_PLANE] = 0.0
            (above, from_above), (below, from_below) = cut(pieces[which], value)
            of = np.concatenate([of[~crossed], of[which][from_above], of[which][from_below]])
            pieces = np.concatenate([pieces[~crossed], above, below])
    lit, found = ~_inside(pieces[..., 3:].mean(axis=1), plane, offset).any(axis=1), []
    for triangle in range(count):
        mine = np.flatnonzero(of == triangle)
        if lit[mine].any() and not lit[mine].all():
            found += [(pieces[piece, :, :3], triangle, lit[piece]) for piece in mine]
        elif not lit[mine].all():
            found.append((corners[triangle], triangle, np.False_))
    for n, (part, triangle, light) in enumerate(found[:room]):
        parts[n], origin[n], bright[n] = part, triangle, light
    return len(found)


def _behind(virtual: Floats, plane: Floats, offset: Floats) -> Flags:
    """Behind the planes of which triangles (T,) a box around triangles (M, 3, 3) lies as a whole."""
    if not len(virtual):
        return np.zeros(len(plane), dtype=np.bool_)
    low, high = virtual.min(axis=(0, 1)), virtual.max(axis=(0, 1))
    return np.asarray(np.minimum(plane[:, 3] * low, plane[:, 3] * high).sum(axis=1) >= offset[:, 3])


def is_covered(silhouette: Floats, shadows: Floats) -> bool:
    """Whether shadows of triangles (T, 4, 3) lie on both sides of a silhouette (4, 3) all along it."""
    begin, end = np.cross(silhouette[1], silhouette[0]), np.cross(silhouette[0], silhouette[2])
    spans, reached = [], 0.0
    for planes in shadows[:, :3]:
        start, stop = planes @ begin, planes @ end
        if ((np.abs(start) < ALONG) & (np.abs(stop) < ALONG)).any():
            continue
        start, stop = start + BESIDE, stop + BESIDE
        if ((start < 0.0) & (stop < 0.0)).any():
            continue
        low = max((a / (a - b) for a, b in zip(start, stop, strict=True) if a < 0.0), default=0.0)
        high = min((a / (a - b) for a, b in zip(start, stop, strict=True) if b < 0.0), default=1.0)
        spans += [(low, high)] if low < high else []
    for low, high in sorted(spans):
        if low > reached:
            return False
        reached = max(reached, high)
    return bool(reached >= 1.0)


def halves(corners: Floats) -> Floats:
    """Both halves (2 M, 3, 3) of triangles (M, 3, 3) cut across their longest edge, edge i from corner i to i + 1."""
    edge = first_largest(((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2).T)
    turn = (edge[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, turn[:, :, None], axis=1).transpose(1, 0, 2)
    middle = (a + b) / 2.0
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
