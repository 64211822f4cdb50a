"""The bench: runs are kept and resumed, the report adds them up, any tracker takes part. Gates on the reference tracker."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

from radar_service.bench import bench as bench_module
from radar_service.bench import kept_plots
from radar_service.bench.bench import bench
from radar_service.bench.scenario import PlotSettings, Scenario, load_scenario
from radar_service.bench.scores import verdicts
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.process_tracker import ProcessTracker
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
position_m = [500, 300, 10]
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
    return small(tmp_path, 30)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """The runs that are made, as they are."""
    runs: list[tuple[str, int]] = []
    single = bench_module.single_run

    def counted(scenario: Scenario, seed: int, tracker: str, plots: Path, sealed: tuple[str, ...] | None) -> dict:
        runs.append((scenario.name, seed))
        return single(scenario, seed, tracker, plots, sealed)

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
    shorter = small(tmp_path, 29)
    bench([shorter], 1, "gnn", tmp_path / "out")
    assert made[4:] == [("small", 0)]
    assert len(bench([shorter], 1, "gnn", tmp_path / "out")[1]["small"][0]["scans"]) == 29


def test_a_program_of_another_language_is_judged_too(scenario: Path, tmp_path: Path) -> None:
    """It reports each plot as a track without velocity, which is moved on with none for the 1.7 to 2.2 s that the scan takes."""
    (its,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    speed = 20 * 1852 / 3600
    assert 1.7 * speed < its["metrics"]["position_error_m"] < 2.2 * speed
    assert its["metrics"]["velocity_error_m_s"] == pytest.approx(speed, rel=0.01)


def timeless(data: Any) -> Any:
    """A report without what depends on the machine and the process."""
    if isinstance(data, dict):
        return {key: timeless(value) for key, value in data.items() if key not in ("answer_turns", "growth_mb", "remark")}
    if isinstance(data, list | tuple):
        return [
            timeless(each)
            for each in data
            if not (isinstance(each, dict) and each.get("metric") in ("answer_turns", "growth_mb"))
        ]
    return data


@pytest.mark.same_bytes
def test_processes_give_the_runs_of_one(tmp_path: Path) -> None:
    scenario = small(tmp_path, 8)
    one = bench([scenario], 2, "gnn", tmp_path / "one")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:  # one shows it, at half the cost of two
        assert timeless(bench([scenario], 2, "gnn", tmp_path / "two", executor)) == timeless(one)


def test_a_program_that_changed_is_run_anew(made: list[tuple[str, int]], tmp_path: Path) -> None:
    """Its name is the same, its file is not: kept runs are those of another tracker."""
    scenario, command = small(tmp_path, 4), program(tmp_path, ECHO)
    for code, runs in ((ECHO, 1), (ECHO, 1), (ECHO.replace('"track": k', '"track": k + 1'), 2)):
        assert program(tmp_path, code) == command
        bench([scenario], 1, command, tmp_path / "out")
        assert len(made) == runs
    (run,) = bench([scenario], 1, command, tmp_path / "out")[1]["small"]
    assert {track["track"] for scan in run["scans"] for track in scan["tracks"]} == {"1"}


@pytest.mark.same_bytes
def test_a_smoke_test_makes_a_third_of_the_runs_in_rain(made: list[tuple[str, int]], tmp_path: Path) -> None:
    (tmp_path / "rain.toml").write_text(FILE.format(scans=1).replace("noise = true", "noise = true\nrain_mm_h = 1"))
    scenarios = [small(tmp_path, 1), load_scenario(str(tmp_path / "rain.toml"))]
    report, _ = bench(scenarios, 3, "gnn", tmp_path / "out", smoke=True)
    assert made == [("rain", 0), *(("small", seed) for seed in range(3))]
    assert [scenario["seeds"] for scenario in report["scenarios"]] == [[0, 1, 2], [0]]


def test_a_server_is_judged_as_a_program_is(tmp_path: Path) -> None:
    scenario = small(tmp_path, 6)
    (by_pipe,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    with server(plots_as_tracks) as url:
        (by_socket,) = bench([scenario], 1, url, tmp_path / "out")[0]["scenarios"]
    assert timeless(by_socket) == timeless(by_pipe) and by_pipe["metrics"]["detected"] > 0


@pytest.mark.parametrize("seeds", [1, pytest.param(3, marks=pytest.mark.study)])
@pytest.mark.parametrize("name", ["crossing-cpa-500", pytest.param("overtaking", marks=pytest.mark.study)])
def test_gate_the_reference_tracker_meets_the_limits(name: str, seeds: int, tmp_path: Path) -> None:
    """No limit that decides is missed in any run."""
    scenario = load_scenario(name)
    assert any(limit.decides for limit in scenario.limit)
    (its,) = bench([scenario], seeds, "gnn", tmp_path)[0]["scenarios"]
    assert [verdict["failures"] for verdict in its["verdicts"]] == [0] * len(its["verdicts"])
    assert its["percentile_95"]["ospa_m"] < 10.0  # m: half of what the limit allows


def test_a_flood_is_a_remark_of_the_report_and_warns_of_nothing(tmp_path: Path) -> None:
    path = tmp_path / "small.toml"
    path.write_text(FILE.format(scans=2).replace("noise = true", "noise = true\nsea_state = 5"))
    scenario = load_scenario(str(path)).model_copy(update={"plots": PlotSettings(threshold="known")})
    (its,) = bench([scenario], 1, program(tmp_path, ECHO), tmp_path / "out")[0]["scenarios"]
    assert its["remark"].startswith("2 of 2 scans flood the plot extractor; scan ")
    assert 'set threshold to "marine"' in its["remark"]


def test_after_three_hangs_the_bench_stops(
    tmp_path: Path, made: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the looks, which here decide nothing."""
    monkeypatch.setattr(ProcessTracker.__init__, "__defaults__", (0.2,))
    monkeypatch.setattr(verdicts, "boundaries", lambda looks: ((2, -1, 10), (9, -1, 10)))
    hangs = program(tmp_path, "import time; time.sleep(60)")
    with pytest.raises(
        TrackerError,
        match="no answer \\(a line, flushed\\) to scan 0 within 0.2 s; 3 runs hung, so the bench stops, at small, seed 2",
    ):
        bench([small(tmp_path, 4)], 9, hangs, tmp_path / "out", looks=(2, 9))
    assert len(made) == 3
    (scenario,) = bench([small(tmp_path, 4)], 2, hangs, tmp_path / "out")[0]["scenarios"]
    assert [failure["scan"] for failure in scenario["failures"]] == [0, 0]


@pytest.mark.parametrize("wrong", ["no-such-program", "no_such_module:T"])
def test_a_tracker_that_does_not_start_is_told_before_any_run(
    wrong: str, tmp_path: Path, made: list[tuple[str, int]]
) -> None:
    with pytest.raises(TrackerError, match=f"'{wrong}' (could not be started|made no tracker)"):
        bench([small(tmp_path, 4)], 9, wrong, tmp_path / "out")
    assert not made and not (tmp_path / "bench-plots").exists()


def test_a_server_that_is_not_there_ends_the_bench_after_three_tries(tmp_path: Path, made: list[tuple[str, int]]) -> None:
    for seeds, tries in ((9, 3), (1, 4)):
        with pytest.raises(TrackerError, match="ws://127.0.0.1:1"):
            bench([small(tmp_path, 4)], seeds, "ws://127.0.0.1:1/", tmp_path / "out")
        assert len(made) == tries


def test_kept_runs_need_no_tracker(tmp_path: Path, made: list[tuple[str, int]]) -> None:
    """A command whose runs are all kept starts nothing; one that lacks those of a later look is checked, once."""
    first = bench([small(tmp_path, 4)], 1, program(tmp_path, ECHO), tmp_path / "out")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench_module, "check_start", lambda *_: pytest.fail("a start"))
        assert bench([small(tmp_path, 4)], 1, program(tmp_path, ECHO), tmp_path / "out") == first and len(made) == 1
        starts = list[Any]()
        patch.setattr(bench_module, "check_start", lambda *given: starts.append(given))
        patch.setattr(verdicts, "boundaries", lambda looks: tuple((look, -1, 10) for look in looks))
        bench([small(tmp_path, 4)], 3, program(tmp_path, ECHO), tmp_path / "out", looks=(1, 2, 3))
    assert len(made) == 3 and len(starts) == 1


def test_plots_are_made_once_for_all_trackers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench([small(tmp_path, 4)], 2, "gnn", tmp_path / "one")
    monkeypatch.setattr(kept_plots, "observed", None)  # any call fails
    assert bench([small(tmp_path, 4)], 2, program(tmp_path, ECHO), tmp_path / "two")[0]["version"]
    assert sorted(path.name for path in (tmp_path / "bench-plots").iterdir()) == ["small-0.json.gz", "small-1.json.gz"]


def test_the_plots_of_many_runs_are_made_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the first run; where these have plots or are kept, no more."""
    calls, keep = list[tuple[int, ...]](), bench_module.keep_plots

    def run(scenario: Scenario, seed: int, tracker: str, plots: Path, sealed: None) -> dict[str, Any]:
        monkeypatch.setattr(kept_plots, "observed", None)  # any call fails
        kept_plots.observed_run(plots, scenario, seed)
        return {"failure": None, "metrics": {}, "scans": [], "scenario": scenario.name, "seed": seed}

    monkeypatch.setattr(bench_module, "keep_plots", lambda *given: calls.append(tuple(given[2])) or keep(*given))
    for _ in range(2):
        runs = bench_module.runs_of(run, [small(tmp_path, 2)], 8, "gnn", tmp_path / "out", None, lambda some, _: some, None)
    assert calls == [tuple(range(8))] and len(runs["small"]) == 8


def test_a_scenario_ends_at_a_look_and_runs_that_pass_keep_no_scans(
    tmp_path: Path, made: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With limits that four runs decide: all of the scenario that passes miss nothing, all of the other one everything."""
    monkeypatch.setattr(verdicts, "boundaries", lambda looks: ((2, -1, 3), (4, 0, 4), (6, 1, 5)))
    scenario = small(tmp_path, 2).model_copy(update={"not_judged": ("*",)})
    (limit,) = scenario.limit
    passes = scenario.model_copy(
        update={"limit": (limit.model_copy(update={"metric": "answer_turns", "minimum": None, "maximum": 1e9}),)}
    )
    fails = scenario.model_copy(update={"name": "fails", "limit": (limit.model_copy(update={"metric": "none"}),)})
    report, runs = bench([passes, fails], 6, program(tmp_path, ECHO), tmp_path / "out", looks=(2, 4, 6))
    assert [(len(its["seeds"]), its["verdicts"][0]["word"]) for its in report["scenarios"]] == [(4, "pass"), (4, "fail")]
    assert len(made) == 8 and [len(run["scans"]) for some in runs.values() for run in some] == [2, 0, 0, 0, 2, 2, 2, 2]
