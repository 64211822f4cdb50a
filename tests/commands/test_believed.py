"""The command `believed` as a user runs it."""

from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.believed.verdicts import PAGE


def test_one_row_gives_its_source_its_scene_and_its_number(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["believed", "P04", "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "source: JRC JMA-9922 manual" in printed and "ours: offset 42.6 NM (42.14 to 43.86)" in printed
    assert "| P04 |" in (out / PAGE).read_text() and (out / "believed.png").exists()
    assert main(["scan", str(out / "P04" / "scene-1.json"), "-o", str(tmp_path / "scan.npz")]) == 0


def test_a_row_outside_is_a_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["believed", "W02", "-o", str(tmp_path)]) == 1
    assert "why: clutter follows the sea state" in capsys.readouterr().out


def test_an_unknown_row_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["believed", "Q01", "-o", str(tmp_path)]) == 2
    assert "no row Q01; there are C01" in capsys.readouterr().err
