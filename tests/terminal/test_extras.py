"""Packages that a plain installation lacks: the command that installs them works, wherever it is written."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from importlib.metadata import distributions
from pathlib import Path

import pytest

from radar_service.terminal.extras import MissingExtra, install_command

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def test_the_message_says_how_to_install_it() -> None:
    error = MissingExtra("recordings", "record", ModuleNotFoundError("no", name="mcap"))
    assert str(error) == (
        "recordings need the package mcap, of the extra record; in the folder of the checkout run: "
        "`.venv/bin/pip install '.[record]'`"
    )
    assert error.name == "mcap" and isinstance(error, ModuleNotFoundError)


def test_the_command_installs_all_extras() -> None:
    """pip resolves the checkout with its extras from what is installed, and installs nothing."""
    needed = {"pip", "setuptools", "mcap", "stonesoup", "xarray", "zarr", "matplotlib", "zeroconf"}
    absent = sorted(
        needed - {one.name.lower() for one in distributions()}
    )  # to look for a module changes how setuptools imports
    if absent:
        pytest.skip(f"{', '.join(absent)}: absent, and pip cannot resolve the extras without a network")
    program, *arguments = shlex.split(install_command(",".join(sorted(set(EXTRAS) - {"dev"}))))
    assert program == ".venv/bin/pip"
    offline = ["--dry-run", "--no-index", "--no-build-isolation", "--disable-pip-version-check"]
    done = subprocess.run([sys.executable, "-m", "pip", *arguments, *offline], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and "Would install radar-service" in done.stdout, done.stderr
    assert "does not provide the extra" not in done.stderr


def test_without_their_packages_commands_name_the_extra_and_a_bench_has_its_report(tmp_path: Path) -> None:
    """A command that needs one says so before it computes; a recording that is missing is named before the extra."""
    commands = [
        ["chart", "harbour", "-o", "x"], ["stability", "-o", "x"], ["plots", "harbour", "--png", "x.png"],
        ["record", "one", "-o", "x.mcap"], ["replay", __file__], ["serve", "--record", "x.mcap"], ["replay", "nofile.mcap"],
    ]  # fmt: skip
    code = (
        "import sys; sys.modules.update(dict.fromkeys(('matplotlib', 'mcap', 'mcap.data_stream')))\n"
        "import radar_service as rs; from radar_service.__main__ import main; from tests.bench.test_report import RUN, data\n"
        "from radar_service.bench.report import page\n"
        f"print(*map(main, {commands}), 'pictures: <code>.venv' in page(data(), {{'small': RUN}}))\n"
        "import radar_service.commands.stability, radar_service.commands.chart, radar_service.commands.plots\n"
        "rs.Simulator(rs.load_scene('worked-example'), 'fast').scan().plot()"
    )
    search = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=search, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["2"] * 7 + ["True"], done.stderr
    lines = done.stderr.splitlines()
    needs = "need the package matplotlib, of the extra pictures; in the folder of the checkout run:"
    assert [line.split(needs)[0] for line in (*lines[:3], lines[-1])] == [
        "studies ", "studies ", "pictures of plots ", "radar_service.terminal.extras.MissingExtra: plots of scans ",
    ]  # fmt: skip
    for line in lines[3:6]:
        assert line.startswith("recordings need the package mcap") and line.endswith(f"run: `{install_command('record')}`")
    assert lines[6] == "nofile.mcap: there is no such file; give a recording"
    assert not [*tmp_path.iterdir()]


def test_documents_write_the_command_that_works() -> None:
    """An extra is installed from the checkout or a wheel, and has one of the names in pyproject.toml."""
    texts = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("radar_service/**/*.py")]
    text = "\n".join(path.read_text(encoding="utf-8") for path in texts)
    written = re.findall(r"pip install(?: -\w)* '?\"?([\w.-]*)\[([a-z{}]+)\]", text)
    assert {("." if folder.endswith(".whl") else folder, extra) for folder, extra in written} == {
        (".", extra) for extra in [*EXTRAS, "{extra}"]
    }
