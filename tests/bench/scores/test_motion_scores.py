"""The motion of tracks, by hand: after one and three minutes, and after a turn."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.motion_scores import QUANTITIES, motion_scores, target_errors
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.trackers.tracker import TrackState
from tests.bench.scores.test_scoring import given, results, track, truth

KNOT = 1852.0 / 3600.0
ALWAYS = {"velocity_kn_median", "velocity_kn_95", "delay_s", "trend_s", "vector_s"}


def motion(run: Sequence[ScanResult]) -> dict[str, float | None]:
    return motion_scores(judged(run))


def test_no_track_has_no_motion_error() -> None:
    run = [replace(result, tracks=()) for result in results(scans=90)]
    assert motion(run)["true_course_deg_1min"] is None
    assert motion(results(scans=10)) == {}  # shorter than a minute


def test_motion_errors_are_those_of_the_worst_target() -> None:
    """Tracks 3 m and 4 m off on the right course: nothing but range and bearing errs."""
    errors = motion(results(scans=90))
    assert {f"{name}_{minutes}min" for name in QUANTITIES for minutes in (1, 3)} | ALWAYS == set(errors)
    assert errors["true_course_deg_3min"] == pytest.approx(0.0, abs=1e-9) and errors["true_speed_kn_1min"] == pytest.approx(
        0.0
    )
    assert 0.0 < (errors["bearing_deg_1min"] or 0.0) < np.degrees(4.0 / 1000.0) + 0.01


def test_errors_of_one_target_by_hand() -> None:
    """A target east at 3 knots, 1 NM north of own ship at rest, tracked 1 degree and 1 knot off."""
    of = TargetTruth(
        body="t", time=0.0, position=(0.0, 1852.0), velocity=(3 * KNOT, 0.0), own_position=(0.0, 0.0), own_velocity=(0.0, 0.0),
        visible=True,
    )  # fmt: skip
    angle = np.radians(91.0)
    made = TrackState(
        track="1",
        time=0.0,
        east=0.0,
        north=1862.0,
        velocity_east=4 * KNOT * np.sin(angle),
        velocity_north=4 * KNOT * np.cos(angle),
    )
    errors = target_errors(made, of, replace(given(0), time=0.0))
    assert errors["true_course_deg"] == errors["relative_course_deg"] == pytest.approx(1.0)
    assert errors["true_speed_kn"] == errors["relative_speed_kn"] == pytest.approx(1.0)
    assert errors["range_m"] == pytest.approx(10.0) and errors["bearing_deg"] == pytest.approx(0.0)
    assert errors["cpa_nm"] == pytest.approx(abs(1862.0 * np.cos(np.radians(1.0)) - 1852.0) / 1852.0, abs=1e-6)
    assert errors["tcpa_min"] == pytest.approx(1862.0 * np.sin(np.radians(1.0)) / (4 * KNOT) / 60.0, rel=1e-6)


def test_a_target_at_rest_has_no_course_and_no_tcpa_and_the_others_are_judged() -> None:
    run = []
    for scan in range(40):
        at_rest, moving = truth("hull", 2.5 * scan, 0.0, 900.0, speed=0.0), truth("ship", 2.5 * scan, -3000.0, 2000.0)
        tracks = (replace(track("a", at_rest), velocity_east=0.1), track("b", moving, north=1.0))
        run.append(ScanResult(given(scan), tracks, (at_rest, moving)))
    both, alone = motion(run), motion([replace(one, truths=one.truths[:1]) for one in run])
    assert both["true_course_deg_1min"] == pytest.approx(0.0, abs=1e-9) and both["tcpa_min_1min"] == pytest.approx(
        0.0, abs=1e-9
    )
    assert both["true_speed_kn_1min"] == pytest.approx(0.1 / KNOT)
    assert alone["true_course_deg_1min"] is alone["relative_course_deg_1min"] is alone["tcpa_min_1min"] is None
    silent = [replace(one, tracks=(one.tracks[0], replace(one.tracks[1], velocity_east=0.0))) for one in run]
    assert motion(silent)["tcpa_min_1min"] is None  # a track that claims rest gives no TCPA of a target that has one


def turning(error_deg: float, scans: int = 100) -> list[ScanResult]:
    """A ship at 10 m/s that turns from north to east in 60 to 90 s; the course of her track errs."""
    made, position = [], np.array([0.0, 1000.0])
    for scan in range(scans):
        course = math.radians(3.0 * min(max(2.5 * scan - 60.0, 0.0), 30.0))
        velocity = 10.0 * np.array([math.sin(course), math.cos(course)])
        here = replace(truth("ship", 2.5 * scan, 0.0, 0.0), position=tuple(position), velocity=tuple(velocity))
        wrong = course + math.radians(error_deg)
        state = replace(track("1", here), velocity_east=10.0 * math.sin(wrong), velocity_north=10.0 * math.cos(wrong))
        made.append(ScanResult(given(scan), (state,), (here,)))
        position = position + 2.5 * velocity
    return made


def test_the_course_is_judged_two_minutes_after_a_turn() -> None:
    assert motion(turning(4.0))["course_after_turn_deg"] == pytest.approx(4.0)
    assert motion(turning(4.0, 85))["course_after_turn_deg"] == pytest.approx(4.0)  # its last scan is 90 s + 120 s
    assert "course_after_turn_deg" not in motion(turning(4.0, 84))
    assert "course_after_turn_deg" not in motion(results(scans=90))


def test_no_track_after_a_turn_has_no_course() -> None:
    run = [replace(one, tracks=()) if one.given.scan > 50 else one for one in turning(0.0)]
    assert motion(run)["course_after_turn_deg"] is None


def test_the_error_of_a_velocity_is_that_of_the_vector() -> None:
    """4 degrees of 10 m/s."""
    assert motion(turning(4.0))["velocity_kn_1min"] == pytest.approx(20.0 * math.sin(math.radians(2.0)) / KNOT)


def test_a_target_that_comes_late_is_judged_by_its_own_minutes() -> None:
    """She is seen from scan 20 on: her first minute ends with scan 44, when her track errs by 1 m/s."""
    made = []
    for scan in range(60):
        late = replace(truth("late", 2.5 * scan, 0.0, 2000.0), visible=scan >= 20)
        state = replace(track("1", late), velocity_north=1.0 if scan == 43 else 0.0)
        made.append(ScanResult(given(scan), (state,) if scan >= 22 else (), (late,)))
    assert motion(made)["velocity_kn_1min"] == pytest.approx(1.0 / KNOT)


@pytest.mark.parametrize(("share", "expected"), [(0.4, 0.0), (0.6, 10.0), (1.0, 10.0)])
def test_a_velocity_is_judged_in_most_scans(share: float, expected: float) -> None:
    """The first of two tracks has 10 kn too much in a share of the scans in which a state is owed; before them it may."""
    run = results(scans=90)
    due = [number for number, scan in enumerate(judged(run).scans) if scan.due]
    wrong = {*range(due[0]), *due[: round(share * len(due))]}

    def spoilt(number: int, result: ScanResult) -> ScanResult:
        first, *others = result.tracks
        more = 10.0 * KNOT if number in wrong else 0.0
        at_its_end = replace(first, velocity_east=first.velocity_east + more)
        moved = replace(at_its_end, east=first.east - more * (result.given.time - first.time))
        return replace(result, tracks=(moved, *others))

    assert motion([spoilt(*each) for each in enumerate(run)])["velocity_kn_median"] == pytest.approx(expected, abs=1e-6)


def test_a_target_without_a_track_in_most_scans_has_no_velocity() -> None:
    run = [replace(result, tracks=result.tracks if number < 40 else ()) for number, result in enumerate(results(scans=90))]
    assert motion(run)["velocity_kn_median"] is None


def steered(course: Callable[[float], float], late: float = 0.0, reversed_every: int = 0) -> list[ScanResult]:
    """A target at 10 m/s whose course is a function of time [rad], with a track that is so late [s]; its velocity is reversed in
    every so many scans."""
    step = 0.01
    time = np.arange(-20.0, 260.0, step)
    courses = np.array([course(at) for at in time])
    path = np.cumsum(10.0 * step * np.stack([np.sin(courses), np.cos(courses)], axis=1), axis=0)

    def at(when: float) -> tuple[tuple[float, float], tuple[float, float]]:
        place = round((when + 20.0) / step)
        return tuple(path[place].tolist()), (10.0 * math.sin(courses[place]), 10.0 * math.cos(courses[place]))

    made = []
    for scan in range(100):
        end = 2.5 * (scan + 1)
        position, velocity = at(end)
        (east, north), (v_east, v_north) = at(end - late)
        sign = -1.0 if reversed_every and scan % reversed_every == 0 else 1.0
        one = replace(truth("t", end, 0.0, 0.0), position=position, velocity=velocity)
        state = TrackState(
            track="1", time=end, east=east, north=north, velocity_east=sign * v_east, velocity_north=sign * v_north
        )
        made.append(ScanResult(given(scan), (state,), (one,)))
    return made


def test_a_track_that_is_lost_in_turns_to_both_sides_has_no_lag() -> None:
    run = steered(lambda time: math.radians(min(max(time - 60.0, 0.0), 60.0) - min(max(time - 140.0, 0.0), 60.0)), late=2.5)
    assert motion(run)["turn_lag_s"] == pytest.approx(2.5, abs=0.5)
    lost = [one if one.given.scan in (34, 65) else replace(one, tracks=one.tracks + beside(one).tracks) for one in run]
    both = [replace(one, truths=one.truths + beside(other).truths) for one, other in zip(lost, run, strict=True)]
    assert motion(both)["turn_lag_s"] is None


def beside(one: ScanResult) -> ScanResult:
    """The same target and track under other names, far away."""
    (truth,), (state,) = one.truths, one.tracks
    moved = (truth.position[0] + 9000.0, truth.position[1])
    return replace(
        one,
        truths=(replace(truth, body="u", position=moved),),
        tracks=(replace(state, track="2", east=state.east + 9000.0),),
    )


def test_a_late_track_is_as_late_as_it_is() -> None:
    """By least squares along its course; in a turn of 90 degrees in 90 s by its course, which errs by as many degrees."""
    straight = motion(steered(lambda time: 0.3, late=2.5))
    assert straight["delay_s"] == pytest.approx(2.5, rel=1e-3) and "turn_lag_s" not in straight
    turned = motion(steered(lambda time: math.radians(min(max(time - 100.0, 0.0), 90.0)), late=7.0))
    assert turned["turn_lag_s"] == pytest.approx(7.0, abs=0.5)
    assert turned["turn_course_deg"] == pytest.approx(7.0, abs=0.5)
    assert "trend_s" not in turned and (turned["velocity_kn_95"] or 0.0) < 1e-6  # what turns is judged as turning


def test_a_velocity_that_is_reversed_in_one_scan_of_ten_is_seen_in_95_percent() -> None:
    errors = motion(steered(lambda time: 0.3, reversed_every=10))
    assert errors["velocity_kn_median"] == pytest.approx(0.0, abs=1e-9)
    assert errors["velocity_kn_95"] == pytest.approx(20.0 / KNOT)
    assert errors["trend_s"] is None or errors["trend_s"] > 120.0


def test_trend_and_vector_are_counted_from_the_acquisition() -> None:
    """The track comes with scan 4, knows nothing of its velocity to scan 39, and then all."""
    run = steered(lambda time: 0.3)
    lame = [replace(one, tracks=(replace(one.tracks[0], velocity_east=0.0),) if k >= 4 else ()) for k, one in enumerate(run)]
    errors = motion([*lame[:40], *run[40:]])
    assert errors["trend_s"] == errors["vector_s"] == 2.5 * (40 - 4)
    assert motion(lame)["trend_s"] is None  # never
    assert "vector_s" in motion(run[:73]) and "vector_s" not in motion(run[:72])  # too short for three minutes
    quick = [replace(one, truths=(replace(one.truths[0], time=0.9 * k),)) for k, one in enumerate(turning(0.0))]
    assert "trend_s" not in motion(quick)  # 67 scans a minute show a turn too
