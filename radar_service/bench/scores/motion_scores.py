"""How well tracks know the motion of their targets: after one and three minutes, after a turn, and in most scans."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from radar_service.bench.scores.judged_scan import JudgedRun, JudgedScan
from radar_service.bench.scores.scan_result import TargetTruth
from radar_service.bench.scores.set_scores import velocity_error
from radar_service.bench.scores.sightings import Sightings
from radar_service.bench.trackers.tracker import TrackerInput, TrackState, Vector, moved_on
from radar_service.numerics import KNOT, NAUTICAL_MILE, Floats, wrap_angle
from radar_service.truth.crossings import closest_approach

MINUTES = (1, 3)
AFTER_TURN = 120.0  # s after which the course of a target that has turned is judged
TURN_RATE = math.radians(0.1)  # rad/s: a slower change of course is no turn
TURN = math.radians(10.0)  # a smaller change of course is none either
TIMES = {"trend_s": (1.5, 60.0), "vector_s": (0.8, 180.0)}  # most error [kn], and time that MSC.192(79) 5.25.4 gives [s]
UNDER_WAY = 0.5  # m/s: slower targets have no course to judge
QUANTITIES = (
    "relative_course_deg", "relative_speed_kn", "cpa_nm", "tcpa_min", "true_course_deg", "true_speed_kn", "range_m",
    "bearing_deg", "velocity_kn",
)  # fmt: skip


def motion_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the errors of the motion of the worst target one and three minutes after it was seen first, after turns, and as
    the median over all scans in which its state is owed: a tracker that knows when it is judged is judged then too.

    Names: relative_course_deg_1min and so on. A target without a track has no error, which is None, and meets no limit. Targets
    that are not due then are not judged, and what no target can be judged by is left out.
    """
    metrics: dict[str, float | None] = {}
    for minutes in MINUTES:
        errors = [
            error for body, sightings in run.sightings.items() for error in _errors_after(run, body, sightings, minutes)
        ]
        for name in QUANTITIES if errors else ():
            metrics[f"{name}_{minutes}min"] = _worst([math.inf if error is None else error[name] for error in errors])
    judged = {body: _velocity_errors(run, body) for body in run.sightings}
    turning = {body: _turning(run, body) for body in run.sightings}
    in_turns = [each for body in run.sightings for each in _in_turns(run, body, turning[body])]
    several = {
        "course_after_turn_deg": [error for body in run.sightings for error in _courses_after_turns(run, body)],
        "velocity_kn_median": [float(np.median([error for _, error in some])) for some in judged.values() if some],
        "velocity_kn_95": [
            percentile_95(some) for body in judged if (some := _straight_errors(run, turning[body], judged[body]))
        ],
        "turn_lag_s": [lag for lag, _ in in_turns],
        "turn_course_deg": [error for _, error in in_turns],
        "delay_s": _delay(run),
        **{
            name: [time for body in judged if not turning[body] for time in _time_to(run, body, *of)]
            for name, of in TIMES.items()
        },
    }
    return metrics | {name: _worst(values) for name, values in several.items() if values}


def percentile_95(values: Sequence[float]) -> float:
    """Returns the 95th percentile, which is one of the values: nothing is computed of inf."""
    return float(np.percentile(values, 95.0, method="higher"))


def _turning(run: JudgedRun, body: str) -> dict[int, float]:
    """The scans in which a target turns, with its rate [rad/s] to starboard; none where it turns by less than TURN in all."""
    steps = [*_steps(run, body)]
    turned = {k: change / time for k, change, time in steps if time > 0.0 and abs(change) > TURN_RATE * time}
    return turned if sum(abs(change) for k, change, _ in steps if k in turned) > TURN else {}


def _straight_errors(run: JudgedRun, turning: Iterable[int], errors: Sequence[tuple[int, float]]) -> list[float]:
    """The errors of the velocity [kn] in scans before which the target has kept its course for AFTER_TURN."""
    ends = [scan.result.given.time for scan in run.scans]
    turned = np.array([ends[k] for k in turning])
    return [error for k, error in errors if not ((ends[k] - turned >= 0.0) & (ends[k] - turned < AFTER_TURN)).any()]


def _in_turns(run: JudgedRun, body: str, turning: Mapping[int, float]) -> Iterator[tuple[float, float]]:
    """How late the course of a track is in turns [s], by least squares, and its largest error [deg]; inf without a track."""
    lags = []
    for k, rate in turning.items():
        scan = run.scans[k]
        if body in scan.due and body in scan.pairs:
            track, (east, north) = scan.tracks[scan.pairs[body]], scan.truths[body].velocity
            behind = math.atan2(east, north) - math.atan2(track.velocity_east, track.velocity_north)
            lags.append((rate, float(wrap_angle(np.asarray(behind)))))
        elif body in scan.due:
            lags.append((rate, math.copysign(math.inf, rate)))  # so that turns to both sides add up
    if lags:
        lag = sum(rate * behind for rate, behind in lags) / sum(rate**2 for rate, _ in lags)
        yield abs(lag), math.degrees(max(abs(behind) for _, behind in lags))


def _delay(run: JudgedRun) -> list[float]:
    """The shift of all tracks along their courses [s], by least squares."""
    behind = speed = 0.0
    for scan in run.scans:
        for body in scan.due & scan.pairs.keys():
            truth, track = scan.truths[body], scan.tracks[scan.pairs[body]]
            velocity = np.array(truth.velocity)
            behind += float((np.array(truth.position) - (track.east, track.north)) @ velocity)
            speed += float(velocity @ velocity)
    return [abs(behind) / speed] if speed > 0.0 else []


def _time_to(run: JudgedRun, body: str, most: float, within: float) -> Iterator[float]:
    """The time [s] from the acquisition of a target until 95 % of errors [kn] are below the most; inf for never; nothing where
    the run ends `within` that time [s]."""
    first = next((k for k, scan in enumerate(run.scans) if body in scan.pairs), None)
    if first is None or not run.sightings[body].due:
        return
    scans = run.scans[first : run.sightings[body].last + 1]
    errors = [velocity_error(scan, body) / KNOT if body in scan.pairs else math.inf for scan in scans]
    times = [scan.result.given.time - scans[0].result.given.time for scan in scans]
    good = [at for at, error in enumerate(errors) if error <= most and np.mean(np.array(errors[at:]) > most) <= 0.05]
    if times and times[-1] >= within:
        yield times[good[0]] if good else math.inf


def _worst(errors: Sequence[float]) -> float | None:
    """The largest error: nan, where the truth has no such quantity, does not count; inf, a missing answer, gives None."""
    worst = max((error for error in errors if not math.isnan(error)), default=math.inf)
    return worst if math.isfinite(worst) else None


def _errors_after(run: JudgedRun, body: str, sightings: Sightings, minutes: int) -> Iterator[Mapping[str, float] | None]:
    """The errors of a target's motion in the first scan that ends so long after its first sight; None where it has no track;
    nothing where the scan is not in the run, or the target not due in it."""
    truth = _truth(run.scans[sightings.first], body)
    begin = truth.time + 60.0 * minutes
    scan = next((k for k, scan in enumerate(run.scans) if scan.result.given.time >= begin), None)
    if scan is not None and scan in sightings.due:
        yield _errors(run.scans[scan], body)


def _errors(scan: JudgedScan, body: str) -> Mapping[str, float] | None:
    if body not in scan.pairs:
        return None
    errors = target_errors(scan.tracks[scan.pairs[body]], _truth(scan, body), scan.result.given)
    return errors | {"velocity_kn": velocity_error(scan, body) / KNOT}


def _velocity_errors(run: JudgedRun, body: str) -> list[tuple[int, float]]:
    """The scans in which the state of a target is owed, with the errors of its velocity [kn]; inf without a track."""
    due = [(k, scan) for k, scan in enumerate(run.scans) if body in scan.due]
    return [(k, velocity_error(scan, body) / KNOT if body in scan.pairs else math.inf) for k, scan in due]


def _truth(scan: JudgedScan, body: str) -> TargetTruth:
    """A target as it truly is, at its own time."""
    return next(truth for truth in scan.result.truths if truth.body == body)


def _courses_after_turns(run: JudgedRun, body: str) -> Iterator[float]:
    """The errors of the course [deg], as own ship reports it, AFTER_TURN after each turn of a target; inf without a track."""
    for end in _turns(run, body):
        begin = run.scans[end].result.given.time + AFTER_TURN
        later = [k for k in range(end, len(run.scans)) if run.scans[k].result.given.time >= begin]
        if later and all(k in run.sightings[body].due for k in range(end, later[0] + 1)):
            scan = run.scans[later[0]]
            track = scan.tracks.get(scan.pairs.get(body, ""))
            velocity = np.array([track.velocity_east, track.velocity_north]) if track else None
            yield math.inf if velocity is None else _angle_between(velocity, np.array(scan.truths[body].velocity))


def _turns(run: JudgedRun, body: str) -> Iterator[int]:
    """The scans in which a target ends a turn after which it keeps its course for AFTER_TURN."""
    turned, last, end = 0.0, 0.0, 0
    for scan, change, lasting in _steps(run, body):
        time = run.scans[scan].result.given.time
        if abs(change) > TURN_RATE * lasting:
            turned, last, end = turned + change, time, scan
        elif abs(turned) > TURN and time - last >= AFTER_TURN:
            yield end
            turned = 0.0


def _steps(run: JudgedRun, body: str) -> Iterator[tuple[int, float, float]]:
    """Each scan of a target but its first, with its change of course [rad] and the time [s] since the one before."""
    path = [(k, _truth(scan, body)) for k, scan in enumerate(run.scans) if body in scan.truths]
    for (_, before), (k, after) in zip(path, path[1:], strict=False):
        yield k, _course_change(before, after), after.time - before.time


def _course_change(before: TargetTruth, after: TargetTruth) -> float:
    """How far a target has turned [rad], to starboard; 0 where it hardly moves."""
    if min(math.hypot(*before.velocity), math.hypot(*after.velocity)) < UNDER_WAY:
        return 0.0
    courses = [math.atan2(*truth.velocity) for truth in (before, after)]
    return float(wrap_angle(np.asarray(courses[1] - courses[0])))


def target_errors(track: TrackState, truth: TargetTruth, own: TrackerInput) -> dict[str, float]:
    """Returns the errors of QUANTITIES but the last, none below 0, at the track's time. own: as its sensors report it.

    nan: the truth has no such quantity, as the course of a body at rest; inf: the truth has a TCPA and the track has none.
    """
    later = track.time - truth.time
    true, true_own = _after(truth.position, truth.velocity, later), _after(truth.own_position, truth.own_velocity, later)
    own_velocity = own.speed * np.array([np.sin(own.course), np.cos(own.course)])
    tracked_own = _after((own.east, own.north), own_velocity, track.time - own.time)
    tracked = np.array([[track.east, track.north], [track.velocity_east, track.velocity_north]])
    relative, true_relative = tracked - tracked_own, true - true_own
    ((cpa,), (tcpa,)), ((true_cpa,), (true_tcpa,)) = (
        closest_approach(each[:1], each[1:]) for each in (relative, true_relative)
    )
    return {
        "relative_course_deg": _angle_between(relative[1], true_relative[1]),
        "relative_speed_kn": abs(_length(relative[1]) - _length(true_relative[1])) / KNOT,
        "cpa_nm": float(abs(cpa - true_cpa)) / NAUTICAL_MILE,
        "tcpa_min": math.inf if np.isnan(tcpa) and not np.isnan(true_tcpa) else float(abs(tcpa - true_tcpa)) / 60.0,
        "true_course_deg": _angle_between(tracked[1], true[1]),
        "true_speed_kn": abs(_length(tracked[1]) - _length(true[1])) / KNOT,
        "range_m": abs(_length(relative[0]) - _length(true_relative[0])),
        "bearing_deg": _angle_between(relative[0], true_relative[0]),
    }


def _after(position: Vector, velocity: Vector, time: float) -> Floats:
    """Position and velocity (2, 2), east and north, after a time [s]."""
    return np.array([moved_on(position, velocity, time), velocity])


def _length(vector: Floats) -> float:
    return float(np.hypot(vector[0], vector[1]))


def _angle_between(estimated: Floats, true: Floats) -> float:
    """Angle [deg] between two vectors (2,); nan where the true one has no direction."""
    if not true.any():
        return math.nan
    return float(np.degrees(abs(wrap_angle(np.arctan2(estimated[0], estimated[1]) - np.arctan2(true[0], true[1])))))
