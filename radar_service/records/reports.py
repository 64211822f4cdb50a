"""The records of what a radar reports with a spoke, where that differs from the truth."""

from dataclasses import dataclass
from typing import Any, NamedTuple


class Readings(NamedTuple):
    """Boresight and own ship of K spokes, as sensors report them or as they are; of one spoke the values without (K,).

    azimuth: clockwise from true north (K,) [rad].
    heading, course: of own ship (K,) [rad]; NaN where the heading is lost.
    position: of own ship, east and north (K, 2) [m].
    speed: of own ship (K,) [m/s].
    """

    azimuth: Any
    heading: Any
    position: Any
    course: Any
    speed: Any

    def part(self, rows: Any) -> "Readings":
        """The readings of some rows: an index or a slice."""
        return Readings(*(column[rows] for column in self))


@dataclass(frozen=True, kw_only=True)
class ReportedOwnShip:
    """Own ship with the errors that the nearest spoke of the same scan reports.

    position: east, north, up [m].
    heading, course: [rad]; None while the heading is lost.
    speed: [m/s].
    azimuth_error: reported azimuth minus boresight [rad]; while the heading is lost, the error of the angle from the bow.
    """

    position: tuple[float, float, float]
    heading: float | None
    course: float | None
    speed: float
    azimuth_error: float


@dataclass(frozen=True, kw_only=True)
class FeedErrorCounts:
    """Number of spokes of one scan that the feed drops, repeats, sends late or out of order, sends with old echoes (stuck),
    or sends without a heading."""

    dropped: int
    repeated: int
    late: int
    out_of_order: int
    stuck: int
    heading_lost: int

    def plus(self, other: "FeedErrorCounts | None") -> "FeedErrorCounts":
        """Returns the sums with those of other spokes."""
        if other is None:
            return self
        return FeedErrorCounts(**{name: count + getattr(other, name) for name, count in vars(self).items()})
