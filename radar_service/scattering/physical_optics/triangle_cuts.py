"""Triangles cut in two by a straight line, where a value that is linear over them changes its sign."""

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices

AT_LEVEL = 1e-6  # m: what is nearer to the level lies on it, however a rotated body is rounded


def above_water(corners: Floats, level: float) -> tuple[Floats, Indices]:
    """The parts of triangles (M, 3, 3) that rise above `level` [m], and the triangle that each comes from (N,).

    Triangles that lie above as a whole come first, as they are. Others are cut exactly along the level.
    """
    height = corners[:, :, 2] - level
    height[np.abs(height) < AT_LEVEL] = 0.0
    if not (height < 0.0).any():
        return corners, np.arange(len(corners))
    return cut(corners, height)[0]


def cut(corners: Floats, value: Floats) -> tuple[tuple[Floats, Indices], tuple[Floats, Indices]]:
    """The parts of triangles (M, 3, D) where a value is not negative, and those where it is, each with the triangle that it
    comes from (N,).

    value: (M, 3) at the corners; columns of `corners` are interpolated along the edges. Triangles that lie on one side as a
    whole come first, as they are.
    """
    below = value < 0.0
    count = below.sum(axis=1)
    uncut, stumps, tips, none = (np.flatnonzero(count == number) for number in range(4))
    tip, *rest = _divided(corners[tips], value[tips], ~below[tips])
    fall, *stay = _divided(corners[stumps], value[stumps], below[stumps])
    kept = np.concatenate([corners[uncut], tip, *stay]), np.concatenate([uncut, tips, stumps, stumps])
    lost = np.concatenate([corners[none], fall, *rest]), np.concatenate([none, stumps, tips, tips])
    return kept, lost


def _divided(corners: Floats, value: Floats, single: Flags) -> tuple[Floats, Floats, Floats]:
    """Triangles (K, 3, D) whose corner `single` (K, 3) lies alone on its side: the triangle at that corner, and two that make
    up the rest."""
    turn = (single.argmax(axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, turn[:, :, None], axis=1).transpose(1, 0, 2)
    at_a, at_b, at_c = np.take_along_axis(value, turn, axis=1).T
    ab, ac = (a + (at_a / (at_a - end))[:, None] * (to - a) for end, to in ((at_b, b), (at_c, c)))
    return np.stack([a, ab, ac], axis=1), np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)
