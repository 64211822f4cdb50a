"""The command `check`, and which radar it and `plan` speak of."""

import json
import re
from pathlib import Path

import pytest

from radar_service.__main__ import main
from tests.scenes import TWO_RADARS


def test_check_says_what_a_scene_contains(one_target: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(one_target)]) == 0
    output = capsys.readouterr().out
    assert "one target" in output and "p" in output


@pytest.mark.parametrize(("radar", "bodies"), [(None, {"p"}), ("bow", {"p"}), ("pier", {"tug", "p"})])
def test_check_and_plan_are_those_of_a_radar(
    radar: str | None, bodies: set[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "two.json"
    path.write_text(json.dumps(TWO_RADARS))
    chosen = [] if radar is None else ["--radar", radar]
    assert main(["check", str(path), "--all", *chosen]) == 0
    text = capsys.readouterr().out
    assert "bow on tug\n" in text and f"as {radar or 'bow'} has it" in text
    assert set(re.findall(r"^  (p|tug): ", text, re.M)) == bodies
    assert main(["plan", str(path), "--json", "--realtime-factor", "0.01", *chosen]) == 0
    planned = {choice["what"] for choice in json.loads(capsys.readouterr().out)["choices"]}
    assert planned & {"body p", "body tug"} == {f"body {name}" for name in bodies}
