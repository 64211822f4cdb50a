"""The command `bench-detection` as a user runs it."""

import json
from pathlib import Path

import pytest

from radar_service.__main__ import main

FILE = """
question = "?"
expected = "!"
source = "this test"
[scene.radar]
azimuths = 120
beamwidth_deg = 6
range_max_m = 5000
modulation = "none"
pulse_s = 2.5e-7
power_w = 50
[scene.environment]
noise = true
[[scene.body]]
name = "buoy"
shape = "point"
position_m = [0, 2000, 3.5]
rcs_dbsm = 0
"""


def test_a_study_writes_its_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "buoy.toml", tmp_path / "out"
    path.write_text(FILE)
    assert main(["bench-detection", str(path), "--scans", "40", "--ranges", "4", "--jobs", "1", "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    (row,) = [line for line in printed.splitlines() if line.startswith("free space")]
    assert row.split()[2:5:2] == ["buoy", "NM"] and row.endswith("pass") and str(out / "detection.html") in printed
    assert json.loads((out / "detection.json").read_text())["scans"] == 40


def test_a_sea_is_measured(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two seas with options of each kind, 8 of 10 scans; a wrong number of looks is refused."""
    path, out = tmp_path / "buoy.toml", tmp_path / "out"
    path.write_text(FILE.replace("azimuths = 120\nbeamwidth_deg = 6", "azimuths = 60\nbeamwidth_deg = 12"))
    sea = ["--sea-state", "1,3", "--rain-mm-h", "2", "--at-nm", "0.5", "--pfa", "0.01", "--swerling", "1", "--band", "s"]
    common = ["bench-detection", str(path), "--scans", "40", "--jobs", "1", "-o", str(out), *sea]
    assert main([*common, "--looks", "8/10"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("rain 2 mm/h, Pfa 0.01, 8 of 10 scans") == 2 and printed.count("downwind") == 2
    kept = json.loads((out / "detection.json").read_text())
    assert [series["sea_state"] for series in kept["series"]] == [1.0, 3.0] and kept["series"][0]["band"] == "s"
    assert "8 of 10 scans" in (out / "detection.html").read_text()
    assert main([*common, "--looks", "9/8"]) == 2 and "9 of 8 is not allowed" in capsys.readouterr().err
    assert main([*common, "--looks", "x"]) == 2
