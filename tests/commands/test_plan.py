"""The command `plan`."""

import json
import re
from pathlib import Path

import pytest

import radar_service as rs
from radar_service.__main__ import main
from radar_service.numerics.arithmetic import arithmetic


def without_costs(plan: str) -> str:
    """A plan without what is measured anew each time."""
    priced = re.sub(r"[0-9.e+-]+ us", "", plan).replace(",", "")
    return "\n".join(" ".join(line.split()) for line in priced.splitlines() if not line.startswith("cost"))


def test_plan_prints_the_plan(one_target: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", str(one_target)]) == 0
    printed, planned = capsys.readouterr().out.strip(), str(rs.Simulator(rs.load_scene(one_target)).plan).strip()
    assert without_costs(printed) == without_costs(planned)


def test_plan_answers_in_json_and_keeps_an_error_budget(one_target: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", str(one_target), "--json", "--error-db", "2"]) == 0
    output = json.loads(capsys.readouterr().out)
    assert output["settings"]["error_db"] == 2.0 and output["counts"]["resting_echoes"] == 1
    assert (
        output["choices"][-1]["what"] == "body p" and output["realtime_factor"] > 0 and output["arithmetic"] == arithmetic()
    )


def test_plan_keeps_a_pace_and_says_where_it_cannot(one_target: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", str(one_target), "--realtime-factor", "1e12"]) == 0
    assert "! 1e+12 x real time is not possible on this machine" in capsys.readouterr().out
    assert main(["plan", str(one_target), "--realtime-factor", "1", "--fidelity", "fast"]) == 2
    assert "--realtime-factor" in capsys.readouterr().err
