"""The commit and the machine of a measurement."""

import subprocess
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from radar_service.study.chart import provenance

GIT = ("git", "-c", "user.name=test", "-c", "user.email=test@localhost")


def test_the_commit_of_a_checkout_marks_local_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = tmp_path / "provenance.py"
    module.write_text("one")
    for arguments in (("init", "-q"), ("add", "."), ("commit", "-q", "-m", "first")):
        subprocess.run([*GIT, *arguments], cwd=tmp_path, check=True)
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=tmp_path, check=True, capture_output=True, text=True)
    monkeypatch.setattr(provenance, "HERE", module)
    assert provenance.commit() == head.stdout.strip()
    module.write_text("two")
    assert provenance.commit() == head.stdout.strip() + "+"


def test_outside_of_a_checkout_the_version_stands_for_the_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "HERE", tmp_path / "provenance.py")
    assert provenance.commit().startswith("version ")


def test_a_machine_names_what_times_depend_on() -> None:
    machine = provenance.machine()
    assert {"processor", "cores", "system", "python", "numpy", "scipy", "embreex"} == set(machine) and all(machine.values())


def test_a_missing_library_is_named_as_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """embreex has no wheel for Linux on ARM."""

    def version(name: str) -> str:
        if name == "embreex":
            raise PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(provenance, "version", version)
    machine = provenance.machine()
    assert (machine["embreex"], machine["numpy"]) == ("not installed", "1.0")
