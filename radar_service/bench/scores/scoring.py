"""How well tracks follow the truth: OSPA, GOSPA and SIAP by Stone Soup, identities, and motion after one and three minutes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.trackers.tracker import TrackerInput, TrackState, distance_at, moved_on
from radar_service.numerics.constants import KNOT
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Floats
from radar_service.plots.flood import Flood
from radar_service.truth.crossings import closest_approach

CUTOFF = 200.0  # m, of OSPA and GOSPA, and of an association
ORDER = 2.0
LAST = 20  # scans that OSPA is averaged over
MINUTES = (1, 3)
NAUTICAL_MILE = 1852.0  # m
EPOCH = datetime(2000, 1, 1)


@dataclass(frozen=True, kw_only=True)
class TargetTruth:
    """A target at an instant: at its beam crossing, or at the end of a scan without one. SI; east and north.

    body: its name. time [s]. position, velocity: of its reference point. own_position, own_velocity: of own ship, truly.
    visible: whether the radar can see it. heading: of its bow [rad]. length: 0 for a point [m].
    echo: slant range [m] and bearing [rad] of its power, or of a point itself, in this crossing; None without one.
    centroid: of its power, from the reference point to the bow and to starboard [m]; None for a point, or without power.
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


@dataclass(frozen=True)
class ScanResult:
    """One scan of a run. given: what the tracker got; tracks: what it answered; truths: of the targets in this scan; flood: of
    the plot extractor, None as a rule."""

    given: TrackerInput
    tracks: tuple[TrackState, ...]
    truths: tuple[TargetTruth, ...]
    flood: Flood | None = None


def scores(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """Returns the metrics of a run by name; None where there is nothing to judge. Raises ImportError without Stone Soup."""
    return {**_set_metrics(results), **_identity_metrics(results), **motion_errors(results)}


def _set_metrics(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """OSPA, GOSPA (mean of the last scans) and SIAP. States carry a scan's time, as metrics match equal times alone; the
    measure moves the truth along its velocity to the time of the track."""
    from stonesoup.dataassociator.tracktotrack import TrackToTruth
    from stonesoup.metricgenerator.manager import MultiManager
    from stonesoup.metricgenerator.ospametric import GOSPAMetric, OSPAMetric
    from stonesoup.metricgenerator.tracktotruthmetrics import SIAPMetrics
    from stonesoup.types.groundtruth import GroundTruthPath
    from stonesoup.types.state import State
    from stonesoup.types.track import Track

    truths: dict[str, list[Any]] = {}
    tracks: dict[str, list[Any]] = {}
    for result in results:
        time = EPOCH + timedelta(seconds=result.given.time)
        for truth in result.truths:
            truths.setdefault(truth.body, []).append(State(_truth_vector(truth), timestamp=time))
        for track in result.tracks:
            tracks.setdefault(track.track, []).append(State(_track_vector(track), timestamp=time))
    manager = MultiManager(
        [
            OSPAMetric(c=CUTOFF, p=ORDER, measure=position_error), GOSPAMetric(c=CUTOFF, p=ORDER, measure=position_error),
            SIAPMetrics(position_measure=position_error, velocity_measure=velocity_error),
        ],
        associator=TrackToTruth(association_threshold=CUTOFF, measure=position_error),
    )  # fmt: skip
    manager.add_data(
        {
            "tracks": {Track(states) for states in tracks.values()},
            "groundtruth_paths": {*map(GroundTruthPath, truths.values())},
        }
    )
    metrics = manager.generate_metrics()
    ospa = [single.value for single in metrics["ospa_generator"]["OSPA distances"].value]
    gospa = [single.value["distance"] for single in metrics["gospa_generator"]["GOSPA Metrics"].value]
    siap = metrics["siap_generator"]
    return {
        "ospa_m": float(np.mean(ospa[-LAST:])), "gospa_m": float(np.mean(gospa[-LAST:])),
        "completeness": float(siap["SIAP Completeness"].value), "ambiguity": float(siap["SIAP Ambiguity"].value),
        "spurious": float(siap["SIAP Spuriousness"].value),
        "position_error_m": float(siap["SIAP Position Accuracy"].value),
        "velocity_error_m_s": float(siap["SIAP Velocity Accuracy"].value),
    }  # fmt: skip


def _truth_vector(truth: TargetTruth) -> list[float]:
    return [truth.position[0], truth.velocity[0], truth.position[1], truth.velocity[1], truth.time]


def _track_vector(track: TrackState) -> list[float]:
    return [track.east, track.velocity_east, track.north, track.velocity_north, track.time]


def position_error(state: Any, other: Any) -> float:
    """Returns the distance [m] of two states, the second moved along its velocity to the time of the first."""
    a, b = np.ravel(state.state_vector), np.ravel(other.state_vector)
    return distance_at(a[[0, 2]], a[4], b[[0, 2]], b[[1, 3]], b[4])


def velocity_error(state: Any, other: Any) -> float:
    """Returns the difference [m/s] of the velocities of two states."""
    a, b = np.ravel(state.state_vector), np.ravel(other.state_vector)
    return float(np.hypot(a[1] - b[1], a[3] - b[3]))


def associations(result: ScanResult) -> dict[str, TrackState]:
    """Returns the track of each target in a scan, one to one, within CUTOFF, with the least sum of distances."""
    distance = np.array([[_distance(track, truth) for track in result.tracks] for truth in result.truths])
    if not distance.size:
        return {}
    pairs = zip(*linear_sum_assignment(np.minimum(distance, CUTOFF)), strict=True)
    return {result.truths[i].body: result.tracks[j] for i, j in pairs if distance[i, j] < CUTOFF}


def _distance(track: TrackState, truth: TargetTruth) -> float:
    return distance_at((track.east, track.north), track.time, truth.position, truth.velocity, truth.time)


def _identity_metrics(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """How often the track of a target changed its name, and the share of targets held in each of the last scans."""
    names: dict[str, list[str]] = {}
    for result in results:
        for body, track in associations(result).items():
            names.setdefault(body, []).append(track.track)
    changes = sum(
        earlier != later for sequence in names.values() for earlier, later in zip(sequence, sequence[1:], strict=False)
    )
    held = [len(associations(result)) / len(result.truths) for result in results[-LAST:] if result.truths]
    return {"identity_changes": float(changes), "held": float(np.mean(held)) if held else None}


def motion_errors(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """Returns the errors of the motion of the worst target one and three minutes after its first plot could be had.

    Names: relative_course_deg_1min and so on. A target without a track has no error, which is None, and meets no limit.
    """
    first: dict[str, float] = {}
    for result in results:
        for truth in result.truths:
            first.setdefault(truth.body, truth.time)
    metrics: dict[str, float | None] = {}
    for minutes in MINUTES:
        errors = [_errors_after(results, body, start + 60.0 * minutes) for body, start in first.items()]
        if all(error is not _TOO_SHORT for error in errors) and errors:
            for name in QUANTITIES:
                metrics[f"{name}_{minutes}min"] = _worst([math.inf if error is None else error[name] for error in errors])
    return metrics


def _worst(errors: Sequence[float]) -> float | None:
    """The largest error: nan, where the truth has no such quantity, does not count; inf, a missing answer, gives None."""
    worst = max((error for error in errors if not math.isnan(error)), default=math.inf)
    return worst if math.isfinite(worst) else None


QUANTITIES = (
    "relative_course_deg", "relative_speed_kn", "cpa_nm", "tcpa_min", "true_course_deg", "true_speed_kn", "range_m",
    "bearing_deg",
)  # fmt: skip
_TOO_SHORT: Mapping[str, float] = {}


def _errors_after(results: Sequence[ScanResult], body: str, time: float) -> Mapping[str, float] | None:
    """The errors of a target's motion in the first scan that ends at `time` or later; None where it has no track."""
    for result in results:
        truth = next((truth for truth in result.truths if truth.body == body), None)
        if result.given.time >= time and truth is not None:
            track = associations(result).get(body)
            return None if track is None else target_errors(track, truth, result.given)
    return _TOO_SHORT


def target_errors(track: TrackState, truth: TargetTruth, own: TrackerInput) -> dict[str, float]:
    """Returns the errors of QUANTITIES, none below 0. own: as her sensors report her, which the tracker used.

    nan: the truth has no such quantity, as the course of a body at rest; inf: the truth has a TCPA and the track has none.
    """
    later = track.time - truth.time
    true = _Motion(np.array(truth.position), np.array(truth.velocity)).after(later)
    true_own = _Motion(np.array(truth.own_position), np.array(truth.own_velocity)).after(later)
    own_velocity = own.speed * np.array([np.sin(own.course), np.cos(own.course)])
    tracked_own = _Motion(np.array([own.east, own.north]), own_velocity).after(track.time - own.time)
    tracked = _Motion(np.array([track.east, track.north]), np.array([track.velocity_east, track.velocity_north]))
    relative, true_relative = tracked.relative_to(tracked_own), true.relative_to(true_own)
    (cpa, tcpa), (true_cpa, true_tcpa) = relative.closest_approach(), true_relative.closest_approach()
    return {
        "relative_course_deg": _angle_between(relative.velocity, true_relative.velocity),
        "relative_speed_kn": abs(_length(relative.velocity) - _length(true_relative.velocity)) / KNOT,
        "cpa_nm": abs(cpa - true_cpa) / NAUTICAL_MILE,
        "tcpa_min": math.inf if math.isnan(tcpa) and not math.isnan(true_tcpa) else abs(tcpa - true_tcpa) / 60.0,
        "true_course_deg": _angle_between(tracked.velocity, true.velocity),
        "true_speed_kn": abs(_length(tracked.velocity) - _length(true.velocity)) / KNOT,
        "range_m": abs(_length(relative.position) - _length(true_relative.position)),
        "bearing_deg": _angle_between(relative.position, true_relative.position),
    }


class _Motion(NamedTuple):
    """Position (2,) [m] and velocity (2,) [m/s], east and north."""

    position: Floats
    velocity: Floats

    def after(self, time: float) -> "_Motion":
        return _Motion(moved_on(self.position, self.velocity, time), self.velocity)

    def relative_to(self, other: "_Motion") -> "_Motion":
        return _Motion(self.position - other.position, self.velocity - other.velocity)

    def closest_approach(self) -> tuple[float, float]:
        distance, time = closest_approach(self.position[None], self.velocity[None])
        return float(distance[0]), float(time[0])


def _length(vector: Floats) -> float:
    return float(np.hypot(vector[0], vector[1]))


def _angle_between(estimated: Floats, true: Floats) -> float:
    """Angle [deg] between two vectors (2,); nan where the true one has no direction."""
    if not true.any():
        return math.nan
    return float(np.degrees(abs(wrap_angle(np.arctan2(estimated[0], estimated[1]) - np.arctan2(true[0], true[1])))))
