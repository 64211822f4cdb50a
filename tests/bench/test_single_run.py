"""One run: a tracker that fails is a failed run, and what a run is made of is told."""

from pathlib import Path

import pytest

from radar_service.bench.bench import bench
from radar_service.bench.single_run import same_for_all, single_run
from tests.bench.test_bench import program, small
from tests.bench.trackers.test_process_tracker import ECHO

ROOT = Path(__file__).parents[2]


def tracker_module(folder: Path, kind: str) -> str:
    """A module of a folder whose tracker is one of the known ones."""
    (folder / "mine.py").write_text(f"from tests.bench.known_trackers import {kind} as Mine\n")
    return "mine:Mine"


@pytest.mark.parametrize(
    ("kind", "message", "status", "said"),
    [
        ("Crashes", "has ended before it answered scan 2", 1, "IndexError: list index out of range"),
        ("NoNumbers", "velocity_east is nan; a finite number is needed", None, ""),
    ],
)
def test_a_tracker_that_fails_is_a_failed_run_and_the_rest_go_on(
    kind: str, message: str, status: int | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With scan, exit status and last line of the standard error, in a process of its own; it misses every limit."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    other = small(tmp_path, 6).model_copy(update={"name": "other"})
    reported, runs = bench([small(tmp_path, 6), other], 1, tracker_module(tmp_path, kind), tmp_path / "out")
    assert [scenario["name"] for scenario in reported["scenarios"]] == ["small", "other"]
    for scenario in reported["scenarios"]:
        (failure,) = scenario["failures"]
        assert failure["seed"] == 0 and message in failure["message"] and failure["scan"] == len(runs["small"][0]["scans"])
        assert failure["stderr"] == said and (status is None or failure["status"] == status)
        assert all(verdict["failures"] == 1 for verdict in scenario["verdicts"])
    assert not [*(tmp_path / "out" / "runs").glob("*.json")]  # another try may end otherwise


def test_a_run_is_kept_with_the_version_and_the_source(tmp_path: Path) -> None:
    command = program(tmp_path, ECHO)
    run = single_run(small(tmp_path, 3), 0, command, tmp_path / "plots")
    assert same_for_all(command).items() <= run.items() and {"version", "source", "arithmetic", "program"} <= run.keys()
    assert run["failure"] is None and len(run["scans"]) == 3 and run["ppi"] is not None
