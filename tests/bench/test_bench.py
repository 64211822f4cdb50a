"""The bench: runs are kept and resumed, the report adds them up, any tracker takes part. Gates on the reference tracker."""

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from radar_service.bench import bench as bench_module
from radar_service.bench.bench import CROSSINGS, at_power_centroids, bench
from radar_service.bench.scenario import Scenario, load_scenario
from radar_service.bench.scores.scoring import ScanResult
from tests.bench.scores.test_scoring import given, truth
from tests.bench.trackers.test_process_tracker import ECHO, program
from tests.bench.trackers.test_websocket_tracker import plots_as_tracks, server

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


def small(tmp_path: Path, scans: int) -> Scenario:
    path = tmp_path / "small.toml"
    path.write_text(FILE.format(scans=scans))
    return load_scenario(str(path))


@pytest.fixture
def scenario(tmp_path: Path) -> Scenario:
    return small(tmp_path, 24)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """The runs that are made, as they are."""
    runs: list[tuple[str, int]] = []
    single = bench_module.single_run

    def counted(scenario: Scenario, seed: int, tracker: str) -> dict:
        runs.append((scenario.name, seed))
        return single(scenario, seed, tracker)

    monkeypatch.setattr(bench_module, "single_run", counted)
    return runs


def test_a_report_of_two_seeds_is_resumed(scenario: Scenario, made: list[tuple[str, int]], tmp_path: Path) -> None:
    """A second command makes only the runs that are missing or cut; a changed scenario is run anew."""
    first, runs = bench([scenario], 2, "gnn", tmp_path / "out")
    assert made == [("small", 0), ("small", 1)]
    (its,) = first["scenarios"]
    assert (its["name"], its["seeds"], its["question"]) == ("small", [0, 1], "?")
    assert its["metrics"]["ospa_m"] < 10.0 and its["verdicts"][0]["metric"] == "held" and its["verdicts"][0]["failures"] == 0
    assert bench([scenario], 2, "gnn", tmp_path / "out") == (first, runs) and len(made) == 2
    kept = next((tmp_path / "out" / "runs").glob("small--seed-1-*.json"))
    kept.write_text(kept.read_text()[:100])
    assert bench([scenario], 3, "gnn", tmp_path / "out")[0]["scenarios"][0]["seeds"] == [0, 1, 2]
    assert made[2:] == [("small", 1), ("small", 2)]
    shorter = small(tmp_path, 23)
    bench([shorter], 1, "gnn", tmp_path / "out")
    assert made[4:] == [("small", 0)]
    assert len(bench([shorter], 1, "gnn", tmp_path / "out")[1]["small"][0]["scans"]) == 23


def test_a_program_of_another_language_is_judged_too(scenario: Path, tmp_path: Path) -> None:
    """It reports each plot as a track without velocity: the position is right, the velocity is not."""
    (its,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    assert its["metrics"]["position_error_m"] < 1.0 and its["metrics"]["velocity_error_m_s"] == pytest.approx(
        20 * 1852 / 3600, rel=0.01
    )


@pytest.mark.same_bytes
def test_processes_give_the_runs_of_one(tmp_path: Path) -> None:
    scenario = small(tmp_path, 8)
    one = bench([scenario], 2, "gnn", tmp_path / "one")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:  # one shows it, at half the cost of two
        assert json.dumps(bench([scenario], 2, "gnn", tmp_path / "two", executor)) == json.dumps(one)


def test_a_program_that_changed_is_run_anew(made: list[tuple[str, int]], tmp_path: Path) -> None:
    """Its name is the same, its file is not: kept runs are those of another tracker."""
    scenario, command = small(tmp_path, 4), program(tmp_path, ECHO)
    for code, runs in ((ECHO, 1), (ECHO, 1), (ECHO.replace('"track": k', '"track": k + 1'), 2)):
        assert program(tmp_path, code) == command
        bench([scenario], 1, command, tmp_path / "out")
        assert len(made) == runs
    (run,) = bench([scenario], 1, command, tmp_path / "out")[1]["small"]
    assert {track["track"] for scan in run["scans"] for track in scan["tracks"]} == {"1"}


def test_runs_of_another_arithmetic_are_run_anew(
    made: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scenario = small(tmp_path, 4)
    for name, runs in (("one", 1), ("one", 1), ("another", 2), ("another", 2)):
        monkeypatch.setattr(bench_module, "arithmetic", lambda name=name: name)
        bench([scenario], 1, "gnn", tmp_path / "out")
        assert len(made) == runs
    (run,) = bench([scenario], 1, "gnn", tmp_path / "out")[1]["small"]
    assert run["arithmetic"] == "another"


@pytest.mark.same_bytes
def test_a_server_is_judged_as_a_program_is(tmp_path: Path) -> None:
    scenario = small(tmp_path, 6)
    (by_pipe,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    with server(plots_as_tracks) as url:
        (by_socket,) = bench([scenario], 1, url, tmp_path / "out")[0]["scenarios"]
    assert by_socket == by_pipe and by_pipe["metrics"]["held"] > 0


def test_a_command_of_any_length_has_a_file(tmp_path: Path) -> None:
    """File systems take 255 characters."""
    long = f"{program(tmp_path, ECHO)} {'x' * 300}"
    assert bench([small(tmp_path, 4)], 1, long, tmp_path / "out")[0]["tracker"] == long


@pytest.mark.parametrize("seeds", [1, pytest.param(3, marks=pytest.mark.study)])
@pytest.mark.parametrize("name", ["crossing-cpa-500", pytest.param("overtaking", marks=pytest.mark.study)])
def test_gate_the_reference_tracker_meets_the_limits(name: str, seeds: int, tmp_path: Path) -> None:
    """No limit that decides is missed in any run."""
    scenario = load_scenario(name)
    assert any(limit.decides for limit in scenario.limit)
    (its,) = bench([scenario], seeds, "gnn", tmp_path)[0]["scenarios"]
    assert [verdict["failures"] for verdict in its["verdicts"]] == [0] * len(its["verdicts"])


def test_a_flood_is_a_remark_of_the_report_and_warns_of_nothing(tmp_path: Path) -> None:
    path = tmp_path / "small.toml"
    path.write_text(FILE.format(scans=2).replace("noise = true", "noise = true\nsea_state = 5"))
    scenario = load_scenario(str(path))
    (its,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    assert its["remark"].startswith("2 of 2 scans flood the plot extractor; scan ")
    assert 'set threshold to "ca"' in its["remark"]


HEADING = np.radians(90.0)  # bow to the east, starboard to the south


def run(offsets: list[tuple[float, float] | None], heading: float = HEADING) -> list[ScanResult]:
    """A ship at rest at (0, 1000) whose power lies at these offsets from her reference point."""
    at_rest = replace(truth("ship", 0.0, 0.0, 1000.0, speed=0.0), heading=heading)
    return [ScanResult(given(k), (), (replace(at_rest, centroid=offset),)) for k, offset in enumerate(offsets)]


def positions(results: list[ScanResult]) -> list[tuple[float, float]]:
    return [result.truths[0].position for result in at_power_centroids(results)]


def test_a_target_stands_where_her_power_lies_in_the_mean() -> None:
    """Glint of 12 m to and fro about 4 m ahead and 3 m to starboard: the mean over 11 crossings, the ends over fewer."""
    glint = [(4.0 + 12.0 * (-1) ** k, 3.0) for k in range(31)]
    moved = positions(run(glint))
    expected = 4.0 + 12.0 * (-1) ** (15 - CROSSINGS) / (2 * CROSSINGS + 1)
    assert moved[15] == pytest.approx((expected, 1000.0 - 3.0))
    assert moved[0] == pytest.approx((4.0, 997.0))  # six crossings: as many ahead as astern


@pytest.mark.parametrize(("degrees", "east", "north"), [(0, 2.0, 5.0), (90, 5.0, -2.0), (180, -2.0, -5.0), (270, -5.0, 2.0)])
def test_offsets_turn_with_the_ship(degrees: float, east: float, north: float) -> None:
    """5 m to the bow and 2 m to starboard."""
    assert positions(run([(5.0, 2.0)] * 3, np.radians(degrees)))[1] == pytest.approx((east, 1000.0 + north))


def test_crossings_without_power_do_not_count() -> None:
    assert positions(run([None, (6.0, 0.0), None]))[0] == pytest.approx((6.0, 1000.0))
    assert positions(run([None] * 3)) == [(0.0, 1000.0)] * 3
    assert positions(run([(6.0, 0.0)] + [None] * (CROSSINGS + 1)))[-1] == (0.0, 1000.0)  # too long ago


def test_targets_are_not_mixed() -> None:
    one, other = run([(6.0, 0.0)])[0], replace(truth("buoy", 0.0, 0.0, 500.0, speed=0.0))
    both = at_power_centroids([replace(one, truths=(*one.truths, other))])[0]
    assert [truth.position for truth in both.truths] == [pytest.approx((6.0, 1000.0)), (0.0, 500.0)]
