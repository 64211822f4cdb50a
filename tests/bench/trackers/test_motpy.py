"""A tracker that this project did not write: motpy, by the adapter of docs/examples, through the JSON Lines protocol."""

import importlib.util
import sys
from pathlib import Path

import pytest

from radar_service.bench.bench import bench
from radar_service.bench.trackers.process_tracker import ProcessTracker
from tests.bench.test_bench import small
from tests.bench.trackers.test_stone_soup import given, plots_of

ADAPTER = Path(__file__).parents[3] / "docs" / "examples" / "motpy_tracker.py"
COMMAND = f"{sys.executable} {ADAPTER}"
TARGETS = [(-300.0, 800.0, 5.0, 0.0), (1500.0, -800.0, -3.0, 6.0)]

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("motpy") is None,
    reason="motpy is absent; it is in no extra, as nobody has kept it since 2022: pip install motpy",
)


def test_motpy_follows_straight_targets_and_keeps_their_names() -> None:
    """Plots without noise, a gap of two scans: states at the time of the last plot, or moved on by whole scans."""
    tracker = ProcessTracker(COMMAND, {"seed": 0})
    scans = [given(scan, plots_of(scan, TARGETS, {1} if scan in (12, 13) else set())) for scan in range(20)]
    answers = [sorted(tracker.update(scan), key=lambda track: -track.north) for scan in scans]
    tracker.close()
    assert not answers[2] and len({tuple(track.track for track in answer) for answer in answers[5:]}) == 1
    for track, (east, north, east_speed, north_speed) in zip(answers[13], TARGETS, strict=True):
        assert scans[13].time - 2.5 <= track.time < scans[13].time
        assert abs(track.east - east - track.time * east_speed) < 5.0
        assert abs(track.north - north - track.time * north_speed) < 5.0
    for track, (_, _, east_speed, north_speed) in zip(answers[19], TARGETS, strict=True):
        assert (track.velocity_east, track.velocity_north) == pytest.approx((east_speed, north_speed), abs=0.5)


def test_motpy_runs_through_the_bench(tmp_path: Path) -> None:
    (its,) = bench([small(tmp_path, 30)], 1, COMMAND, tmp_path / "out")[0]["scenarios"]
    assert its["metrics"]["held"] == 1.0 and its["metrics"]["ospa_m"] < 10.0 and its["metrics"]["identity_changes"] == 0
