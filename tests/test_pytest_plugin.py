"""The plugin in runs of pytest of its own: the fixture works, and a run that does not use it imports nothing heavy."""

import os
import subprocess
import sys
from pathlib import Path

TRACKER = """
import numpy as np

def test_the_strongest_cell_is_the_target(radar_feed):
    feed = radar_feed("worked-example", seed=1, fidelity="fast")
    for scan in feed.scans(2):
        azimuth, cell = np.unravel_index(scan.power.argmax(), scan.power.shape)
        truth = feed.crossings[-1]
        assert abs(scan.range[cell] - truth.range) < 2.0
        assert abs(scan.azimuth[azimuth] - truth.bearing) < 0.01
"""
PLAIN = """
import sys

def test_plain():
    heavy = {"numpy", "websockets", "scipy", "radar_service.radar_feed", "radar_service.simulator"} & set(sys.modules)
    assert "radar_service.pytest_plugin" in sys.modules and not heavy
"""


def run(folder: Path, code: str, *options: str) -> subprocess.CompletedProcess[str]:
    (folder / "test_it.py").write_text(code)
    command = [sys.executable, "-m", "pytest", "-p", "radar_service.pytest_plugin", "-p", "no:cacheprovider", "-q", *options]
    tree = os.environ | {
        "PYTHONPATH": str(Path(__file__).parents[1]),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTEST_ADDOPTS": "",
    }
    return subprocess.run(command, cwd=folder, env=tree, capture_output=True, text=True, timeout=120)


def test_a_tracker_is_tested_with_the_fixture(tmp_path: Path) -> None:
    result = run(tmp_path, TRACKER, "-W", "error")
    assert result.returncode == 0, result.stdout


def test_a_run_that_does_not_use_it_imports_nothing_heavy(tmp_path: Path) -> None:
    result = run(tmp_path, PLAIN, "-W", "error")
    assert result.returncode == 0, result.stdout


def test_the_distribution_registers_it() -> None:
    """By a name that -p would take too, so that it is registered once."""
    project = (Path(__file__).parents[1] / "pyproject.toml").read_text()
    assert '[project.entry-points.pytest11]\n"radar_service.pytest_plugin" = "radar_service.pytest_plugin"' in project
