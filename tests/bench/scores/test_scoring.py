"""Scores of runs whose answers are known by hand."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.scoring import (
    QUANTITIES,
    ScanResult,
    TargetTruth,
    associations,
    motion_errors,
    scores,
    target_errors,
)
from radar_service.bench.trackers.tracker import TrackerInput, TrackState

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")
KNOT = 1852.0 / 3600.0


def given(scan: int, period: float = 2.5) -> TrackerInput:
    return TrackerInput(scan=scan, time=(scan + 1) * period, east=0, north=0, heading=0, course=0, speed=0, plots=())


def truth(body: str, time: float, east: float, north: float, speed: float = 10.0) -> TargetTruth:
    return TargetTruth(
        body=body, time=time, position=(east + speed * time, north), velocity=(speed, 0.0), own_position=(0.0, 0.0),
        own_velocity=(0.0, 0.0), visible=True,
    )  # fmt: skip


def track(name: str, of: TargetTruth, east: float = 0.0, north: float = 0.0, later: float = 0.0) -> TrackState:
    """A track beside a truth, at a later time on the same course."""
    return TrackState(
        track=name, time=of.time + later, east=of.position[0] + later * of.velocity[0] + east,
        north=of.position[1] + later * of.velocity[1] + north, velocity_east=of.velocity[0], velocity_north=of.velocity[1],
    )  # fmt: skip


def results(scans: int = 30, missing: bool = False, swapped_at: int | None = None, later: float = 0.0) -> list[ScanResult]:
    """Two targets 500 m apart, tracked 3 m and 4 m beside them."""
    made = []
    for scan in range(scans):
        one, two = truth("one", scan * 2.5, 0, 1000), truth("two", scan * 2.5, 0, 1500)
        names = ("1", "2") if swapped_at is None or scan < swapped_at else ("2", "1")
        tracks = [track(names[0], one, east=3.0, later=later)] + (
            [] if missing else [track(names[1], two, north=4.0, later=later)]
        )
        made.append(ScanResult(given(scan), tuple(tracks), (one, two)))
    return made


@pytest.mark.parametrize("later", [0.0, 1.7])
def test_metrics_of_two_tracks_beside_their_targets(later: float) -> None:
    """OSPA of order 2: sqrt((3^2 + 4^2) / 2). The truth moves on to the time of a track."""
    metrics = scores(results(later=later))
    assert metrics["ospa_m"] == pytest.approx(np.sqrt(12.5), rel=1e-6) and metrics["gospa_m"] == pytest.approx(5.0, rel=1e-6)
    assert metrics["position_error_m"] == pytest.approx(3.5, rel=1e-6) and metrics["velocity_error_m_s"] == pytest.approx(
        0.0, abs=1e-9
    )
    assert (metrics["completeness"], metrics["spurious"], metrics["identity_changes"], metrics["held"]) == (
        1.0,
        0.0,
        0.0,
        1.0,
    )


def test_a_missing_track_costs_the_cutoff() -> None:
    metrics = scores(results(missing=True))
    assert metrics["ospa_m"] == pytest.approx(np.sqrt((9.0 + 200.0**2) / 2.0), rel=1e-6)
    assert metrics["completeness"] == pytest.approx(0.5) and metrics["held"] == 0.5


def test_swapped_names_are_counted() -> None:
    assert scores(results(swapped_at=12))["identity_changes"] == 2.0


def test_no_track_has_no_motion_error() -> None:
    run = [replace(result, tracks=()) for result in results(scans=90)]
    assert motion_errors(run)["true_course_deg_1min"] is None and associations(run[0]) == {}
    assert motion_errors(results(scans=10)) == {}  # shorter than a minute


def test_motion_errors_are_those_of_the_worst_target() -> None:
    """Tracks 3 m and 4 m off on the right course: nothing but range and bearing errs."""
    errors = motion_errors(results(scans=90))
    assert {f"{name}_{minutes}min" for name in QUANTITIES for minutes in (1, 3)} == set(errors)
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
    both, alone = motion_errors(run), motion_errors([replace(one, truths=one.truths[:1]) for one in run])
    assert both["true_course_deg_1min"] == pytest.approx(0.0, abs=1e-9) and both["tcpa_min_1min"] == pytest.approx(
        0.0, abs=1e-9
    )
    assert both["true_speed_kn_1min"] == pytest.approx(0.1 / KNOT)
    assert alone["true_course_deg_1min"] is alone["relative_course_deg_1min"] is alone["tcpa_min_1min"] is None
    silent = [replace(one, tracks=(one.tracks[0], replace(one.tracks[1], velocity_east=0.0))) for one in run]
    assert motion_errors(silent)["tcpa_min_1min"] is None  # a track that claims rest gives no TCPA of a target that has one
