"""Every build has the kernels: who compiles them, and in which words a build ends that has nobody to do so."""

import subprocess
import sys
from pathlib import Path

import pytest
from setuptools import Distribution, Extension

from radar_service.kernels import build_backend

FOLDER = Path(build_backend.__file__).parent


def sentence(folder: Path) -> str:
    """How a build of the kernels ends that cannot go on."""
    build = build_backend.KernelBuild(Distribution())
    build.build_lib = str(folder)
    with pytest.raises(SystemExit) as ended:
        build.build_extension(Extension("compiled", []))
    return str(ended.value)


@pytest.mark.parametrize("command", ["/bin/false", "/nowhere/cc -m64"])
def test_without_a_compiler_that_works_a_build_asks_for_ziglang(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", command)
    assert build_backend.compiler() is None
    for asked in (build_backend.get_requires_for_build_wheel, build_backend.get_requires_for_build_editable):
        assert asked() == [build_backend.COMPILER]


def test_where_a_compiler_works_a_build_asks_for_none_but_on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_backend, "_compiles", lambda command: command[0] == "gcc")
    monkeypatch.delenv("CC", raising=False)
    assert build_backend.compiler() == ["gcc"]
    assert build_backend.get_requires_for_build_wheel() == []
    monkeypatch.setattr(sys, "platform", "win32")
    assert build_backend.get_requires_for_build_wheel() == [build_backend.COMPILER]


def test_a_build_that_finds_no_compiler_ends_in_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As with `--no-build-isolation` on a machine that has none."""
    monkeypatch.setattr(build_backend, "compiler", lambda: None)
    monkeypatch.setattr(build_backend, "find_spec", lambda _: None)
    assert "no C compiler works here: install one" in sentence(tmp_path) and "\n" not in sentence(tmp_path)


def test_a_build_that_fails_ends_in_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_backend, "compiler", lambda: [sys.executable, "-c", "raise SystemExit(1)"])
    assert sentence(tmp_path).endswith("could not compile the kernels of radar-service: its words are above")


def test_the_backend_is_imported_where_there_is_setuptools_alone() -> None:
    look = (
        f"import sys; sys.path.insert(0, {str(FOLDER)!r}); import build_backend; "
        "print({'numpy', 'radar_service', 'pydantic'} & {*sys.modules})"
    )
    assert subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True).stdout == "set()\n"
