"""The command `bench-ladder` as a user runs it."""

import json
from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.bench.ladder.series import ladders
from tests.bench.ladder.test_series import LADDER, ladder

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")


def test_the_list_has_a_ladder_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench-ladder", "--list"]) == 0
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == list(ladders())


def test_a_tracker_is_ranked_against_the_reference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "none.py").write_text("class T:\n    def update(self, scan):\n        return []\n")
    monkeypatch.chdir(tmp_path)
    ladder(
        tmp_path, LADDER.replace("6", '14\n"scene.radar.rpm" = 12')
    )  # a state is owed after a minute, from the 13th scan on
    command = ["bench-ladder", "noisy.toml", "--seeds", "2", "--jobs", "1", "--tracker", "none:T", "-o", "out", "--open"]
    assert main(command) == 0
    printed, told = capsys.readouterr()
    assert told.startswith("too few seeds: 6 are needed to tell 2 trackers apart\n")
    assert "too few seeds to tell gnn and none:T apart: 6 are needed (p = 0.5)" in printed and "out/report.html" in printed
    report = json.loads(Path("out/report.json").read_text())
    assert [row["tracker"] for row in report["leaderboard"]] == ["gnn", "none:T"]
    assert report["leaderboard"][1]["mean"] == 1.0 > report["leaderboard"][0]["mean"]
    assert report["seeds"] == 2 and Path("bench-plots/noisy-2-1.json.gz").exists()
