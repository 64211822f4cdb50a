"""Charts of scenes."""

import pickle
import subprocess
from concurrent.futures import Future
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from radar_service.study.chart import chart
from tests.scenes import scene
from tests.study.chart.settings import SMALL


def test_a_scene_with_nothing_in_sight_is_refused() -> None:
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK)


class Pickling:
    """An executor that does each job at once, with what is left of it after pickling."""

    def __init__(self) -> None:
        self.calls = 0

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        self.calls += 1
        function, arguments = pickle.loads(pickle.dumps((function, arguments)))
        future: Future[Any] = Future()
        future.set_result(function(*arguments))
        return future


def test_panels_are_measured_wherever_an_executor_says() -> None:
    elsewhere = Pickling()
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK, executor=elsewhere)
    assert elsewhere.calls == 2  # panels that show whether there is anything to compare


GIT = ("git", "-c", "user.name=test", "-c", "user.email=test@localhost")


def test_the_commit_of_a_checkout_marks_local_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = tmp_path / "chart.py"
    module.write_text("one")
    for arguments in (("init", "-q"), ("add", "."), ("commit", "-q", "-m", "first")):
        subprocess.run([*GIT, *arguments], cwd=tmp_path, check=True)
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=tmp_path, check=True, capture_output=True, text=True)
    monkeypatch.setattr(chart, "HERE", module)
    assert chart.commit() == head.stdout.strip()
    module.write_text("two")
    assert chart.commit() == head.stdout.strip() + "+"


def test_outside_of_a_checkout_the_version_stands_for_the_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chart, "HERE", tmp_path / "chart.py")
    assert chart.commit().startswith("version ")


def test_a_machine_names_what_times_depend_on() -> None:
    machine = chart.machine()
    assert {"processor", "cores", "system", "python", "numpy", "scipy", "embreex"} == set(machine) and all(machine.values())


def test_a_missing_library_is_named_as_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """embreex has no wheel for Linux on ARM."""

    def version(name: str) -> str:
        if name == "embreex":
            raise PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(chart, "version", version)
    machine = chart.machine()
    assert (machine["embreex"], machine["numpy"]) == ("not installed", "1.0")
