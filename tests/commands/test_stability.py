"""The command `stability` as a user runs it."""

from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.study import stability


def test_the_command_writes_its_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (study,) = [study for study in stability.STUDIES if study.__name__ == "float32_range"]
    monkeypatch.setattr(stability, "STUDIES", (study,))
    assert main(["stability", "-o", str(tmp_path / "out")]) == 0
    assert "range in single precision" in (tmp_path / "out" / "stability.html").read_text()
