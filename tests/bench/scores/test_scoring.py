"""Scores of runs whose answers are known by hand."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.scores.scoring import CROSSINGS, at_power_centroids, effort, scores
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
    metrics = scores(judged(results(later=later)))
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
    metrics = scores(judged(results(missing=True)))
    assert metrics["ospa_m"] == pytest.approx(np.sqrt((9.0 + 200.0**2) / 2.0), rel=1e-6)
    assert metrics["completeness"] == pytest.approx(0.5) and metrics["held"] == 0.5


def test_swapped_names_are_counted() -> None:
    assert scores(judged(results(swapped_at=12)))["identity_changes"] == 2.0


HEADING = np.radians(90.0)  # bow to the east, starboard to the south


def ship(offsets: list[tuple[float, float] | None], heading: float = HEADING) -> list[ScanResult]:
    """A ship at rest at (0, 1000) whose power lies at these offsets from her reference point."""
    at_rest = replace(truth("ship", 0.0, 0.0, 1000.0, speed=0.0), heading=heading, length=100.0)
    return [ScanResult(given(k), (), (replace(at_rest, centroid=offset),)) for k, offset in enumerate(offsets)]


def positions(results: list[ScanResult]) -> list[tuple[float, float]]:
    return [result.truths[0].position for result in at_power_centroids(results)]


def test_a_target_stands_where_her_power_lies_in_the_mean() -> None:
    """Glint of 12 m to and fro about 4 m ahead and 3 m to starboard: the mean over 11 crossings, the ends over fewer."""
    glint = [(4.0 + 12.0 * (-1) ** k, 3.0) for k in range(31)]
    moved = positions(ship(glint))
    expected = 4.0 + 12.0 * (-1) ** (15 - CROSSINGS) / (2 * CROSSINGS + 1)
    assert moved[15] == pytest.approx((expected, 1000.0 - 3.0))
    assert moved[0] == pytest.approx((4.0, 997.0))  # six crossings: as many ahead as astern


@pytest.mark.parametrize(("degrees", "east", "north"), [(0, 2.0, 5.0), (90, 5.0, -2.0), (180, -2.0, -5.0), (270, -5.0, 2.0)])
def test_offsets_turn_with_the_ship(degrees: float, east: float, north: float) -> None:
    """5 m to the bow and 2 m to starboard."""
    assert positions(ship([(5.0, 2.0)] * 3, np.radians(degrees)))[1] == pytest.approx((east, 1000.0 + north))


def test_crossings_without_power_do_not_count() -> None:
    assert positions(ship([None, (6.0, 0.0), None]))[0] == pytest.approx((6.0, 1000.0))
    assert positions(ship([None] * 3)) == [(0.0, 1000.0)] * 3
    assert positions(ship([(6.0, 0.0)] + [None] * (CROSSINGS + 1)))[-1] == (0.0, 1000.0)  # too long ago


def test_targets_are_not_mixed() -> None:
    one, other = ship([(6.0, 0.0)])[0], replace(truth("buoy", 0.0, 0.0, 500.0, speed=0.0))
    both = at_power_centroids([replace(one, truths=(*one.truths, other))])[0]
    assert [truth.position for truth in both.truths] == [pytest.approx((6.0, 1000.0)), (0.0, 500.0)]


def test_time_of_answers_and_growth_of_memory() -> None:
    """95 % of the answers, by an answer that was given; memory over the second half, so that a start does not count."""
    run = [
        replace(one, seconds=2.0 if scan % 10 == 0 else 0.1, memory=10**9 + 20 * 10**6 * scan if scan > 10 else 10**6)
        for scan, one in enumerate(results())
    ]
    assert effort(run) == {"answer_turns": pytest.approx(2.0 / 2.5), "growth_mb": pytest.approx(20.0)}
    assert effort([replace(one, memory=None) for one in run]) == {"answer_turns": pytest.approx(2.0 / 2.5)}
    assert effort(results()) == {} and effort(run[-1:]).keys() == {"answer_turns"}
