"""Scattering centres: the field of the facets of a body, summed coherently cell by cell."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


WIDER = 2.0  # cells across the line of sight, where range does not divide, over those along it
DROPPED = 10.0 ** (-50.0 / 20.0)  # of the strongest centre's amplitude: all that are left out, whatever their phases


def scattering_centres(
    points: Floats, amplitude: Complexes, launch: Floats, receive: Floats, cell: float, wavenumber: float
) -> tuple[Floats, Complexes]:
    """Points (C, 3) [m] and amplitudes (C,) [m] with the field of points (M, 3), amplitude (M,), between two ends (3,).

    Each centre is the power-weighted mean of a cell, which is `cell` [m] long along the level line of sight and upward, and
    WIDER times that across. The phases of its points are exact for these two ends. Where the body has turned by d, they err by
    at most k WIDER cell d. The faintest centres, together DROPPED, are left out.
    """
    if not len(points):
        return points, amplitude
    where = _cells(points, receive, cell)
    power = amplitude.real**2 + amplitude.imag**2 + 1e-300
    weight = np.bincount(where, power)
    centre = np.stack([np.bincount(where, power * points[:, i]) / weight for i in range(3)], axis=1)
    path = _mean_range(points, launch, receive) - _mean_range(centre, launch, receive)[where]
    rotated = amplitude * np.exp(-2j * wavenumber * path)
    merged = np.bincount(where, rotated.real) + 1j * np.bincount(where, rotated.imag)
    kept = _strongest(np.abs(merged))
    return centre[kept], merged[kept]


def _cells(points: Floats, antenna: Floats, cell: float) -> NDArray[np.int64]:
    """The number of the cell that each point (M, 3) lies in, counted from 0 without gaps."""
    east, north = antenna[:2] - points[0, :2]
    turn = np.arctan2(east, north)
    along = points[:, 0] * np.sin(turn) + points[:, 1] * np.cos(turn)
    across = points[:, 0] * np.cos(turn) - points[:, 1] * np.sin(turn)
    steps = (along / cell, across / (WIDER * cell), points[:, 2] / cell)
    x, y, z = (np.floor(step - step.min()).astype(np.int64) for step in steps)
    _, where = np.unique((x * (y.max() + 1) + y) * (z.max() + 1) + z, return_inverse=True)
    return where.reshape(-1)


def _strongest(level: Floats) -> NDArray[np.int64]:
    """Indices of amplitudes (C,), in their order, without the faintest that add up to DROPPED of the strongest."""
    order = np.argsort(level)
    faint = int(np.searchsorted(np.cumsum(level[order]), DROPPED * level.max(), side="right"))
    return np.sort(order[faint:])


def _mean_range(points: Floats, launch: Floats, receive: Floats) -> Floats:
    """Half of the path (M,) [m] from launch to points (M, 3) to receive."""
    if receive is launch:
        return _distance(points, launch)
    return (_distance(points, launch) + _distance(points, receive)) / 2.0


def _distance(points: Floats, antenna: Floats) -> Floats:
    offset = points - antenna
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", offset, offset)))
