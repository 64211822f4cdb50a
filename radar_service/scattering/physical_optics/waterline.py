"""Cutting triangles at a level: what lies below the water neither scatters nor casts an echo."""

import numpy as np

from radar_service.types import Flags, Floats, Indices


def above_water(corners: Floats, level: float) -> tuple[Floats, Indices]:
    """The parts of triangles (M, 3, 3) that rise above `level` [m], and the triangle that each comes from (N,).

    Triangles that lie above as a whole come first, as they are. Others are cut exactly along the level.
    """
    below = corners[:, :, 2] < level
    count = below.sum(axis=1)
    if not count.any():
        return corners, np.arange(len(corners))
    whole, tips, stumps = (np.flatnonzero(count == number) for number in (0, 2, 1))
    tip, _, _ = _cut(corners[tips], ~below[tips], level)
    _, one, other = _cut(corners[stumps], below[stumps], level)
    parts, origin = [corners[whole], tip, one, other], [whole, tips, stumps, stumps]
    return np.concatenate(parts), np.concatenate(origin)


def _cut(corners: Floats, single: Flags, level: float) -> tuple[Floats, Floats, Floats]:
    """Triangles (K, 3, 3) whose corner `single` (K, 3) lies alone on its side of the level: the triangle at that corner, and
    two that make up the rest."""
    turn = (single.argmax(axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, turn[:, :, None], axis=1).transpose(1, 0, 2)
    to_b, to_c = (((level - a[:, 2]) / (end[:, 2] - a[:, 2]))[:, None] for end in (b, c))
    ab, ac = a + to_b * (b - a), a + to_c * (c - a)
    return np.stack([a, ab, ac], axis=1), np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)
