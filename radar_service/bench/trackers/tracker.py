"""What a tracker gets and gives: the plots of one scan, and the states of its tracks."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from radar_service.plots.plot import Plot


@dataclass(frozen=True, kw_only=True)
class TrackerInput:
    """The plots of one scan, and own ship as her sensors report her at the end of it. SI, angles [rad] from true north.

    scan: its number.
    time: end of the scan [s].
    east, north: position of own ship [m].
    heading, course, speed: of own ship.
    plots: by time.
    """

    scan: int
    time: float
    east: float
    north: float
    heading: float
    course: float
    speed: float
    plots: tuple[Plot, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data: the names of the fields, and `type`."""
        return {"type": "scan", **asdict(self)}


@dataclass(frozen=True, kw_only=True)
class TrackState:
    """A confirmed track after one scan. track: its name, the same in all scans; time: of the state [s]; SI on the map."""

    track: str
    time: float
    east: float
    north: float
    velocity_east: float
    velocity_north: float


class Tracker(Protocol):
    """Any tracker. One object tracks one run."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Takes the plots of the next scan; returns the states of all confirmed tracks, best at the time of their plot."""
