"""The command `bench-tracker` as a user runs it."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from radar_service.__main__ import main
from radar_service.bench.run import simulator_of
from radar_service.bench.scenario import load_scenario, scenarios
from radar_service.commands.bench_tracker import UNDECIDED
from radar_service.recording import read
from tests.bench.test_bench import FILE

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")


def test_the_list_has_a_scenario_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench-tracker", "--list"]) == 0
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == list(scenarios())


def test_a_run_writes_a_report_and_compares(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "small.toml", tmp_path / "out"
    path.write_text(FILE.format(scans=12))
    assert main(["bench-tracker", str(path), "--seeds", "1", "--jobs", "1", "-o", str(out)]) == UNDECIDED
    printed = capsys.readouterr().out
    assert re.search(r"small +held +\S+ +at least 1 +1 of 1  undecided\n", printed)
    assert str(out / "report.html") in printed
    report = json.loads((out / "report.json").read_text())
    assert report["scenarios"][0]["seeds"] == [0] and report["tracker"] == "gnn"
    assert main(["bench-tracker", "--compare", str(out / "report.json"), str(out / "report.json")]) == 0
    assert "ospa_m" in capsys.readouterr().out


def faulty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scans: int = 3) -> list[str]:
    """A command with a tracker that raises a KeyError."""
    (tmp_path / "faulty.py").write_text("class T:\n    def update(self, scan):\n        return {}['x']\n")
    (tmp_path / "small.toml").write_text(FILE.format(scans=scans))
    monkeypatch.chdir(tmp_path)
    return ["bench-tracker", "small.toml", "--jobs", "1", "--tracker", "faulty:T", "-o", "out"]


def test_a_tracker_that_raises_is_a_failed_run_that_is_made_again_by_its_seed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`'x'` is all that a KeyError says: the last line of its traceback names it. It is made again by a command of the report."""
    assert main([*faulty(tmp_path, monkeypatch), "--smoke"]) == 1
    printed = capsys.readouterr().out
    assert printed.startswith("3 seeds of each scenario: gross misses fail; a third of them in clutter\n")
    lines = [line for line in printed.splitlines() if line.startswith("small, seed ") and ": failed at scan 0: " in line]
    assert len({*lines}) == 3 and all(line.endswith("exit status 1; it said: KeyError: 'x'") for line in lines)
    assert not any(line.startswith("small, seed 0:") for line in lines)  # blind by default
    again = printed.splitlines()[-2].removeprefix("the worst run again: radar-service ")
    (worst, *_) = json.loads(Path("out/report.json").read_text())["scenarios"][0]["failed_runs"]
    assert main(again.split()) == 1
    assert "run again:" not in capsys.readouterr().out
    one = json.loads(Path("again/report.json").read_text())
    assert one["scenarios"][0]["failed_runs"] == [worst]
    assert one["sheet"]["again"].endswith(f" --seed {worst['seed']}")


def test_strict_takes_undecided_for_failed_and_junit_says_each_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "small.toml").write_text(FILE.format(scans=26))
    monkeypatch.chdir(tmp_path)
    command = ["bench-tracker", "small.toml", "--seeds", "1", "--jobs", "1", "-o", "out", "--junit", "bench.xml"]
    for options, status, kind in (([], UNDECIDED, "skipped"), (["--strict"], 1, "failure")):
        assert main([*command, *options]) == status
        (suite,) = ElementTree.parse("bench.xml").getroot()
        cases = {str(case.get("name")): case for case in suite}
        assert suite.get("name") == "small" and suite.get("tests") == str(len(cases))
        assert cases["held at least 1"].find(kind) is not None and cases["runs"].find("failure") is None
    assert "1 seeds of each scenario can fail, but 1000 are needed to pass; 38 misses of 1000" in capsys.readouterr().out
    assert main([*command, "--tracker", "no-such-program"]) == 2 and not Path("bench.xml").exists()


def test_failed_runs_are_recorded_about_their_gravest_event(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A tracker without a track is late from scan 9 on; the recording has the scans of the run, and its noise."""
    pytest.importorskip("mcap", reason="the extra `record` is absent")
    (tmp_path / "none.py").write_text("class T:\n    def update(self, scan):\n        return []\n")
    (tmp_path / "small.toml").write_text(FILE.format(scans=14))
    monkeypatch.chdir(tmp_path)
    command = ["bench-tracker", "small.toml", "--jobs", "1", "--tracker", "none:T", "-o", "out", "--record", "--open"]
    assert main([*command, "--seeds", "2"]) in (1, UNDECIDED)
    assert "scans 7 to 11: radar-service replay out/small-seed-1.mcap" in capsys.readouterr().out
    simulator = simulator_of(load_scenario("small.toml"), 1)
    simulator.skip_to(7)
    scans = list(read(Path("out/small-seed-1.mcap")).scans())
    assert [scan.number for scan in scans] == [7, 8, 9, 10, 11]
    assert np.array_equal(scans[0].field, simulator.scan().field)
