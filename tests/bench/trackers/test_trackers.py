"""Trackers by name, and what stands behind a name."""

import sys
from dataclasses import asdict
from pathlib import Path

import pytest

from radar_service.bench.trackers.ais_association import AssociatingTracker
from radar_service.bench.trackers.process_tracker import CallableTracker, ProcessTracker
from radar_service.bench.trackers.stone_soup import tuning_of
from radar_service.bench.trackers.tracker import DataSheet
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.bench.trackers.websocket_tracker import WebsocketTracker
from tests.bench.trackers.test_websocket_tracker import plots_as_tracks, server

HEADER = {"radar": asdict(DataSheet(range_error=7.0))}


def test_the_reference_trackers_are_tuned_by_the_data_sheet() -> None:
    pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")
    assert isinstance(tracker_for("gnn", HEADER), AssociatingTracker)
    assert tuning_of(DataSheet(), "jpda").association == "jpda"
    assert tuning_of(DataSheet(range_error=7.0), "gnn").range_error == 7.0


def test_a_callable_a_command_and_a_server() -> None:
    for name, kind in (("tests.bench.test_run:Noted", CallableTracker), ("cat", ProcessTracker)):
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
