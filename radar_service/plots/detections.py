"""Detections: the cells of scans whose power exceeds the threshold."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from radar_service.numerics import Flags, Floats, Indices

if TYPE_CHECKING:  # a tracker in a process of its own needs plots, and no pictures of scans
    from radar_service.scans import Scan


@dataclass(frozen=True)
class Detections:
    """Detected cells (C,) of consecutive scans.

    spoke: number of the spoke since the start of the simulation.
    cell: along range, from 0.
    power: [W].
    threshold: [W].
    time: of the spoke [s].
    azimuth: of the spoke, clockwise from true north [rad].
    east, north: position of own ship [m].
    """

    spoke: Indices
    cell: Indices
    power: Floats
    threshold: Floats
    time: Floats
    azimuth: Floats
    east: Floats
    north: Floats

    def __len__(self) -> int:
        return len(self.spoke)

    def only(self, which: Flags | Indices | slice) -> "Detections":
        """Returns some of the detections."""
        return Detections(*(column[which] for column in vars(self).values()))

    def and_then(self, others: "Detections") -> "Detections":
        """Returns these and others together."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Detections(*map(np.concatenate, pairs))


def detections_of(scan: "Scan", threshold: Floats) -> Detections:
    """Returns the cells of a scan whose power exceeds the threshold [W], which broadcasts to (A, N). Missing spokes have none."""
    row, cell = np.nonzero(scan.power > threshold)
    level = np.broadcast_to(threshold, scan.power.shape)[row, cell]
    return Detections(
        scan.number * len(scan.azimuth) + row, cell, scan.power[row, cell].astype(np.float64), level.astype(np.float64),
        scan.time[row], scan.azimuth[row], scan.position[row, 0], scan.position[row, 1],
    )  # fmt: skip


def no_detections() -> Detections:
    """Returns none."""
    numbers, values = np.empty(0, dtype=np.int64), np.empty(0)
    return Detections(numbers, numbers, values, values, values, values, values, values)
