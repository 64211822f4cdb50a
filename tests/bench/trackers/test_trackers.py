"""Trackers by name, and what stands behind a name."""

import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.measures import Mahalanobis

from radar_service.bench.trackers.ais_association import GATE, AssociatingTracker, squares
from radar_service.bench.trackers.gating import pair_distances
from radar_service.bench.trackers.process_tracker import CallableTracker, ProcessTracker
from radar_service.bench.trackers.stone_soup import tuning_of
from radar_service.bench.trackers.tracker import AisTarget, DataSheet, TrackerInput, TrackState, moved_on
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.bench.trackers.websocket_tracker import WebsocketTracker
from tests.bench.trackers.test_stone_soup import given
from tests.bench.trackers.test_stone_soup_parts import END, TUNING, parts, plots, tracks
from tests.bench.trackers.test_websocket_tracker import plots_as_tracks, server

HEADER = {"radar": asdict(DataSheet(range_error=7.0))}


def test_the_reference_trackers_are_tuned_by_the_data_sheet() -> None:
    pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")
    assert isinstance(tracker_for("gnn", HEADER), AssociatingTracker)
    assert tuning_of(DataSheet(), "jpda").association == "jpda"
    assert tuning_of(DataSheet(range_error=7.0), "gnn").range_error == 7.0


def test_a_callable_a_command_and_a_server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("class Mine: pass")
    for name, kind in (("mine:Mine", CallableTracker), ("cat", ProcessTracker)):
        tracker = tracker_for(name, HEADER)
        assert type(tracker) is kind
        tracker.close()
    with server(plots_as_tracks) as url:
        connected = tracker_for(url, HEADER)
        assert isinstance(connected, WebsocketTracker)
        connected.close()


def test_a_module_of_the_working_folder_that_changed_has_another_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tracker_of_a_user.py").write_text("class Mine:\n    pass\n")
    before = program_digest("tracker_of_a_user:Mine")
    (tmp_path / "tracker_of_a_user.py").write_text("class Mine:\n    changed = True\n")
    assert program_digest("tracker_of_a_user:Mine") != before
    assert program_digest("tracker_of_nobody:Mine") == program_digest("no.tracker:Mine")


def test_a_program_that_changed_has_another_digest(tmp_path: Path) -> None:
    """Its own file, and each file that the command names; a file that comes to have the same content again has the same."""
    script, settings = tmp_path / "tracker.py", tmp_path / "settings.toml"
    script.write_text("1"), settings.write_text("gate = 3")
    command = f"{sys.executable} {script} --settings={settings}"
    first = program_digest(command)
    settings.write_text("gate = 4")
    second = program_digest(command)
    script.write_text("2")
    assert len({first, second, program_digest(command)}) == 3
    script.write_text("1"), settings.write_text("gate = 3")
    assert program_digest(command) == first != program_digest(f"{script}")
    assert program_digest("no-such-program 'x") == program_digest("no-such-program") == program_digest("")


def test_of_a_server_nothing_is_known_and_of_the_reference_the_version() -> None:
    assert program_digest("ws://127.0.0.1:1") == ""
    assert program_digest("gnn").startswith("stonesoup 1.") or "stonesoup" not in sys.modules


# ais_association: the reference association: by position and motion, at the time of the scan.


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


# gating: distances of tracks and plots are those of Stone Soup.


def test_distances_are_those_of_stone_soup() -> None:
    """To what its numerical derivatives leave."""
    rng = np.random.default_rng(0)
    rows, columns = tracks(rng, 5), plots(rng, 6)
    apart, normalised = pair_distances(rows, columns, TUNING)
    every = DistanceHypothesiser(*parts(), Mahalanobis(), missed_distance=np.inf, include_all=True)
    for row, track in enumerate(rows):
        for hypothesis in every.hypothesise(track, columns, END):
            if hypothesis:
                column = columns.index(hypothesis.measurement)
                assert normalised[row, column] == pytest.approx(float(hypothesis.distance), rel=1e-5)
                east, _, north, _ = np.ravel(hypothesis.prediction.mean)
                angle, distance = np.ravel(columns[column].state_vector).astype(float)
                at = distance * np.exp(1j * angle) - complex(east, north)
                assert apart[row, column] == pytest.approx(abs(at), rel=1e-9)


def test_no_track_and_no_plot_have_no_distance() -> None:
    rng = np.random.default_rng(0)
    assert [one.shape for one in pair_distances([], plots(rng, 3), TUNING)] == [(0, 3)] * 2
    assert [one.shape for one in pair_distances(tracks(rng, 2), [], TUNING)] == [(2, 0)] * 2


# tracker: a position moves along its velocity.
def test_a_position_moves_along_its_velocity() -> None:
    assert moved_on((100.0, -50.0), (2.0, 3.0), -10.0).tolist() == [80.0, -80.0]
