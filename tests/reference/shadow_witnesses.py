"""Witnesses of the kernels of shadows, as those of `kernel_witnesses`."""

import itertools

import numpy as np

from radar_service.numerics.types import Flags, Floats
from radar_service.scattering.physical_optics.cast_shadows import NEAR, NEAR_SHARE, CastShadows
from radar_service.scattering.physical_optics.picture import Picture, Windows

EDGE_ON = 1e-9  # of the distance: triangles whose plane passes nearer by the antenna cast no shadow


def curved(points: Floats, earth_radius: float) -> Floats:
    """Points (..., 3) as the earth curves away from their origin [m]."""
    drop = (points[..., 0] ** 2 + points[..., 1] ** 2) / (2.0 * earth_radius)
    return np.stack([points[..., 0], points[..., 1], points[..., 2] - drop], axis=-1)


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


def lit(shadows: CastShadows, position: Floats) -> Flags:
    """Which points (M, 3) on the map [m] lie in no shadow."""
    return ~_inside(shadows.picture.virtual(position), shadows.plane, shadows.offset).any(axis=1)
