"""Trackers in Python run in a process of their own, and are checked as any program is."""

from pathlib import Path

import pytest

from radar_service.bench.trackers.callable_child import scan_of
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.process_tracker import CallableTracker
from tests.bench.trackers.test_stone_soup import given, plot

TRACKER = """
import os, sys
from radar_service.bench import TrackState

class Mine:
    def update(self, scan):
        print("not an answer")
        os.write(1, b"nor this")
        return [
            TrackState(track=str(os.getpid()), time=p.time, east=p.east, north=p.north, velocity_east=0.0,
                       velocity_north=0.0, coasting=True)
            for p in scan.plots
        ]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_callable_answers_from_another_process_and_may_print(folder: Path) -> None:
    import os

    (folder / "mine.py").write_text(TRACKER)
    tracker = CallableTracker("mine:Mine", {"seed": 1})
    for scan in range(2):
        (state,) = tracker.update(given(scan, (plot(scan * 2.5 + 1, 100.0, 200.0),)))
        assert (state.time, state.coasting) == (scan * 2.5 + 1, True) and int(state.track) != os.getpid()
    tracker.close()
    assert tracker.status == 0


@pytest.mark.parametrize(
    ("name", "said"),
    [("nowhere:Tracker", "No module named 'nowhere'"), ("mine:Nobody", "module 'mine' has no attribute 'Nobody'")],
)
def test_what_cannot_be_imported_is_said_on_standard_error(name: str, said: str, folder: Path) -> None:
    (folder / "mine.py").write_text(TRACKER)
    tracker = CallableTracker(name, {})
    with pytest.raises(TrackerError, match="has ended"):
        tracker.update(given(0, ()))
    tracker.close()
    assert said in tracker.last_line and tracker.status == 1


def test_a_scan_arrives_as_it_was_sent() -> None:
    sent = given(3, (plot(8.0, 100.0, 200.0), plot(9.0, -100.0, 200.0)))
    assert scan_of(sent.as_dict()) == sent
