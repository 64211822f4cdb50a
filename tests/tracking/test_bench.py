"""The bench: runs are kept and resumed, the report adds them up, any tracker takes part. Gates on the reference tracker."""

import json
from pathlib import Path

import pytest

from radar_service.tracking import bench as bench_module
from radar_service.tracking.bench import bench, runs_of, tracker_for, tuning_of
from radar_service.tracking.process_tracker import ProcessTracker, TrackerError
from radar_service.tracking.scenario import Scenario, load_scenario
from radar_service.tracking.stone_soup import StoneSoupTracker
from tests.tracking.test_process_tracker import ECHO, program
from tests.tracking.test_scenario import SMALL

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")

FILE = """
question = "?"
expected = "!"
source = "this test"
scans = {scans}
[[limit]]
metric = "held"
minimum = 1
source = "this test"
[scene.radar]
azimuths = 256
beamwidth_deg = 4
range_max_m = 1500
pulse_s = 1e-6
bandwidth_hz = 20e6
sample_rate_hz = 30e6
[scene.environment]
noise = true
[[scene.body]]
name = "t"
shape = "point"
position_m = [800, 300, 10]
rcs_dbsm = -15
course_deg = 90
speed_kn = 20
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(FILE.format(scans=24))
    return path


def test_a_report_of_two_seeds_is_resumed(scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second command makes only the runs that are missing or cut; a changed scenario is run anew."""
    made: list[tuple[str, int]] = []
    single = bench_module.single_run

    def counted(name: str, seed: int, tracker: str) -> dict:
        made.append((Path(name).stem, seed))
        return single(name, seed, tracker)

    monkeypatch.setattr(bench_module, "single_run", counted)
    first = bench([str(scenario)], 2, "gnn", tmp_path / "out", 1)
    assert made == [("small", 0), ("small", 1)]
    (its,) = first["scenarios"]
    assert (its["name"], its["seeds"], its["question"]) == ("small", [0, 1], "?")
    assert its["metrics"]["ospa_m"] < 10.0 and its["verdicts"][0]["metric"] == "held" and its["verdicts"][0]["failures"] == 0
    assert bench([str(scenario)], 2, "gnn", tmp_path / "out", 1) == first and len(made) == 2
    kept = next((tmp_path / "out" / "runs").glob("*-1.json"))
    kept.write_text(kept.read_text()[:100])
    assert bench([str(scenario)], 3, "gnn", tmp_path / "out", 1)["scenarios"][0]["seeds"] == [0, 1, 2]
    assert made[2:] == [("small", 1), ("small", 2)]
    scenario.write_text(FILE.format(scans=23))
    bench([str(scenario)], 1, "gnn", tmp_path / "out", 1)
    assert made[4:] == [("small", 0)]
    assert len(runs_of([str(scenario)], 1, "gnn", tmp_path / "out")["small"][0]["scans"]) == 23


def test_a_program_of_another_language_is_judged_too(scenario: Path, tmp_path: Path) -> None:
    """It reports each plot as a track without velocity: the position is right, the velocity is not."""
    (its,) = bench([str(scenario)], 1, program(tmp_path, ECHO), tmp_path / "out", 1)["scenarios"]
    assert its["metrics"]["position_error_m"] < 1.0 and its["metrics"]["velocity_error_m_s"] == pytest.approx(
        20 * 1852 / 3600, rel=0.01
    )


def test_processes_give_the_runs_of_one(scenario: Path, tmp_path: Path) -> None:
    one = bench([str(scenario)], 2, "gnn", tmp_path / "one", 1)
    assert json.dumps(bench([str(scenario)], 2, "gnn", tmp_path / "two", 2)) == json.dumps(one)


def test_trackers_by_name() -> None:
    scenario = Scenario(**SMALL)
    assert isinstance(tracker_for("gnn", scenario, 0), StoneSoupTracker)
    made = tracker_for("tests.tracking.test_run:Noted", scenario, 0)
    assert type(made).__name__ == "Noted" and tuning_of(scenario, "jpda").association == "jpda"
    with pytest.raises(TrackerError, match="nowhere:Tracker could not be imported"):
        tracker_for("nowhere:Tracker", scenario, 0)
    other = tracker_for("cat", scenario, 0)
    assert isinstance(other, ProcessTracker)
    other.close()


@pytest.mark.parametrize("name", ["crossing-cpa-500", "overtaking"])
def test_gate_the_reference_tracker_meets_the_limits(name: str, tmp_path: Path) -> None:
    """Three seeds each: no limit that decides is missed in any."""
    assert any(limit.decides for limit in load_scenario(name).limit)
    (its,) = bench([name], 3, "gnn", tmp_path, 1)["scenarios"]
    assert [verdict["failures"] for verdict in its["verdicts"]] == [0] * len(its["verdicts"])
