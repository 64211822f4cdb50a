"""One received spoke, and the spokes of a message."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.stream.codecs.native import wire


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
    samples, labels, powers = wire.samples(message), wire.labels(message), wire.powers(message)
    azimuth, heading, course = (wire.radians_from_turn(message[key]) for key in ("azimuth", "heading", "course"))
    step = float(message["range_step_m"])
    ranges = float(message["range_first_m"]) + step * np.arange(samples.shape[1], dtype=np.float64)
    blind = message.get("blind") or [False] * len(samples)
    offset = message.get("row_first") or range(len(samples))
    return [
        ReceivedSpoke(
            message["epoch"], message["first"] + offset[k], message["scan"], message["index"] + offset[k],
            float(message["time"][k]), float(azimuth[k]), float(heading[k]),
            (float(message["position"][k][0]), float(message["position"][k][1])), float(course[k]),
            float(message["speed"][k]), ranges, step, samples[k], bool(blind[k]),
            None if labels is None else labels[k],
            None if powers is None else {number: power[k] for number, power in powers.items()},
        )
        for k in range(len(samples))
    ]  # fmt: skip


def label_names(hello: dict[str, Any]) -> dict[int, str]:
    """Returns the name of each source of a hello by its number; empty where no labels or powers were requested."""
    return {int(source["number"]): str(source["name"]) for source in hello.get("sources", ())}
