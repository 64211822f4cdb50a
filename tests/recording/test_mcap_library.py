"""Without the package `mcap`: a clear error, and everything else works."""

import subprocess
import sys
from pathlib import Path

from radar_service.terminal.extras import install_command

HIDE = "import sys; sys.modules['mcap'] = None; sys.modules['mcap.data_stream'] = None\n"


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", HIDE + code], capture_output=True, text=True, timeout=60)


def test_commands_name_the_extra(tmp_path: Path) -> None:
    (path := tmp_path / "x.mcap").touch()
    commands = ["record", "one", "-o", str(path)], ["replay", str(path)], ["serve", "--record", str(path)]
    result = run(f"from radar_service.__main__ import main\nprint(*map(main, {commands}))")
    assert result.stdout.split() == ["2"] * len(commands)
    lines = result.stderr.splitlines()
    assert len(lines) == len(commands) and all(line.startswith("recordings need the package mcap") for line in lines)
    assert all(line.endswith(f"run: `{install_command('record')}`") for line in lines)


def test_a_file_that_is_missing_is_named_before_the_extra() -> None:
    result = run("from radar_service.__main__ import main\nsys.exit(main(['replay', 'nofile.mcap']))")
    assert (result.returncode, result.stderr) == (2, "nofile.mcap: there is no such file; give a recording\n")


def test_reading_names_the_extra() -> None:
    result = run("import radar_service.recording\nradar_service.recording.read('x.mcap')")
    assert "MissingExtra: recordings need the package mcap" in result.stderr


def test_other_commands_do_without() -> None:
    assert run("from radar_service.__main__ import main\nsys.exit(main(['check', 'worked-example']))").returncode == 0
