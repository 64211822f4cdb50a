"""Scattering centres: the field of the facets of a body by one path, summed coherently cell by cell.

The cells are fixed in the body's frame, so centres do not jump while the antenna moves about the body.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.path_fields import PathFields

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

DROPPED = 10.0 ** (-50.0 / 20.0)  # of the strongest centre's amplitude: all that are left out, whatever their phases
MAX_RELATIVE = 3.0


def scattering_centres(
    fields: PathFields, at: Callable[[Floats], tuple[Floats, Complexes]], wavenumber: float, flattest: float = np.inf
) -> tuple[Floats, Complexes]:
    """Points (C, 3) [m] and amplitudes (C,) [m] with the field of `fields` (M,).

    at: the whole path (N,) by way of points (N, 3) [m], and its weight (N,); flattest: maximum height of a cell [m].
    Each centre is the power-weighted mean of a cell. For the antenna where it is, phases and weights are exact.
    Where the body has turned by d, they err by at most k d times the cell's size. The faintest centres, together DROPPED, are
    left out.
    """
    points, amplitude = fields.position, fields.amplitude
    if not len(points):
        return points, amplitude
    where = _cells(points, fields.cell, flattest)
    power = amplitude.real**2 + amplitude.imag**2 + 1e-300
    weight = np.bincount(where, power)
    centre = np.stack([np.bincount(where, power * points[:, i]) / weight for i in range(3)], axis=1)
    length, own = at(centre)
    path = fields.length - length[where]
    rotated = amplitude * np.exp(-1j * wavenumber * path) * _relative(fields.weight, own[where])
    merged = np.bincount(where, rotated.real) + 1j * np.bincount(where, rotated.imag)
    kept = _strongest(np.abs(merged))
    return centre[kept], merged[kept]


def _cells(points: Floats, size: Floats, flattest: float) -> NDArray[np.int64]:
    """The number of the cell that each point (M, 3) lies in, counted from 0 without gaps; size: (M,) of the cells [m]."""
    sizes, kind = np.unique(size, return_inverse=True)
    steps = (points[:, 0] / size, points[:, 1] / size, points[:, 2] / np.minimum(size, flattest))
    x, y, z = (np.floor(step).astype(np.int64) for step in steps)
    x, y, z = x - x.min(), y - y.min(), z - z.min()
    number = ((x * (y.max() + 1) + y) * (z.max() + 1) + z) * len(sizes) + kind.reshape(-1)
    _, where = np.unique(number, return_inverse=True)
    return where.reshape(-1)


def _relative(weight: Complexes, own: Complexes) -> Complexes:
    """Weights (M,) over those of their centres (M,), at most MAX_RELATIVE: a centre may lie in a null of the pattern."""
    ratio = weight / np.where(own == 0.0, 1e-30, own)
    return np.asarray(ratio / np.maximum(np.abs(ratio) / MAX_RELATIVE, 1.0))


def _strongest(level: Floats) -> NDArray[np.int64]:
    """Indices of amplitudes (C,), in their order, without the faintest that add up to DROPPED of the strongest."""
    order = np.argsort(level)
    faint = int(np.searchsorted(np.cumsum(level[order]), DROPPED * level.max(), side="right"))
    return np.sort(order[faint:])
