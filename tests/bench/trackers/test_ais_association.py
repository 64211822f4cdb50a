"""The reference association: by position and motion, at the time of the scan."""

from dataclasses import replace

import pytest

from radar_service.bench.trackers.ais_association import GATE, AssociatingTracker, squares
from radar_service.bench.trackers.tracker import AisTarget, TrackerInput, TrackState
from tests.bench.trackers.test_stone_soup import given

TRACK = TrackState(track="7", time=10.0, east=0.0, north=1000.0, velocity_east=10.0, velocity_north=0.0)
REPORT = AisTarget(time=0.0, mmsi=5, east=-100.0, north=1000.0, speed=10.0, course=1.5707963, station_class="A")


class _Fixed:
    def update(self, scan: TrackerInput) -> list[TrackState]:
        return [TRACK]


@pytest.mark.parametrize(
    ("change", "is_same"), [({}, True), ({"east": 100.0}, False), ({"course": 0.0}, False), ({"north": 1050.0}, True)]
)
def test_a_report_of_ten_seconds_ago_is_moved_on(change: dict[str, float], is_same: bool) -> None:
    report = replace(REPORT, **change)
    assert (squares([TRACK], [report], 10.0)[0, 0] < GATE) == is_same
    (state,) = AssociatingTracker(_Fixed()).update(replace(given(3, ()), ais=(report,)))
    assert (state.mmsi, state.priority) == ((5, "ais") if is_same else (None, "radar"))


def test_old_reports_are_left_alone_and_scans_without_ais_too() -> None:
    tracker = AssociatingTracker(_Fixed())
    assert tracker.update(given(3, ())) == [TRACK]
    assert [tracker.update(replace(given(scan, ()), ais=(REPORT,)))[0].mmsi for scan in (3, 40)] == [5, None]
