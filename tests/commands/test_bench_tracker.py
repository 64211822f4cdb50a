"""The command `bench-tracker` as a user runs it."""

import json
import re
from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.batch.jobs import JobsFailed
from radar_service.bench.scenario import scenarios
from radar_service.commands.command_line import parser
from tests.bench.test_bench import FILE

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")


def test_the_list_has_a_scenario_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench-tracker", "--list"]) == 0
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == list(scenarios())


def test_a_run_writes_a_report_and_compares(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "small.toml", tmp_path / "out"
    path.write_text(FILE.format(scans=12))
    assert main(["bench-tracker", str(path), "--seeds", "1", "--jobs", "1", "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"small +held +\S+ +at least 1 +1 of 1  undecided, more seeds\n", printed)
    assert str(out / "report.html") in printed
    report = json.loads((out / "report.json").read_text())
    assert report["scenarios"][0]["seeds"] == [0] and report["tracker"] == "gnn"
    assert main(["bench-tracker", "--compare", str(out / "report.json"), str(out / "report.json")]) == 0
    assert "ospa_m" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "name at least one scenario and a folder"),
        (["crossing-cpa-500"], "name at least one scenario and a folder"),
        (["fly", "-o", "x"], "there is no such scenario"),
        (["crossing-cpa-500", "-o", "x", "--tracker", "no-such-program --x"], "could not be started"),
        (["--compare", "a.json", "b.json"], "a.json: No such file"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["bench-tracker", *arguments, *(["--jobs", "1"] if arguments else [])]) == 2
    assert message in capsys.readouterr().err


def test_defaults_and_values() -> None:
    options = parser().parse_args(["bench-tracker", "a", "b", "-o", "out", "--seeds", "59"])
    assert (options.scenarios, options.seeds, options.tracker, str(options.out)) == (["a", "b"], 59, "gnn", "out")
    assert options.jobs >= 1 and not options.list and options.compare is None


@pytest.mark.parametrize("wrong", [["--seeds", "0"], ["--jobs", "0"], ["--compare", "one.json"]])
def test_wrong_values_are_refused(wrong: list[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(["bench-tracker", *wrong])


def test_a_fault_of_a_tracker_in_python_is_not_one_word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`'x'` would be all that a KeyError says: its traceback names the line."""
    (tmp_path / "faulty.py").write_text("class T:\n    def update(self, scan):\n        return {}['x']\n")
    (tmp_path / "small.toml").write_text(FILE.format(scans=2))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(JobsFailed) as failed:
        main(["bench-tracker", "small.toml", "--seeds", "1", "--jobs", "1", "--tracker", "faulty:T", "-o", "out"])
    assert isinstance(failed.value.__cause__, KeyError)
