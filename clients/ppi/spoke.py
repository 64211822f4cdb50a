"""One received spoke, and the spokes of a message."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.wire import SpokeRows


@dataclass(frozen=True)
class ReceivedSpoke:
    """One azimuth as it arrived, in SI units and radians.

    samples (N,) are in the encoding of the feed; `range` (N,) [m] holds their ranges. heading, course: NaN while the radar has
    lost the heading; azimuth then counts from the bow.
    """

    epoch: str
    number: int  # sequence number within the epoch
    scan: int
    index: int  # row within the scan; row 0 points north
    time: float
    azimuth: float
    heading: float
    position: tuple[float, float]  # of own ship, east and north
    course: float
    speed: float
    range: NDArray[np.float64]
    range_step: float
    samples: NDArray[Any]
    blind: bool
    labels: NDArray[np.uint32] | None = None  # (N,) number of the strongest source
    powers: dict[int, NDArray[np.float32]] | None = None  # (N,) [W] of each source, by its number


def spokes_of(message: dict[str, Any]) -> list[ReceivedSpoke]:
    """Returns the spokes of a `spokes` message. Raises ValueError if the lengths of its fields disagree."""
    rows = SpokeRows.of(message)
    return [
        ReceivedSpoke(
            message["epoch"], int(rows.number[k]), message["scan"], int(rows.index[k]), float(rows.time[k]),
            float(rows.azimuth[k]), float(rows.heading[k]), (float(rows.position[k, 0]), float(rows.position[k, 1])),
            float(rows.course[k]), float(rows.speed[k]), rows.range, rows.range_step, rows.samples[k], bool(rows.blind[k]),
            None if rows.labels is None else rows.labels[k],
            None if rows.powers is None else {number: power[k] for number, power in rows.powers.items()},
        )
        for k in range(len(rows.samples))
    ]  # fmt: skip


def label_names(hello: dict[str, Any]) -> dict[int, str]:
    """Returns the name of each source of a hello by its number; empty where no labels or powers were requested."""
    return {int(source["number"]): str(source["name"]) for source in hello.get("sources", ())}
