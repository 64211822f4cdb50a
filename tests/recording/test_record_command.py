"""The command `record`."""

from pathlib import Path

import pytest

import radar_service as rs
from radar_service.__main__ import main
from radar_service.recording import read


def test_a_scene_is_recorded_with_its_truth(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mcap"
    assert (
        main(["record", str(one_target), "--scans", "2", "--seed", "3", "--fidelity", "fast", "--truth", "-o", str(path)])
        == 0
    )
    assert capsys.readouterr().out == f"{path}: 2 x 60 spokes of 301 cells\n"
    made = rs.Simulator(rs.load_scene(one_target), "fast", 3)
    assert [scan.field.tobytes() for scan in read(path).scans()] == [made.scan().field.tobytes() for _ in range(2)]
    assert len(list(read(path).crossings())) == 4  # a crossing and a snapshot a scan
    assert read(path).seed == 3 and read(path).record["document"]["body"][0]["name"] == "p"


def test_a_recording_without_truth_has_none(one_target: Path, tmp_path: Path) -> None:
    assert main(["record", str(one_target), "-o", str(tmp_path / "a.mcap")]) == 0
    assert not list(read(tmp_path / "a.mcap").crossings())


def test_a_folder_that_is_not_there_is_named_first(
    one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["record", str(one_target), "-o", str(tmp_path / "none" / "a.mcap")]) == 2
    assert "there is no such folder; create it first" in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_a_clear_error(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    assert main(["record", str(one_target), "-o", str(path)]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"{path}: No space left on device"
