"""Blind runs: what a program is told, and that neither guesses, files nor times lead it to the truth."""

import json
from pathlib import Path

import pytest

from radar_service.bench import blind as blind_module
from radar_service.bench import single_run as single_module
from radar_service.bench.bench import bench, jobs_of
from radar_service.bench.blind import FIRST_SEED, SALT, Blind, blind_for, can_seal
from radar_service.bench.report import page
from radar_service.bench.scenario import load_scenario, with_profile
from radar_service.bench.single_run import header_of
from tests.bench.test_bench import small
from tests.bench.trackers.test_process_tracker import program

NOTES = """
import json, sys
header = json.loads(sys.stdin.readline())
for line in sys.stdin:
    state = {"track": json.dumps(sorted(header)), "time": 0, "east": 0, "north": 0, "velocity_east": 0, "velocity_north": 0}
    print(json.dumps({"type": "tracks", "scan": json.loads(line)["scan"], "tracks": [state]}), flush=True)
"""


def test_a_blind_run_tells_neither_scenario_nor_seed_and_the_report_tells_the_seeds(tmp_path: Path) -> None:
    report, runs = bench([small(tmp_path, 3)], 2, program(tmp_path, NOTES), tmp_path / "out", blind=True)
    assert runs["small"][0]["scans"][0]["tracks"][0]["track"] == json.dumps(["radar", "run", "schema", "type"])
    seeds = report["scenarios"][0]["seeds"]
    assert min(seeds) >= FIRST_SEED and len({*seeds}) == 2 and report["blind"]["salt"]
    texts = [path.name for path in (tmp_path / "bench-plots").iterdir()] + [path.name for path in tmp_path.rglob("*.json")]
    assert not any(str(seed) in text for seed in seeds for text in texts)  # names are no secret
    again, _ = bench([small(tmp_path, 3)], 2, "gnn", tmp_path / "two", blind=True, salt=report["blind"]["salt"])
    assert again["scenarios"][0]["seeds"] == seeds  # who has the report can recompute it
    assert again["sheet"]["plots"] == report["sheet"]["plots"] and "not a type approval" in report["sheet"]["use"]
    assert "noise: " in report["sheet"]["physics"] and "cross-sections as declared" in report["sheet"]["physics"]
    assert f"--salt {report['blind']['salt']}" in report["sheet"]["again"] and report["sheet"]["plots"] in page(
        report, {"small": None}
    )
    assert header_of(small(tmp_path, 3), 5)["seed"] == 5  # an open run


def test_seeds_cannot_be_guessed(tmp_path: Path) -> None:
    """Each salt, scenario and run has its own, of 53 bits; the header's number of a run has nothing of them."""
    seeds = {Blind(salt, ()).seed(name, run) for salt in "ab" for name in ("x", "y") for run in range(500)}
    assert len(seeds) == 2000 and FIRST_SEED <= min(seeds) and max(seeds) < 2**53 and max(seeds) > 2**52
    assert blind_for(tmp_path / "a", tmp_path / "out").salt != blind_for(tmp_path / "b", tmp_path / "out").salt
    scenario = small(tmp_path, 3)
    assert header_of(scenario, None)["run"] != header_of(scenario, None)["run"]


@pytest.mark.skipif(not can_seal(), reason="Landlock is absent")
def test_folders_of_earlier_reports_are_sealed_too(tmp_path: Path) -> None:
    first = blind_for(tmp_path / "plots", tmp_path / "one")
    second = blind_for(tmp_path / "plots", tmp_path / "two")
    assert second.salt == first.salt == json.loads((tmp_path / "plots" / SALT).read_text())["salt"]
    assert {*second.sealed} == {str((tmp_path / name).resolve()) for name in ("plots", "one", "two")}
    assert blind_for(tmp_path / "plots", tmp_path / "two", "told").salt == "told"
    assert blind_for(tmp_path / "plots", tmp_path / "two").salt == first.salt  # what a report has told is used once


@pytest.mark.skipif(not can_seal(), reason="Landlock is absent")
def test_a_program_cannot_read_the_scenario_of_its_user(tmp_path: Path) -> None:
    small(tmp_path, 2)
    own = (tmp_path / "small.toml").read_text()
    (tmp_path / "small.toml").write_text(f'name = "of-another-name"\n{own}')
    scenario = with_profile(load_scenario(str(tmp_path / "small.toml")), "inland")
    reads = f"import sys; sys.stdin.readline(); open({str(tmp_path / 'small.toml')!r})"
    report, _ = bench([scenario], 1, program(tmp_path, reads), tmp_path / "out", blind=True)
    assert "PermissionError" in report["scenarios"][0]["failures"][0]["stderr"]
    again = report["sheet"]["again"]
    assert f"bench-tracker {tmp_path / 'small.toml'} --seeds 1" in again and " --fixed --profile inland --tracker" in again


def test_where_nothing_can_be_sealed_truth_stays_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blind_module, "can_seal", lambda: False)
    report, _ = bench([small(tmp_path, 3)], 1, program(tmp_path, NOTES), tmp_path / "out", blind=True)
    assert report["blind"]["sealed"] is False and not (tmp_path / "bench-plots").exists()


def test_plots_are_made_before_the_tracker_starts_so_that_no_time_tells_the_scenario(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    for name in ("observed_run", "tracker_for"):
        made = getattr(single_module, name)
        monkeypatch.setattr(single_module, name, lambda *a, name=name, made=made: (calls.append(name), made(*a))[1])
    single_module.single_run(small(tmp_path, 2), 0, program(tmp_path, NOTES), tmp_path / "plots")
    assert calls == ["observed_run", "tracker_for"]


def test_runs_come_in_any_order_and_are_reported_in_theirs(tmp_path: Path) -> None:
    scenario = small(tmp_path, 1)
    hidden = blind_for(tmp_path / "bench-plots", tmp_path / "out")
    report, _ = bench([scenario], 6, program(tmp_path, NOTES), tmp_path / "out", blind=True)
    assert report["scenarios"][0]["seeds"] == [hidden.seed("small", run) for run in range(6)]
    assert "seed" not in jobs_of([scenario], range(1), "cat", tmp_path, hidden)[0].name
