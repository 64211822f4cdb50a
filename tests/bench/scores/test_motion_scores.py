"""The motion of tracks, by hand: after one and three minutes, and after a turn."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.motion_scores import QUANTITIES, motion_scores, target_errors
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.trackers.tracker import TrackState
from tests.bench.scores.test_scoring import given, results, track, truth

KNOT = 1852.0 / 3600.0


def motion(run: Sequence[ScanResult]) -> dict[str, float | None]:
    return motion_scores(judged(run))


def test_no_track_has_no_motion_error() -> None:
    run = [replace(result, tracks=()) for result in results(scans=90)]
    assert motion(run)["true_course_deg_1min"] is None
    assert motion(results(scans=10)) == {}  # shorter than a minute


def test_motion_errors_are_those_of_the_worst_target() -> None:
    """Tracks 3 m and 4 m off on the right course: nothing but range and bearing errs."""
    errors = motion(results(scans=90))
    assert {f"{name}_{minutes}min" for name in QUANTITIES for minutes in (1, 3)} | {"velocity_kn_median"} == set(errors)
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
    assert "course_after_turn_deg" not in motion(turning(4.0, 80))  # 90 s + 120 s are 84 scans
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
