"""Trackers in Python run in a process of their own, and are checked as any program is."""

from dataclasses import asdict
from pathlib import Path

import pytest

from radar_service.bench.trackers.callable_child import scan_of
from radar_service.bench.trackers.json_lines import TrackerError, TrackerHangs
from radar_service.bench.trackers.process_tracker import CallableTracker, end_waiting
from radar_service.bench.trackers.tracker import DataSheet
from tests.bench.trackers.test_stone_soup import given, plot

TRACKER = """
import os, sys
from radar_service.bench import TrackState

class Mine:
    def update(self, scan):
        assert "scipy" not in sys.modules  # a tracker starts in a third of the time without
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
    ("name", "message"),
    [
        (
            "nowhere:Tracker",
            "'nowhere:Tracker' made no tracker: there is no module 'nowhere', neither installed nor in /.*test_what_makes",
        ),
        ("mine.part:T", "there is no module 'mine.part'"),
        ("mine:Nobody", "module 'mine' has no callable 'Nobody'; it has TrackState, Mine$"),
        ("mine:NUMBER", "module 'mine' has no callable 'NUMBER'"),
        ("lame:T", "made no tracker: ModuleNotFoundError: No module named 'of_nobody'"),
        ("mine:Mine.update", "has no callable 'Mine.update'"),
    ],
)
def test_what_makes_no_tracker_is_one_sentence(
    name: str, message: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The trace is that of a module which cannot be imported, and of nothing else."""
    (folder / "mine.py").write_text(f"NUMBER = 1\n{TRACKER}")
    (folder / "lame.py").write_text("import of_nobody\n")
    with pytest.raises(TrackerError, match=message):
        CallableTracker(name, {}, sealed=() if name.startswith("nowhere") else None)
    assert ("Traceback" in capfd.readouterr().err) == (name == "lame:T")


def test_a_callable_makes_a_tracker_for_each_run_in_one_process(folder: Path) -> None:
    code = TRACKER.replace(
        "    def update",
        "    runs = 0\n\n    def __init__(self):\n        Mine.runs += 1\n\n    def __len__(self):\n        return 0\n\n"
        "    def update",
    )
    (folder / "mine.py").write_text(code.replace("str(os.getpid())", "str(self.runs)"))
    for run in ("1", "2", "3"):
        tracker = CallableTracker.ready("mine:Mine", {}, None, "")
        assert [state.track for state in tracker.update(given(0, (plot(1.0, 100.0, 200.0),)))] == [run]
        tracker.finish()
    end_waiting()


def test_a_callable_that_waits_for_ever_hangs(folder: Path) -> None:
    (folder / "slow.py").write_text("import time\ntime.sleep(60)\n")
    with pytest.raises(TrackerHangs, match="'slow:T' made no tracker within 0.2 s"):
        CallableTracker("slow:T", {}, timeout=0.2)


def test_a_scan_arrives_as_it_was_sent() -> None:
    sent = given(3, (plot(8.0, 100.0, 200.0), plot(9.0, -100.0, 200.0)))
    assert scan_of(sent.as_dict()) == sent


def test_a_callable_that_begins_is_told_the_data_sheet(folder: Path) -> None:
    code = TRACKER.replace("    def update", "    def begin_run(self, sheet):\n        self.sheet = sheet\n\n    def update")
    (folder / "mine.py").write_text(code.replace("str(os.getpid())", "str(self.sheet.range_error)"))
    tracker = CallableTracker("mine:Mine", {"radar": asdict(DataSheet(range_error=7.5))})
    assert [state.track for state in tracker.update(given(0, (plot(1.0, 100.0, 200.0),)))] == ["7.5"]
    tracker.close()
