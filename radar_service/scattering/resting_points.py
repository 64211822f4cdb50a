"""Points of diffuse surfaces that rest on the map, cell by cell, so that those in a sector are found without the others."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Floats, Indices, Profiles, Singles
from radar_service.scattering.model import BearingWedge, ScatteringModel

CELL = 128.0  # m: points in such a square of the map are chosen together


@dataclass(frozen=True)
class MapCells:
    """Squares (C,) of the map that hold points one after the other. first: (C + 1,) first point of each, and the end; middle:
    (C, 2) of each [m]."""

    first: Indices
    middle: Floats

    @classmethod
    def of(cls, position: Floats) -> tuple["MapCells", Indices]:
        """The cells of positions (E, 3) [m], and the order (E,) in which they hold them."""
        number = np.floor(position[:, :2] / CELL).astype(np.int64)
        lowest = number.min(axis=0)
        number -= lowest
        cell = number[:, 0] * (number[:, 1].max() + 1) + number[:, 1]
        short = np.int16 if cell.max() < 2**15 else np.int64  # 16 bits sort in a tenth of the time
        order = np.argsort(cell.astype(short), kind="stable")
        begins = np.flatnonzero(np.diff(cell[order], prepend=-1))
        return cls(np.append(begins, len(order)), (number[order[begins]] + lowest + 0.5) * CELL), order

    def within(self, wedge: BearingWedge) -> tuple[Indices, Indices]:
        """First points (N,) of all cells that have a part in a wedge, and their ends (N,)."""
        cells = np.flatnonzero(wedge.contains(self.middle, CELL * np.sqrt(0.5)))
        return self.first[cells], self.first[cells + 1]


@dataclass(frozen=True)
class RestingPoints:
    """Points (E,) of bodies at rest, cell by cell.

    cells: that hold them.
    position: (E, 3) on the map [m].
    normal: (E, 3) there.
    triangle: (E,) that each lies on, in its body's mesh.
    body: (E,) index among the model's bodies.
    one_sided: (E,) whether its surface reflects on one side alone.
    lift: (E,) height over the point of the middle of what it stands for [m].
    span: (E,) vertical extent of that [m].
    strength: (E,) root of the cross-section of one that faces the antenna [m], with its phase.
    """

    cells: MapCells
    position: Floats
    normal: Singles
    triangle: NDArray[np.int32]
    body: NDArray[np.int32]
    one_sided: Flags
    lift: Singles
    span: Singles
    strength: Profiles

    def __len__(self) -> int:
        return len(self.span)


class RestingModel(ScatteringModel, Protocol):
    """A model whose bodies, where they rest, are points that neither fluctuate nor have an aspect."""

    def resting_points(self) -> RestingPoints:
        """The points of all its bodies, which rest."""
        ...
