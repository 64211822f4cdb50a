"""Scattering centres: the field of a body by one path, summed coherently on the nodes of a lattice.

What lies between nodes is shared among them linearly, like the amplitude of a path within a facet. So the sum is right for every
weight that is linear over a cell: of the beam, of the pulse, of the elevation gain, and of the change of phase as the body turns.
The lattice is fixed in the body's frame, so centres do not jump while the antenna moves about the body.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.path_fields import PathFields
from radar_service.types import Complexes, Floats, Indices

DROPPED = 10.0 ** (-50.0 / 20.0)  # of the strongest centre's amplitude: all that are left out, whatever their phases
UPRIGHT = 2.0  # height of a cell over its length: range hardly changes with height


@dataclass(frozen=True)
class Lattice:
    """Nodes (N,) about some fields (M,), those that a field has a share in.

    nodes: (N, 3) in the body's frame [m].
    corner: (8, M) the node at each corner of each field's cell.
    share: (8, M) of the field there; they add up to 1.
    """

    nodes: Floats
    corner: Indices
    share: Floats

    @classmethod
    def over(cls, fields: PathFields, flattest: float, lowest: float) -> "Lattice":
        """The lattice of some fields; flattest: maximum height of a cell [m]; lowest: height below which no node lies [m]."""
        parts = [_lattice(fields, size, flattest, lowest) for size in np.unique(fields.cell)]
        if len(parts) == 1:
            return cls(*parts[0][1:])
        return _joined(parts, len(fields.cell))

    def sums(self, fields: PathFields) -> Complexes:
        """The sum (N,) of all fields' shares at each node."""
        total = np.zeros(len(self.nodes), dtype=np.complex128)
        for corner, share in zip(self.corner, self.share, strict=True):
            total.real += np.bincount(corner, share * fields.amplitude.real, len(total))
            total.imag += np.bincount(corner, share * fields.amplitude.imag, len(total))
        return total


def _lattice(fields: PathFields, size: float, flattest: float, lowest: float) -> tuple[Indices, Floats, Indices, Floats]:
    """The fields with cells of a size (K,), and their nodes (N, 3), corners (8, K) and shares (8, K)."""
    which = np.flatnonzero(fields.cell == size)
    steps, base = (
        np.array([size, size, min(UPRIGHT * size, flattest)]),
        np.array([0.0, 0.0, lowest if np.isfinite(lowest) else 0.0]),
    )
    place = (fields.position[which] - base) / steps
    cell = np.floor(place).astype(np.int64)
    if np.isfinite(lowest):
        cell[:, 2] = np.maximum(cell[:, 2], 0)
    inside, first = place - cell, cell.min(axis=0, initial=0)
    extent = cell.max(axis=0, initial=0) - first + 2
    strides = np.array([extent[1] * extent[2], extent[2], 1])
    number = (cell - first) @ strides
    corners = list(product((0, 1), repeat=3))
    places = np.stack([number + np.array(corner) @ strides for corner in corners])
    shares = np.stack([np.prod(np.where(corner, inside, 1.0 - inside), axis=1) for corner in corners])
    used = np.flatnonzero(np.bincount(places.ravel(), minlength=int(np.prod(extent))))
    index = np.empty(int(np.prod(extent)), dtype=np.int64)
    index[used] = np.arange(len(used))
    nodes = np.stack(np.unravel_index(used, tuple(extent)), axis=1) + first
    return which, nodes * steps + base, index[places], shares


def _joined(parts: list[tuple[Indices, Floats, Indices, Floats]], count: int) -> Lattice:
    corner, share, nodes, first = np.zeros((8, count), dtype=np.int64), np.zeros((8, count)), [np.zeros((0, 3))], 0
    for which, points, corners, shares in parts:
        corner[:, which], share[:, which] = corners + first, shares
        nodes.append(points)
        first += len(points)
    return Lattice(np.concatenate(nodes), corner, share)


def strongest(level: Floats) -> NDArray[np.int64]:
    """Indices of amplitudes (C,), in their order, without the faintest that add up to DROPPED of the strongest."""
    order = np.argsort(level)
    faint = int(np.searchsorted(np.cumsum(level[order]), DROPPED * level.max(initial=0.0), side="right"))
    return np.sort(order[faint:])
