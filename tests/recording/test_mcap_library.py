"""Without the package `mcap`: a clear error, and everything else works."""

import subprocess
import sys

HIDE = "import sys; sys.modules['mcap'] = None; sys.modules['mcap.data_stream'] = None\n"


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", HIDE + code], capture_output=True, text=True, timeout=60)


def test_commands_name_the_extra() -> None:
    for command in (["record", "one", "-o", "/tmp/x.mcap"], ["replay", "x.mcap"], ["serve", "--record", "x.mcap"]):
        result = run(f"from radar_service.__main__ import main\nsys.exit(main({command}))")
        assert result.returncode == 2
        assert result.stderr.startswith("recordings need the package mcap")
        assert result.stderr.endswith('install it: pip install "radar-service[record]"\n')


def test_reading_names_the_extra() -> None:
    result = run("import radar_service.recording\nradar_service.recording.read('x.mcap')")
    assert "MissingExtra: recordings need the package mcap" in result.stderr


def test_other_commands_do_without() -> None:
    assert run("from radar_service.__main__ import main\nsys.exit(main(['check', 'worked-example']))").returncode == 0
