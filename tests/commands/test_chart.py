"""The command `chart`, from a scene to its files."""

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from radar_service.__main__ import main
from tests.study.chart.settings import PLATE, SMALL


def test_chart_writes_its_measurements(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "s.json"
    path.write_text(json.dumps({"name": "plate", "radar": SMALL, "body": [PLATE]}))
    assert main(["chart", str(path), "-o", str(tmp_path), "--quick"]) == 0
    data: dict[str, Any] = json.loads((tmp_path / "chart.json").read_text())
    assert {p["panel"] for p in data["points"]} == {"field", "power", "scattering"} == set(data["summary"])
    assert data["closed_form_error_db"] < -250 and data["commit"] and data["machine"]["cores"] >= 1
    text = (tmp_path / "summary.txt").read_text()
    assert text == capsys.readouterr().out and all(
        f"- {line}\n" in text for each in data["summary"].values() for line in each
    )
    assert "balanced" in text
    svg = (tmp_path / "chart.svg").read_text()
    assert all(p["setting"].split()[0] in svg and f">{p['family']}<" in svg for p in data["points"])
    with Image.open(tmp_path / "chart.png") as picture:
        assert picture.size[0] == 1660
    assert main(["chart", str(path), "-o", str(path)]) == 2 and "a file is in the way" in capsys.readouterr().err
