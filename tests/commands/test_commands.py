"""The short modules of commands, each under its name."""

import argparse
import json
import pickle
import re
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from PIL import Image

import radar_service as rs
from radar_service.__main__ import main
from radar_service.believed.verdicts import PAGE
from radar_service.commands.shared_options import SimulatorOptions, service_groups
from radar_service.numerics.arithmetic import arithmetic
from radar_service.plan.budget import ErrorBudget
from radar_service.study import stability
from tests.scenes import ONE_TARGET
from tests.study.chart.settings import PLATE, SMALL


# believed: the command `believed` as a user runs it.
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


# chart: the command `chart`, from a scene to its files.
def test_chart_writes_its_measurements(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "s.json"
    path.write_text(json.dumps({"name": "plate", "radar": SMALL, "body": [PLATE]}))
    assert main(["chart", str(path), "-o", str(tmp_path), "--quick"]) == 0
    data: dict[str, Any] = json.loads((tmp_path / "chart.json").read_text())
    assert {p["panel"] for p in data["points"]} == {"field", "power", "scattering"} == set(data["summary"])
    assert data["version"] and data["machine"]["cores"] >= 1
    text = (tmp_path / "summary.txt").read_text()
    assert text == capsys.readouterr().out and all(
        f"- {line}\n" in text for each in data["summary"].values() for line in each
    )
    assert "balanced" in text
    svg = (tmp_path / "chart.svg").read_text()
    assert all(f">{p['family']}<" in svg for p in data["points"])
    assert all(f">{p['setting']} = {p['preset']}<" in svg for p in data["points"] if p["preset"])
    with Image.open(tmp_path / "chart.png") as picture:
        assert picture.size[0] == 1660
    assert main(["chart", str(path), "-o", str(path)]) == 2 and "a file is in the way" in capsys.readouterr().err


# plan: the command `plan`.
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


# schema: the command `schema`.
def test_schema_accepts_a_good_scene_and_refuses_a_bad_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    validator = Draft202012Validator(json.loads(capsys.readouterr().out))
    assert validator.is_valid(ONE_TARGET) and not validator.is_valid(ONE_TARGET | {"colour": "red"})


def test_the_schema_of_a_sweep_is_another(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "sweep"]) == 0
    validator = Draft202012Validator(json.loads(capsys.readouterr().out))
    assert validator.is_valid({"scene": "harbour", "seeds": 3}) and not validator.is_valid(ONE_TARGET)


# shared_options: arguments that several commands share.
def test_groups_are_made_in_the_order_of_the_help() -> None:
    titles = [group.title for group in service_groups(argparse.ArgumentParser()).values()]
    assert titles == ["what", "where", "how exact", "how fast", "who may", "records"]


# simulator_options: the options that make simulators can be sent to another process.
SCENE = {"radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600}}


def test_options_reach_the_simulator() -> None:
    options = SimulatorOptions(fidelity="fast", seed=3)
    simulator = pickle.loads(pickle.dumps(options))(rs.load_scene(SCENE))
    assert (simulator.fidelity.name, simulator.seed) == ("fast", 3) and "plan" not in vars(
        simulator
    )  # it costs as much as the rest


def test_labels_are_asked_for_by_an_option() -> None:
    made = rs.load_scene(SCENE)
    assert SimulatorOptions(labels=True)(made).scan().labels is not None
    assert SimulatorOptions()(made).scan().labels is None


def test_an_error_budget_comes_before_a_preset() -> None:
    fine, coarse = (SimulatorOptions(error_db=ErrorBudget(db))(rs.load_scene(SCENE)).fidelity for db in (0.05, 3.0))
    assert fine != coarse


# stability: the command `stability` as a user runs it.
def test_the_command_writes_its_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (study,) = [study for study in stability.STUDIES if study.__name__ == "float32_range"]
    monkeypatch.setattr(stability, "STUDIES", (study,))
    assert main(["stability", "-o", str(tmp_path / "out")]) == 0
    assert "range in single precision" in (tmp_path / "out" / "stability.html").read_text()
