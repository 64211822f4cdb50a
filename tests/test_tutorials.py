"""The tutorials work as they are written: their files are saved, their commands run, in order, in an empty folder."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from radar_service.__main__ import main
from radar_service.commands.command_line import parser

ROOT = Path(__file__).parents[1]
PROGRAM = ".venv/bin/radar-service"
SAVED = re.compile(r"Save this as `([^`]+)`.*?\n```\w+ no-run\n(.*?)^```$", flags=re.M | re.S)
FEWER_CELLS = {
    "range_max_m = 4000\nbeamwidth_deg = 1.9": "range_max_m = 4000\nbeamwidth_deg = 8\nazimuths = 90\nbandwidth_hz = 5e6",
    "WIDTH, HEIGHT = 706, 834": "WIDTH, HEIGHT = 88, 104",
}

cells = pytest.mark.parametrize("cells", ["fewer", pytest.param("as printed", marks=pytest.mark.study)])


def tutorial(name: str, cells: str = "as printed") -> str:
    """A tutorial, where asked with scenes of a hundredth of the cells, and of the map."""
    text = (ROOT / "docs" / f"tutorial-{name}.md").read_text(encoding="utf-8")
    for printed, fewer in FEWER_CELLS.items() if cells == "fewer" else ():
        text = text.replace(printed, fewer)
    return text


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of exactly that language tag."""
    return [body for tag, body in re.findall(r"^```(.*?)\n(.*?)^```$", text, flags=re.M | re.S) if tag == language]


def save(text: str, folder: Path) -> None:
    """Saves the files that a tutorial asks for."""
    for name, content in SAVED.findall(text):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(content)


def run(command: str, status: int = 0) -> None:
    """Runs a command of a tutorial, which ends with a status; of `serve` the arguments alone are read."""
    words = shlex.split(command.replace('"python ', f'"{sys.executable} '))
    if words[0] != PROGRAM:
        words[0] = sys.executable if words[0] == ".venv/bin/python" else words[0]
        subprocess.run(words, check=True, timeout=60)
    elif words[1] == "serve":
        parser().parse_args(words[1:])
    else:
        assert main(words[1:]) == status


def commands(block: str) -> list[str]:
    """The commands of a block."""
    return [line for line in block.splitlines() if line]


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder with what a tutorial takes from the checkout."""
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def own_harbour(folder: Path, cells: str, look: bool) -> None:
    """Follows the first tutorial. look: whether to look at the scene with each command, and not only to make its files."""
    text = tutorial("harbour", cells)
    save(text, folder)
    broken_gyro = blocks(text, "toml no-run")[1]
    for number, block in enumerate(blocks(text, "")):
        if number == 3:
            with (folder / "my-harbour" / "harbour.toml").open("a") as scene:
                scene.write(broken_gyro)
        for command in commands(block):
            if look or not command.startswith(PROGRAM):
                run(command)


@cells
def test_the_harbour_is_made_looked_at_and_broken(cells: str, checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own_harbour(checkout, cells, look=True)
    printed = capsys.readouterr().out
    assert ": 5 bodies" in printed and "+ body ferry" in printed
    assert {file.name for file in (checkout / "my-harbour").glob("*.png")} == {"land.png", "ship.png", "shore.png"}


def test_the_tracker_fails_is_mended_and_passes(checkout: Path) -> None:
    text = tutorial("tracker")
    save(text, checkout)
    first, second, *_ = (block.replace("crossing-cpa-500 fast-craft", "fast-craft --open") for block in blocks(text, ""))
    words = []
    for block, status in ((first, 1), (second, 0)):
        (command,) = commands(block)
        run(command, status)
        (scenario,) = json.loads((checkout / "bench" / "report.json").read_text())["scenarios"]
        words.append({one["metric"]: one["word"] for one in scenario["verdicts"]}["completeness"])
        tracker = checkout / "my_tracker.py"
        tracker.write_text(tracker.read_text().replace("        return GATE\n", blocks(text, "python no-run")[1]))
    assert words == ["fail", "no gross miss"] and len([*(checkout / "bench-plots").iterdir()]) == 3


def test_the_tracker_says_that_a_track_without_plots_coasts(checkout: Path) -> None:
    """A plot in each of four scans, and none in the fifth."""
    save(tutorial("tracker"), checkout)
    plots = [[{"time": 2.5 * k, "east": 20.0 * k, "north": 1000.0}] for k in range(1, 5)]
    scans = [{"type": "scan", "scan": k, "plots": some} for k, some in enumerate([*plots, []])]
    lines = "".join(json.dumps(scan) + "\n" for scan in scans)
    command = [sys.executable, "my_tracker.py"]
    answers = subprocess.run(command, input=lines, capture_output=True, text=True, check=True, timeout=60).stdout
    tracks = [json.loads(line)["tracks"] for line in answers.splitlines()]
    assert [[track["coasting"] for track in some] for some in tracks] == [[], [], [False], [False], [True]]


@pytest.mark.study
def test_the_test_for_ci_passes_in_the_harbour(checkout: Path) -> None:
    own_harbour(checkout, "as printed", look=False)
    save(tutorial("tracker"), checkout)
    subprocess.run([sys.executable, "-m", "pytest", "-q", "test_my_tracker.py"], check=True, timeout=120)


SMALLER = {"seeds = 125": "seeds = 2", "scans = 8": "scans = 5", " --jobs 2": ""}  # a hundredth of the scans


@pytest.mark.parametrize("size", ["a hundredth", pytest.param("as printed", marks=pytest.mark.study)])
def test_a_detector_learns(size: str, checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At a hundredth one run teaches, and one judges. As printed the learnt detector finds more, beyond what chance gives."""
    text = tutorial("detector")
    for printed, fewer in SMALLER.items() if size == "a hundredth" else ():
        assert printed in text
        text = text.replace(printed, fewer)
    save(text, checkout)
    for command in commands(blocks(text, "")[0]):
        run(command)
    assert f"{2 if size == 'a hundredth' else 125} runs, 0 were there already, 0 failed" in capsys.readouterr().out
    names: dict[str, Any] = {}
    exec("\n".join(blocks(text, "python no-run")), names)
    table = names["table"]
    assert len(table) == 6 and all(0.0 <= pfa < 0.1 and 0.0 <= pd <= 1.0 for pfa, pd in table.values())
    if size == "as printed":
        boats = names["results"]["learnt", 1e-3][3]
        for rate in (1e-3, 1e-4):
            (of_cfar, cfar), (of_learnt, learnt) = table["CA-CFAR", rate], table["learnt", rate]
            assert rate / 3 < min(of_cfar, of_learnt) <= max(of_cfar, of_learnt) < 3 * rate
            both = (cfar + learnt) / 2.0
            assert learnt - cfar > 2.0 * (2.0 * both * (1.0 - both) / boats) ** 0.5  # two standard deviations of chance
