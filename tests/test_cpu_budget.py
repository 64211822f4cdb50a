"""Processor time is added up by folder, over the workers of a run, and a folder far above its budget fails the run."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

from tests.cpu_budget import COLLECTION, excesses, folder_of, pace

BUSY = """
import time

def test_busy():
    end = time.process_time() + 0.3
    while time.process_time() < end:
        pass
"""


def test_tests_belong_to_the_folder_below_tests() -> None:
    assert folder_of("tests/ports/test_app.py::test_x[a/b::c]") == "ports"
    assert folder_of("tests/test_main.py::test_x[a/b/c]") == "."


def test_only_a_clear_excess_is_one() -> None:
    spent, budget = (
        {"echo": 14.9, "scene": 15.1, "trace": 9.0, "wire": 8.0, "new": 0.5},
        dict.fromkeys(["echo", "scene", "trace", "wire"], 10),
    )
    scene, new = excesses(spent, budget, 1.5)
    assert scene.startswith("scene took 15.1 s") and "1.5 times its budget of 10 s" in scene and new.startswith("new took")


def test_a_slower_machine_is_no_excess_and_a_folder_that_doubled_on_it_is() -> None:
    budget = {"echo": 10, "scene": 10, "trace": 2, "wire": 2}
    slow = {folder: 3.0 * seconds for folder, seconds in budget.items()}
    assert excesses(slow, budget, 2.0) == [] and pace(slow, budget) == 3.0
    [only] = excesses(slow | {"scene": 61.0}, budget, 2.0)
    assert only.startswith("scene took 61.0 s") and "a machine that takes 3 s for one" in only


def test_a_run_whose_folder_is_far_above_its_budget_fails(tmp_path: Path) -> None:
    budget, test = tmp_path / "budget.toml", tmp_path / "tests" / "busy" / "test_busy.py"
    budget.write_text(f'factor = 2\nseconds = {{"{COLLECTION}" = 100, busy = 0.1}}\n')
    test.parent.mkdir(parents=True)
    test.write_text(BUSY)
    plugins = ["-p", "xdist", "-p", "tests.cpu_budget", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *plugins, "-n", "1", "--cpu-budget", str(budget), "tests"]
    root = str(Path(__file__).parents[1])
    tree = os.environ | {"PYTHONPATH": root, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": ""}
    result = subprocess.run(command, cwd=tmp_path, env=tree, capture_output=True, text=True, timeout=120)
    lines = result.stdout.splitlines()
    row = next(line.split() for line in lines if line.startswith("busy "))
    assert 0.3 <= float(row[1]) < 3.0 and row[2] == "0.1"  # 0.3 s, and what pytest does about a test on a busy machine
    assert f"busy took {row[1]} s" in result.stdout and "1 passed" in result.stdout
    assert any(line.startswith(COLLECTION) and float(line.split()[1]) > 0.0 for line in lines)  # of the worker
    assert result.returncode == 1


def test_each_folder_of_tests_has_a_budget() -> None:
    here = Path(__file__).parent
    with_tests = {folder_of(str(path.relative_to(here.parent))) for path in here.rglob("test_*.py")}
    budget = tomllib.loads((here / "cpu_budget.toml").read_text(encoding="utf-8"))["seconds"]
    assert with_tests <= set(budget)
