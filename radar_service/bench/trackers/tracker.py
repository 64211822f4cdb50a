"""What a tracker gets and gives: the plots of one scan, and the states of its tracks, which may be moved on to another time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, Protocol

import numpy as np

from radar_service.numerics import Floats
from radar_service.plots import Plot

CPA_LIMIT, TCPA_LIMIT = 3704.0, 1800.0  # m, s: of alarms, as a user sets them
Vector = Floats | Sequence[float]


@dataclass(frozen=True, kw_only=True)
class DataSheet:
    """What a tracker is told of its radar before the first scan: all that it may be tuned by. SI, angles [rad].

    rpm: turns of the antenna in a minute.
    beamwidth: horizontal, one-way half power.
    cell: size of a range cell [m].
    range_max: far end of the profile [m].
    range_error, bearing_error: standard deviations of the plots of points.
    glint: standard deviation along which the echo of a ship wanders [m], above its plot's errors; 0 of points.
    false_plots: mean number of a scan, of noise and other objects; those of sea, rain and land come on top.
    sensors: profile of the errors of own ship's sensors, as `imo-2004`; "none" where they are true.
    cpa_limit, tcpa_limit: of alarms, where a tracker gives any [m], [s].
    """

    rpm: float = 24.0
    beamwidth: float = 0.026
    cell: float = 5.0
    range_max: float = 4000.0
    range_error: float = 5.0
    bearing_error: float = 0.00175
    glint: float = 0.0
    false_plots: float = 0.0
    sensors: str = "none"
    cpa_limit: float = CPA_LIMIT
    tcpa_limit: float = TCPA_LIMIT

    @property
    def clutter(self) -> float:
        """False plots of a scan for each m^2 of the range that it covers."""
        return self.false_plots / (math.pi * self.range_max**2)


@dataclass(frozen=True, kw_only=True)
class AisTarget:
    """A report of an AIS target: its state at a time [s], on the map. SI, angles [rad]. station_class: A, B-SO or B-CS."""

    time: float
    mmsi: int
    east: float
    north: float
    speed: float
    course: float
    station_class: str


@dataclass(frozen=True, kw_only=True)
class TrackerInput:
    """The plots of one scan, and own ship as its sensors report it at the end of it. SI, angles [rad] from true north.

    scan: its number.
    time: end of the scan [s].
    east, north: position of own ship [m].
    heading, course, speed: of own ship.
    plots: by time.
    ais: reports received in the scan; None: the scenario has no AIS.
    orders: of the user at its end, as docs/bench.md has them; None: the user gives none in it.
    """

    scan: int
    time: float
    east: float
    north: float
    heading: float
    course: float
    speed: float
    plots: tuple[Plot, ...]
    ais: tuple[AisTarget, ...] | None = None
    orders: tuple[Mapping[str, Any], ...] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data: the names of the fields, and `type`; without what is None."""
        return {"type": "scan", **{key: value for key, value in asdict(self).items() if value is not None}}


@dataclass(frozen=True, kw_only=True)
class TrackState:
    """A confirmed track after one scan. SI on the map.

    track: its name, the same in all scans.
    time: of the state [s], none after the end of the scan.
    coasting: whether the track goes on without plots, so that its state may be older than three scans.
    cpa, tcpa: closest approach to own ship [m] and time to it from the end of the scan [s], negative where it is over.
    alarm: whether both are within the limits of the data sheet.
    lost: whether this is its last state, as its target is lost.
    full: whether the tracker can follow no more.
    mmsi: of the AIS target that is associated with it.
    priority: whose data are displayed, "ais" or "radar".
    acquired: how, "automatic" (in the zone) or "manual".
    None of these eight: the tracker does not say, and is not judged.
    """

    track: str
    time: float
    east: float
    north: float
    velocity_east: float
    velocity_north: float
    coasting: bool = False
    cpa: float | None = None
    tcpa: float | None = None
    alarm: bool | None = None
    lost: bool | None = None
    full: bool | None = None
    mmsi: int | None = None
    priority: Literal["ais", "radar"] | None = None
    acquired: Literal["automatic", "manual"] | None = None


class Tracker(Protocol):
    """Any tracker. One object tracks one run."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Takes the plots of the next scan; returns the states of all confirmed tracks, best at the time of their plot."""


def begin_run(tracker: Tracker, sheet: DataSheet) -> None:
    """Tells a tracker its radar before the first scan, where it has a method of this name."""
    if callable(begin := getattr(tracker, "begin_run", None)):
        begin(sheet)


def moved_on(position: Vector, velocity: Vector, time: float) -> Floats:
    """Returns a position (2,) [m] after a time [s] at a velocity (2,) [m/s]; a negative time goes back."""
    return np.asarray(position, dtype=np.float64) + time * np.asarray(velocity, dtype=np.float64)
