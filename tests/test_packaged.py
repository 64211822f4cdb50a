"""What an installation holds: one package, with the scenes, the page and the client in it, and two commands."""

import configparser
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

from radar_service.kernels import build_backend
from radar_service.scene_file.document import packaged_folder

ROOT = Path(__file__).parents[1]
SOURCES = ("radar_service", "clients", "scenes")
COMPILED = "compiled"  # the kernels that setuptools builds, radar_service/kernels/compiled.*
DOCUMENTS = ("docs", ".github")  # which the source distribution has too
FILES = ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md")


def source_files(folder: str) -> set[str]:
    """Files of a source folder that an installation needs: all of them, without what Python writes itself."""
    files = (ROOT / folder).rglob("*")
    written = ("__pycache__", COMPILED)
    return {
        f.relative_to(ROOT).as_posix()
        for f in files
        if f.is_file() and not {f.parent.name, f.name.split(".")[0]} & {*written}
    }


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel and the source distribution that the installed setuptools builds from a copy of the sources, as pip
    does: by the path that pyproject.toml names. An old build folder cannot leak into them."""
    pytest.importorskip("setuptools", minversion="77", reason="setuptools 77 or newer is needed to build offline")
    if not build_backend.compiler() and not find_spec("ziglang"):
        pytest.skip("no C compiler works here, and ziglang is not installed")
    copy, out = tmp_path_factory.mktemp("copy") / "source", tmp_path_factory.mktemp("built")
    for name in (*SOURCES, *DOCUMENTS):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__", f"{COMPILED}.*"))
    for file in FILES:
        shutil.copy(ROOT / file, copy)
    stale = copy / "build" / f"lib.{sysconfig.get_platform()}-{sys.implementation.cache_tag}" / "radar_service" / "kernels"
    stale.mkdir(parents=True)
    for file in (stale, copy / "radar_service" / "kernels"):  # of other trees
        (file / f"{COMPILED}.other.so").write_bytes(b"of another tree")
    backend = copy / "radar_service" / "kernels" / "build_backend.py"
    backend.write_text(backend.read_text(encoding="utf-8").replace('"-O3"', '"-O0"'), encoding="utf-8")  # 3 s less
    settings = tomllib.loads((copy / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    code = f"import sys; sys.path[:0] = {settings['backend-path']}; import {settings['build-backend']} as backend"
    code += f"; backend.build_sdist({str(out)!r}); backend.build_wheel({str(out)!r})"
    subprocess.run([sys.executable, "-c", code], cwd=copy, check=True, capture_output=True)
    return out


@pytest.fixture
def wheel(built: Path) -> Path:
    return next(built.glob("*.whl"))


def test_wheel_holds_one_package_with_all_source_files(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {name.split("/")[0].partition("-")[0] for name in names} == {"radar_service"}
    installed = source_files("radar_service") | {
        f"radar_service/{name}" for name in source_files("clients") | source_files("scenes")
    }
    inside = {name for name in names if name.startswith("radar_service/")}
    kernels = {name for name in inside if name.startswith(f"radar_service/kernels/{COMPILED}.")}
    assert inside - kernels == installed
    assert len(kernels) == 1 and f"radar_service/kernels/{COMPILED}.other.so" not in kernels


def test_a_source_distribution_carries_the_kernels_who_builds_them_and_all_that_its_page_names(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as archive:
        names = {name.partition("/")[2]: name for name in archive.getnames()}
        page = archive.extractfile(names["PKG-INFO"]).read().decode().partition("\n\n")[2]  # type: ignore[union-attr]
    assert "![" not in page and not re.findall(r"\]\((?!https?:)", page), "an index resolves no path"
    linked = set(re.findall(r"\(`(?!http)([^`#]+)[^`]*`\)", page))
    assert len(linked) > 20 and linked <= names.keys(), linked - names.keys()
    sources = {name for name in source_files("radar_service") if name.endswith((".c", ".h"))}
    assert sources | {"setup.py", "radar_service/kernels/build_backend.py"} <= names.keys()


def test_wheel_has_both_commands(wheel: Path) -> None:
    archive = zipfile.ZipFile(wheel)
    (entry_points,) = (name for name in archive.namelist() if name.endswith("/entry_points.txt"))
    declared = configparser.ConfigParser()
    declared.read_string(archive.read(entry_points).decode())
    assert dict(declared["console_scripts"]) == {
        "radar-service": "radar_service.__main__:main",
        "radar-ppi": "radar_service.clients.ppi.__main__:main",
    }


def test_installed_package_finds_its_scenes_its_page_and_its_client(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    look = """
import sys
import radar_service as rs
from radar_service.clients.ppi import FeedError, spokes
from radar_service.clients.ppi.client import FeedError as raised
from radar_service.kernels import build_backend
from radar_service.scene_file.document import packaged_folder
assert FeedError is raised and "clients" not in sys.modules
assert rs.load_scene("open-sea").name
print(packaged_folder("scenes"), packaged_folder("clients"), sep="\\n")
"""
    command = [sys.executable, "-c", look]
    run = subprocess.run(command, cwd=tmp_path, env={"PYTHONPATH": str(tmp_path / "site")}, capture_output=True, text=True)
    assert run.stdout.split() == [str(tmp_path / "site" / "radar_service" / name) for name in ("scenes", "clients")], (
        run.stderr
    )
    assert (tmp_path / "site" / "radar_service" / "clients" / "web" / "index.html").is_file()


def test_checkout_finds_its_folders_beside_the_package() -> None:
    assert packaged_folder("scenes") == ROOT / "scenes"
    assert (packaged_folder("clients") / "web" / "index.html").is_file()


def test_client_of_a_checkout_loads_each_module_once() -> None:
    look = "import sys, clients.ppi.live; print([name for name in sys.modules if name.startswith('radar_service.clients')])"
    run = subprocess.run([sys.executable, "-c", look], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
