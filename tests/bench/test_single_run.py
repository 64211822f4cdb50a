"""One run: a tracker that fails is a failed run, and what a run is made of is told."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.bench.bench import bench
from radar_service.bench.kept_plots import observed_run
from radar_service.bench.scenario import Scenario, load_scenario
from radar_service.bench.single_run import data_sheet, missed_limits, same_for_all, single_run
from radar_service.bench.trackers.tracker import DataSheet
from radar_service.numerics.arithmetic_name import arithmetic
from radar_service.terminal import progress_bar
from tests.bench import known_trackers as known
from tests.bench.test_bench import program, small
from tests.bench.test_run import SMALL
from tests.bench.trackers.test_process_tracker import ECHO

ROOT = Path(__file__).parents[2]


NO_NUMBER = """
from radar_service.bench import TrackState

class Mine:
    def update(self, scan):
        return [
            TrackState(track="a", time=p.time, east=p.east, north=p.north, velocity_east=float("nan"), velocity_north=0.0)
            for p in scan.plots
        ]
"""
CRASHES = "class Mine:\n    def update(self, scan):\n        return [] if scan.scan < 2 else [][scan.scan]\n"


@pytest.mark.parametrize(
    ("source", "message", "status", "said"),
    [
        (CRASHES, "has ended before it answered scan 2", 1, "IndexError: list index out of range"),
        (NO_NUMBER, "velocity_east is nan; a finite number is needed", None, ""),
    ],
)
def test_a_tracker_that_fails_is_a_failed_run_and_the_rest_go_on(
    source: str, message: str, status: int | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With scan, exit status and last line of the standard error, in a process of its own; it misses every limit."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(source)
    other = small(tmp_path, 6).model_copy(update={"name": "other"})
    reported, runs = bench([small(tmp_path, 6), other], 1, "mine:Mine", tmp_path / "out")
    assert [scenario["name"] for scenario in reported["scenarios"]] == ["small", "other"]
    for scenario in reported["scenarios"]:
        (failure,) = scenario["failures"]
        assert failure["seed"] == 0 and message in failure["message"] and failure["scan"] == len(runs["small"][0]["scans"])
        assert failure["stderr"] == said and failure["status"] == status
        assert all(verdict["failures"] == 1 for verdict in scenario["verdicts"])
    assert not [*(tmp_path / "out" / "runs").glob("*.json")]  # another try may end otherwise


def test_a_run_is_kept_with_the_version_and_the_source(tmp_path: Path) -> None:
    command = program(tmp_path, ECHO)
    run = single_run(small(tmp_path, 3), 0, command, tmp_path / "plots")
    assert (
        same_for_all(command).items() <= run.items()
        and {"version", "source", "bench", "program"} <= run.keys()
        and run["arithmetic"] == arithmetic()  # those of another are made anew
    )
    assert run["failure"] is None and len(run["scans"]) == 3 and run["scans"][0]["targets"][0]["body"] == "t"


def test_a_slow_tracker_is_seen_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress_bar, "SECONDS", 0.0)
    single_run(small(tmp_path, 3), 0, command := program(tmp_path, ECHO), tmp_path / "plots")
    assert f"small, seed 0: {command}: 2 of 3 scans, " in capsys.readouterr().err


OWN = """
[[radar]]
id = "far"
[[radar]]
id = "near"
azimuths = 256
beamwidth_deg = 4
range_max_m = 1500
bandwidth_hz = 20e6
sample_rate_hz = 30e6
platform = { position_m = [50, 0] }
[environment]
noise = true
[[body]]
name = "ship"
shape = "point"
position_m = [-400, 700, 10]
rcs_dbsm = -5
course_deg = 90
speed_kn = 20
[bench]
scans = 26
radar = "near"
plot_errors = { range_sd_m = 3, bearing_sd_deg = 0.05 }
"""


@pytest.mark.parametrize("seed", range(2))
def test_a_scene_of_one_s_own_judges_a_tracker_in_a_test(seed: int, tmp_path: Path) -> None:
    """A good tracker misses nothing, one without velocities a limit of every scenario; the radar is the one of the table."""
    (tmp_path / "mine.toml").write_text(OWN)
    scene, plots = str(tmp_path / "mine.toml"), tmp_path / "plots"
    told = list[DataSheet]()
    good = known.Imm()
    good.begin_run = told.append  # type: ignore[attr-defined]
    good.memory = {"plots": 0}  # type: ignore[attr-defined]  # of its own: programs alone are asked how much they take
    assert missed_limits(scene, seed, good, plots) == {}
    assert told == [data_sheet(load_scenario(scene))]
    assert "velocity_kn_1min" in missed_limits(scene, seed, known.WRONG["Still"](DataSheet()), plots)
    given = observed_run(plots, load_scenario(scene), seed).results[-1].given
    assert (given.east, given.north) == (50.0, 0.0)


def test_the_data_sheet_tells_what_a_radar_knows_and_no_more() -> None:
    """Standard errors by hand: a normal one, a step and a cell, and half a beam of 15; a sixth of a ship; noise over a Pfa of
    1e-7 and two other plots; the same for each course and place of the targets."""
    errors = {
        "range_sd_m": 3.0,
        "range_step_m": 12.0,
        "bearing_sd_deg": 0.1,
        "glint_length_m": 120.0,
        "roll_deg": 10.0,
        "others": 2.0,
    }
    scene = {**SMALL["scene"], "errors": {"profile": "imo-2004"}}
    sheet = data_sheet(Scenario(**{**SMALL, "scene": scene, "plot_errors": errors}))
    assert (sheet.rpm, sheet.sensors, sheet.glint) == (pytest.approx(24.0), "imo-2004", 20.0)
    assert sheet.range_error == pytest.approx(np.sqrt(3.0**2 + 12.0 + sheet.cell**2 / 12.0))
    heel = np.radians(10.0) * np.sin(np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False))
    turn = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)[:, None]
    roll = np.std(0.5 * heel**2 * np.sin(turn) * np.cos(turn))
    assert np.degrees(sheet.bearing_error) == pytest.approx(
        np.sqrt(0.1**2 + 0.12**2 + np.degrees(roll) ** 2 + (4.0 / 15.0) ** 2), rel=1e-6
    )
    assert sheet.false_plots == pytest.approx(2.0 + 1e-7 * 256 * 1500.0 / sheet.cell, rel=0.01)
    moved = {**scene, "body": [{**scene["body"][0], "position_m": [-300, -900, 10], "course_deg": 10, "speed_kn": 5}]}
    assert data_sheet(Scenario(**{**SMALL, "scene": moved, "plot_errors": errors, "scans": 30})) == sheet
