"""What a run of the bench gives to be scored: the truth of each target in a scan, what a tracker got, and what it answered."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from radar_service.bench.trackers.tracker import TrackerInput, TrackState, moved_on
from radar_service.numerics import Floats
from radar_service.plots import Flood


@dataclass(frozen=True, kw_only=True)
class TargetTruth:
    """A target at an instant: at its beam crossing, or at the end of a scan without one. SI; east and north.

    body: its name. time [s]. position, velocity: of its reference point. own_position, own_velocity: of own ship, truly.
    visible: whether the radar can see it. heading: of its bow [rad]. length: 0 for a point [m].
    echo: slant range [m] and bearing [rad] of its power, or of a point itself, in this crossing; None without one.
    centroid: of its power, from the reference point to the bow and to starboard [m]; None for a point, or without power.
    own_error: east and north of own ship as reported, minus true [m]. azimuth_error: reported azimuth minus true [rad].
    """

    body: str
    time: float
    position: tuple[float, float]
    velocity: tuple[float, float]
    own_position: tuple[float, float]
    own_velocity: tuple[float, float]
    visible: bool
    heading: float = 0.0
    length: float = 0.0
    echo: tuple[float, float] | None = None
    centroid: tuple[float, float] | None = None
    own_error: tuple[float, float] = (0.0, 0.0)
    azimuth_error: float = 0.0


@dataclass(frozen=True)
class ScanResult:
    """One scan of a run. given: what the tracker got; tracks: what it answered; truths: of the targets in this scan; ais_of: of
    each AIS report in `given` the target whose state it is, None: none that is there; orders: of the user, by names of
    targets; flood: of the plot extractor; seconds, memory: that the tracker took [s], and takes up [bytes] (None: not known)."""

    given: TrackerInput
    tracks: tuple[TrackState, ...]
    truths: tuple[TargetTruth, ...]
    flood: Flood | None = None
    ais_of: tuple[str | None, ...] = ()
    orders: tuple[Mapping[str, Any], ...] = ()
    seconds: float = field(default=0.0, compare=False)
    memory: int | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Surroundings:
    """Of what tracks may be false. land: places (N, 2) every 50 m of land and of other bodies at rest [m]; clutter: of the
    rest: "rain", "sea", or "noise" alone."""

    land: tuple[tuple[float, float], ...] = ()
    clutter: str = "noise"


def at_end(truth: TargetTruth, end: float) -> TargetTruth:
    """Returns a target moved on with its velocity to the end of its scan [s], and own ship with it."""
    later = end - truth.time
    return replace(
        truth, time=end, position=_pair(moved_on(truth.position, truth.velocity, later)),
        own_position=_pair(moved_on(truth.own_position, truth.own_velocity, later)),
    )  # fmt: skip


def as_reported(truth: TargetTruth) -> TargetTruth:
    """Returns a target in the frame that own ship reports: turned about it by the error of the azimuth, from where it says
    that it is. That is where plots and tracks of it are, and no tracker can know better."""
    own, own_velocity = np.array(truth.own_position), np.array(truth.own_velocity)
    position = own + truth.own_error + _turned(truth.position - own, truth.azimuth_error)
    velocity = own_velocity + _turned(truth.velocity - own_velocity, truth.azimuth_error)
    return replace(truth, position=_pair(position), velocity=_pair(velocity))


def _turned(vector: Floats, angle: float) -> Floats:
    """A vector (2,), east and north, turned clockwise by an angle [rad]."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return np.array([vector[0] * cosine + vector[1] * sine, vector[1] * cosine - vector[0] * sine])


def _pair(vector: Floats) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])
