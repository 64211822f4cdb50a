"""A fresh virtual environment, outside the tree, in which pip has installed the foreign packages of `packages`."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from site import getsitepackages

import pytest

PACKAGES, ROOT = Path(__file__).parent / "packages", Path(__file__).parents[2]
BUILD = """
import os, sys
from setuptools import build_meta
wheels, *sources = sys.argv[1:]
for source in sources:
    os.chdir(source)
    build_meta.build_wheel(wheels)
"""  # as pip has them built, but all in one process


def tree() -> dict[Path, int]:
    """When each source file of this project was changed."""
    folders = (ROOT / name for name in ("radar_service", "clients", "scenes"))
    files = [file for folder in folders for file in folder.rglob("*") if file.is_file() and file.suffix != ".pyc"]
    return {file: file.stat().st_mtime_ns for file in (*files, ROOT / "pyproject.toml")}


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The Python of the environment. No file of this project is changed for it."""
    pytest.importorskip("setuptools", minversion="77", reason="setuptools 77 or newer is needed to build offline")
    before, folder = tree(), tmp_path_factory.mktemp("foreign")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    python = folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    where = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    site = Path(subprocess.run(where, check=True, capture_output=True, text=True).stdout.strip())
    outer = "".join(f"site.addsitedir({path!r}); " for path in getsitepackages())
    (site / "outer.pth").write_text(f"import site; {outer}\n")  # this project and what it needs, as they are installed here
    copies: Path = shutil.copytree(PACKAGES, folder / "sources", ignore=shutil.ignore_patterns("__pycache__"))
    sources = [file.parent for file in copies.glob("*/pyproject.toml")]
    subprocess.run([sys.executable, "-c", BUILD, folder / "wheels", *sources], check=True, capture_output=True)
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index"]
    subprocess.run([*pip, *(folder / "wheels").glob("*.whl")], check=True, capture_output=True)
    yield python
    assert tree() == before
