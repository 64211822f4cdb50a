"""The command `plots` as a user runs it."""

import json
import re
from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.commands.command_line import parser
from tests.plots.test_plot_report import SCENE


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(SCENE))
    return str(path)


def test_plots_are_printed_and_written(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, png = tmp_path / "plots.json", tmp_path / "plots.png"
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "-o", str(out), "--png", str(png)]) == 0
    lines = capsys.readouterr().out.splitlines()
    data = json.loads(out.read_text())
    assert lines[0] == f"five kinds: 1 scans, {len(data['plots'])} plots"
    rows = {line.split("  ")[0]: line.split() for line in lines}
    assert rows["moored"][1:] == ["ship", "300", "m", "1", "1", "1", "1"] and rows["far"][-1] == "-"
    noise = next(kind for kind in data["kinds"] if kind["kind"] == "noise")
    assert rows["noise"][1:3] == [str(noise["cells"]), str(noise["detected"])]
    assert png.read_bytes().startswith(b"\x89PNG")


def test_a_flood_is_told_at_once_on_standard_error(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "--pfa", "0.3"]) == 0
    printed, told = capsys.readouterr()
    assert told.splitlines()[0].startswith("scan 0: ") and "lower pfa (now 0.3)" in told.splitlines()[0]
    assert "remark: 3 of 3 scans flood" in printed


@pytest.mark.parametrize(("nearest", "with_plot"), [("250", "1"), ("350", "0")])
def test_plots_nearer_than_a_distance_are_left_out(
    nearest: str, with_plot: str, scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A flood asks for it. The ship is moored at 300 m."""
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "--nearest-m", nearest]) == 0
    (moored,) = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("moored")]
    assert moored[-2] == with_plot


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--pfa", "0"], "0 is not allowed; a probability between 0 and 1"),
        (["--pfa", "nan"], "nan is not allowed; a probability"),
        (["--nearest-m", "x"], "x is not allowed; a length above 0 m"),
        (["--fidelity", "documented"], "documented has no labels"),
        (["-o", "/dev/null/plots.json"], "a file is in the way of this folder"),
        (["--png", "plots.jpg"], "does not end in .png"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: list[str], words: str, scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["plots", scene, "--scans", "1", *arguments])
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert re.search(words, capsys.readouterr().err)


def test_plots_have_defaults() -> None:
    options = parser().parse_args(["plots"])
    assert (options.scene, options.scans, options.threshold, options.pfa) == ("harbour", 10, None, None)
    assert (options.nearest_m, options.out, options.png) == (0.0, None, None)
