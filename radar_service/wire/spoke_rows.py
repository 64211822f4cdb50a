"""The rows of a `spokes` message as arrays, in SI units and radians: the one place where such a message is decoded."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Floats, Indices
from radar_service.wire import format as wire


@dataclass(frozen=True)
class SpokeRows:
    """K rows of N samples. A row is a spoke, or several merged ones (`spokes` of a view).

    number: (K,) sequence number within the epoch, of the first spoke of each row.
    index: (K,) row within the scan; row 0 points north.
    time: (K,) [s]; azimuth, heading, course: (K,) [rad]; heading and course are NaN while the radar has lost the heading.
    speed: (K,) [m/s]; position: (K, 2) of own ship, east and north [m].
    blind: (K,).
    range: (N,) [m] of the samples, `range_step` apart.
    samples: (K, N) in the encoding of the message.
    labels: (K, N) number of the strongest source; powers: (K, N) [W] of each source by its number; None where not requested.
    """

    number: Indices
    index: Indices
    time: Floats
    azimuth: Floats
    heading: Floats
    course: Floats
    speed: Floats
    position: Floats
    blind: Flags
    range: Floats
    range_step: float
    samples: NDArray[Any]
    labels: NDArray[np.uint32] | None
    powers: dict[int, NDArray[np.float32]] | None

    @classmethod
    def of(cls, message: dict[str, Any]) -> Self:
        """The rows of a message. Raises ValueError where the lengths of its fields disagree."""
        samples = wire.samples(message)
        offset = np.array(message.get("row_first") or range(len(samples)), dtype=np.int64)
        step = float(message["range_step_m"])
        blind = message.get("blind") or [False] * len(samples)
        return cls(
            number=message["first"] + offset, index=message["index"] + offset, time=_floats(message["time"]),
            azimuth=_angles(message, "azimuth"), heading=_angles(message, "heading"), course=_angles(message, "course"),
            speed=_floats(message["speed"]), position=_floats(message["position"]).reshape(-1, 2),
            blind=np.array(blind, dtype=np.bool_),
            range=float(message["range_first_m"]) + step * np.arange(samples.shape[1], dtype=np.float64), range_step=step,
            samples=samples, labels=wire.labels(message), powers=wire.powers(message),
        )  # fmt: skip


def _floats(values: Any) -> Floats:
    return np.array(values, dtype=np.float64)


def _angles(message: dict[str, Any], key: str) -> Floats:
    """Angles [rad]; recordings have them exactly."""
    exact = message.get(f"{key}_rad")
    return wire.radians_from_turn(message[key]) if exact is None else _floats(exact)
