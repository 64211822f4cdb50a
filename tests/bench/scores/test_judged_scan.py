"""Which states count, and of which target they are, by hand."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from radar_service.bench.scores.judged_scan import JudgedScan, judged
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.trackers.tracker import TrackState
from tests.bench.scores.test_scoring import given, track, truth


def scan(*tracks: TrackState, number: int = 10) -> JudgedScan:
    """One scan, number 10 by default, with a target at (0, 1000) that moves east at 10 m/s."""
    one = truth("one", 2.5 * number, -25.0 * number, 1000.0)
    before = [ScanResult(given(k), (), (truth("one", 2.5 * k, -25.0 * number, 1000.0),)) for k in range(number)]
    return judged([*before, ScanResult(given(number), tracks, (one,))]).scans[-1]


def state(time: float, coasting: bool = False, **moved: float) -> TrackState:
    kept: Mapping[str, float] = {"east": 10.0 * (time - 25.0), "north": 1000.0, "velocity_east": 10.0, "velocity_north": 0.0}
    return TrackState(track="1", time=time, coasting=coasting, **{**kept, **moved})


def test_a_state_is_moved_to_the_end_of_the_scan_with_its_own_velocity() -> None:
    """The scan ends at 27.5 s, when the target is at 25 m; a track without velocity stays 25 m behind."""
    assert scan(state(25.0)).distance == {"one": pytest.approx(0.0)}
    assert scan(state(25.0, velocity_east=0.0)).distance == {"one": pytest.approx(25.0)}


@pytest.mark.parametrize(("age", "coasting", "counts"), [(7.5, False, True), (7.6, False, False), (20.0, True, True)])
def test_a_state_older_than_three_scans_counts_where_the_tracker_coasts(age: float, coasting: bool, counts: bool) -> None:
    judged_scan = scan(state(27.5 - age, coasting))
    assert bool(judged_scan.pairs) is counts is bool(judged_scan.tracks)


def test_pairs_are_one_to_one_and_within_the_cutoff() -> None:
    near, far = state(25.0), replace(state(25.0), track="2", north=1199.0)
    assert scan(near, far).pairs == {"one": "1"} and scan(near, far).near == {"1", "2"}
    assert scan(replace(far, north=1201.0)).near == frozenset()


def test_errors_of_own_ship_s_sensors_are_no_errors_of_the_track() -> None:
    shifted = replace(track("1", truth("one", 0.0, 0.0, 1000.0)), east=30.0)
    one = replace(truth("one", 0.0, 0.0, 1000.0), own_error=(30.0, 0.0))
    assert judged([ScanResult(given(0), (shifted,), (one,))]).scans[0].distance["one"] == pytest.approx(0.0)
