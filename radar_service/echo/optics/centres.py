"""Scattering centres: what the pieces of a body send back, summed coherently cell by cell."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def scattering_centres(
    points: Floats, amplitude: Complexes, antenna: Floats, cell: float, wavenumber: float
) -> tuple[Floats, Complexes]:
    """Points (C, 3) [m] and amplitudes (C,) [m] that the antenna (3,) cannot tell from points (M, 3), amplitude (M,).

    Each stands at the power-weighted middle of a cube of side `cell` [m], with the phases of its points carried there
    exactly for this antenna; seen from a place so far off that the cube turns by d, they err by k cell d at most.
    """
    if not len(points):
        return points, amplitude
    corner = points.min(axis=0)
    index = np.floor((points - corner) / cell).astype(np.int64)
    size = index.max(axis=0) + 1
    _, where = np.unique((index[:, 0] * size[1] + index[:, 1]) * size[2] + index[:, 2], return_inverse=True)
    power = amplitude.real**2 + amplitude.imag**2 + 1e-300
    weight = np.bincount(where, power)
    centre = np.stack([np.bincount(where, power * points[:, i]) / weight for i in range(3)], axis=1)
    path = np.linalg.norm(points - antenna, axis=1) - np.linalg.norm(centre - antenna, axis=1)[where]
    carried = amplitude * np.exp(-2j * wavenumber * path)
    return centre, np.bincount(where, carried.real) + 1j * np.bincount(where, carried.imag)
