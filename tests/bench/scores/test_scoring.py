"""Scores of runs whose answers are known by hand."""

import numpy as np
import pytest

from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.scores.scoring import scores
from radar_service.bench.trackers.tracker import TrackerInput, TrackState


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


def results(scans: int = 60, missing: bool = False, swapped_at: int | None = None, later: float = 0.0) -> list[ScanResult]:
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


@pytest.mark.parametrize("later", [0.0, 1.7, -4.0])
def test_metrics_of_two_tracks_beside_their_targets(later: float) -> None:
    """OSPA of order 2: sqrt((3^2 + 4^2) / 2). Track and truth move on to the end of the scan."""
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
