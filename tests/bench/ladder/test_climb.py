"""Trackers on a ladder: the same plots, failed runs count as the worst, kept runs are used, and the report adds up."""

import sys
from pathlib import Path

import numpy as np
import pytest

from radar_service.bench import bench as bench_module
from radar_service.bench import kept_plots
from radar_service.bench.bench import Runs
from radar_service.bench.blind import can_seal
from radar_service.bench.ladder import climb as climb_module
from radar_service.bench.ladder.climb import check_length, climb, losses_of, names_of, report
from radar_service.bench.scenario import ScenarioError
from radar_service.bench.trackers.json_lines import TrackerError
from tests.bench.ladder.test_series import LADDER, ladder
from tests.bench.trackers.test_process_tracker import ECHO, program


def runs(values: list[list[float | None]]) -> Runs:
    """Runs of two rungs by seed, with these values of OSPA [m]; None: the tracker failed."""
    return {
        f"noisy-{rung + 1}": [
            {"failure": None, "metrics": {"ospa_m": value}} if value is not None else {"failure": {}, "metrics": {}}
            for value in some
        ]
        for rung, some in enumerate(values)
    }


def test_no_value_and_a_larger_one_count_as_the_worst(tmp_path: Path) -> None:
    losses = losses_of(ladder(tmp_path), runs([[3.0, None], [250.0, 199.0]]))
    assert np.array_equal(losses, [[3.0, 200.0], [200.0, 199.0]])


def test_the_report_adds_up(tmp_path: Path) -> None:
    """Ten seeds: better by 1 m on the first rung, worse by 3 m on the second, so worse by 1 m on the ladder."""
    easy, hard = np.linspace(2.0, 4.0, 10), np.linspace(20.0, 60.0, 10)
    own = runs([(easy - 1.0).tolist(), (hard + 3.0).tolist()])
    its = report([ladder(tmp_path)], {"gnn": runs([easy.tolist(), hard.tolist()]), "mine": own})
    (only,) = its["ladders"]
    assert (its["seeds"], only["metric"], only["values"]) == (10, "ospa_m", (1.0, 30.0))
    mine = next(row for row in only["trackers"] if row["tracker"] == "mine")
    assert [rung["word"] for rung in mine["rungs"]] == ["better", "worse"] and mine["failed_runs"] == 0
    assert [rung["mean"] for rung in mine["rungs"]] == pytest.approx([2.0, 43.0])
    assert [rung["p"] for rung in mine["rungs"]] == [2 / 2**10] * 2
    (pair,) = only["pairs"]
    assert pair["sentence"] == "gnn is better than mine" and pair["difference"] == pytest.approx(-1.0)
    assert [(row["tracker"], row["place"]) for row in its["leaderboard"]] == [("gnn", 1), ("mine", 2)]
    assert its["leaderboard"][0]["mean"] == pytest.approx((3.0 + 40.0) / 2.0 / 200.0)
    reference = next(row for row in only["trackers"] if row["tracker"] == "gnn")
    assert [rung["word"] for rung in reference["rungs"]] == [None, None]


def test_failed_runs_are_counted(tmp_path: Path) -> None:
    its = report([ladder(tmp_path)], {"gnn": runs([[1.0, 2.0], [3.0, None]])})
    assert its["ladders"][0]["trackers"][0]["failed_runs"] == 1
    assert its["ladders"][0]["leaderboard"][0]["mean"] == pytest.approx((1.0 + 2.0 + 3.0 + 200.0) / 4.0)


def test_a_metric_that_no_run_has_is_refused(tmp_path: Path) -> None:
    named = ladder(tmp_path).model_copy(update={"metric": "foo"})
    with pytest.raises(ScenarioError, match="metric: 'foo' is none of a run; there are ospa_m"):
        report([named], {"gnn": runs([[1.0], [2.0]])})


def test_two_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="two have the same name"):
        climb([ladder(tmp_path)] * 2, 2, [], tmp_path / "out")


def test_a_second_command_makes_no_run_and_all_trackers_get_the_same_plots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reference is another program here: it takes part though it is not named, and the same program is not told apart."""
    echo = program(tmp_path, ECHO)
    monkeypatch.setattr(climb_module, "REFERENCE", f"{echo} --again")
    noisy = ladder(tmp_path, LADDER.replace("6", "3").replace("[set]", 'metric = "false_plots"\n[set]'))
    made = climb([noisy], 2, [echo], tmp_path / "out")
    assert [row["tracker"] for row in made["ladders"][0]["trackers"]] == [f"{echo} --again", echo]
    assert made["pairs"][0]["p"] == 1.0 and "too few seeds" in made["pairs"][0]["sentence"]
    rungs = made["ladders"][0]["trackers"][1]["rungs"]
    assert rungs == [{**rung, "p": 1.0, "word": None} for rung in made["ladders"][0]["trackers"][0]["rungs"]]
    assert sorted(path.name for path in (tmp_path / "bench-plots").iterdir()) == [
        f"noisy-{rung}-{seed}.json.gz" for rung in (1, 2) for seed in (0, 1)
    ]
    monkeypatch.setattr(kept_plots, "observed", None)  # any call fails
    monkeypatch.setattr(bench_module, "_watched", lambda outcomes, counts: pytest.fail("a run") if list(outcomes) else [])
    assert climb([noisy], 2, [echo], tmp_path / "out") == made


@pytest.mark.parametrize(
    ("code", "message"), [("raise ValueError('no licence')", "no licence"), (None, "could not be started")]
)
def test_all_trackers_are_tried_before_the_first_run(
    code: str | None, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last one is wrong, and nothing is run for the ones before it."""
    echo, wrong = program(tmp_path, ECHO), "no-such-program"
    if code:
        (tmp_path / "wrong.py").write_text(code)
        wrong = f"{sys.executable} {tmp_path / 'wrong.py'}"
    monkeypatch.setattr(climb_module, "REFERENCE", echo)
    with pytest.raises(TrackerError, match=message):
        climb([ladder(tmp_path)], 2, [wrong], tmp_path / "out")
    assert not (tmp_path / "out" / "runs").exists() or not [*(tmp_path / "out" / "runs").iterdir()]
    assert not (tmp_path / "bench-plots").exists()


def test_a_ladder_that_is_too_short_to_judge_is_refused_after_the_reference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six scans of 2.5 s: no state is owed, so all trackers would have the worst figure."""
    echo = program(tmp_path, ECHO)
    monkeypatch.setattr(climb_module, "REFERENCE", echo)
    with pytest.raises(
        ScenarioError, match="noisy-1: scans: 6 give no ospa_m: a state is owed from 60 s after .*; give more scans"
    ):
        climb([ladder(tmp_path)], 2, [f"{echo} --again"], tmp_path / "out")


def test_a_tracker_that_loses_all_targets_is_no_short_ladder(tmp_path: Path) -> None:
    """It has no localisation, and owes one."""
    lost = {"failure": None, "metrics": {"localisation_m": None, "completeness": 0.0}}
    named = ladder(tmp_path).model_copy(update={"metric": "localisation_m"})
    check_length([named], {rung.name: [lost] for rung in named.rungs})
    with pytest.raises(ScenarioError, match="noisy-1: scans: 6 give no localisation_m"):
        check_length([named], {rung.name: [{"failure": None, "metrics": {"completeness": None}}] for rung in named.rungs})


@pytest.mark.parametrize(
    ("trackers", "names", "called"),
    [
        (["jpda"], [], ["jpda"]),
        (["python -m my.trackers Kalman", "jpda", "python -m my.trackers Truth"], [], ["Kalman", "jpda", "Truth"]),
        (["mine:Good", "mine:Goods"], [], ["Good", "Goods"]),
        (["python t.py", "python t.py --fast"], [], ["t.py", "t.py --fast"]),
        (["ws://a:1/one", "ws://a:2/one"], [], ["1/one", "2/one"]),
        (["python t.py"], [], ["python t.py"]),
        (["python t.py gnn", "python t.py b"], [], ["python t.py gnn", "python t.py b"]),
        (["python t.py", "jpda"], ["mine", "theirs"], ["mine", "theirs"]),
    ],
)
def test_trackers_are_called_by_their_names_or_without_the_words_that_all_begin_with(
    trackers: list[str], names: list[str], called: list[str]
) -> None:
    assert names_of(trackers, names) == {"gnn": "gnn", **dict(zip(trackers, called, strict=True))}


@pytest.mark.parametrize("names", [["a"], ["a", "a"], ["a", "gnn"], ["a", "b", "c"]])
def test_names_that_do_not_fit_are_refused(names: list[str]) -> None:
    with pytest.raises(ScenarioError, match="--name: a.*: each of 2 --tracker needs a name of its own, none gnn"):
        names_of(["x", "y"], names)


@pytest.mark.skipif(not can_seal(), reason="Landlock is absent")
def test_a_program_cannot_read_the_ladder_of_its_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = ladder(tmp_path)
    reads = program(tmp_path, f"import sys; sys.stdin.readline(); open({str(own.file)!r}).read(); sys.exit('it is read')")
    monkeypatch.setattr(climb_module, "REFERENCE", reads)
    with pytest.raises(TrackerError, match="PermissionError"):
        climb([own], 1, [reads], tmp_path / "out", blind=True)
