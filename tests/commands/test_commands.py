"""The short modules of commands, each under its name."""

import contextlib
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
from radar_service.commands.shared_options import SimulatorOptions
from radar_service.numerics.arithmetic_name import arithmetic
from radar_service.plan.budget import ErrorBudget
from radar_service.recording import read
from radar_service.study import stability
from radar_service.world import body as world_body
from radar_service.world.shapes import sphere
from tests.plots.test_plot_report import SCENE as PLOTTED
from tests.scenes import ONE_TARGET, TWO_RADARS
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


# shared_options: the options that make simulators can be sent to another process.
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


# check: the command `check`, and which radar it and `plan` speak of.
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


def test_remarks_on_a_large_mesh_are_of_slices(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A closed ball of 5120 triangles, of which 1600 are judged: convex, no part of it open where slices end."""
    ball = sphere(4.0, 0.01)
    lines = ["v {} {} {}".format(*row) for row in ball.vertices.tolist()] + [
        "f {} {} {}".format(*row + 1) for row in ball.faces
    ]
    (tmp_path / "ball.obj").write_text("\n".join(lines))
    table = {"name": "ball", "mesh": "ball.obj", "scattering": "optics", "position_m": [0, 500, 0]}
    (tmp_path / "scene.json").write_text(json.dumps({"body": [table]}))
    monkeypatch.setattr(world_body, "MAX_JUDGED", 1600)
    assert main(["check", str(tmp_path / "scene.json"), "--all"]) == 0
    output = capsys.readouterr().out
    assert f"these are remarks on 1600 of {len(ball.faces)} facets, in slices across the body" in output
    assert "convex: no facet reflects onto another" in output and "open or wound" not in output


def test_an_upright_hull_is_a_warning_on_the_first_screen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """After the warnings of the scene."""
    hull = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 11, "height_m": 10, "position_m": [0, 900, 0]}
    body = {**hull, "scattering": "optics", "mmsi": 299000001, "ais": {"length_m": 20}}
    (tmp_path / "scene.json").write_text(json.dumps({"environment": {"multipath": True}, "body": [body]}))
    assert main(["check", str(tmp_path / "scene.json")]) == 0
    first, second, third = capsys.readouterr().out.splitlines()[1:4]
    assert first.startswith(
        "warning     body[0]: h: 60 m where ais.length_m is 20 m: correct length_m, beam_m, height_m, or"
    )
    assert second.startswith("warning     h: metal, upright, over a reflecting sea: ") and third.startswith("radar ")


# plots: the command `plots` as a user runs it.
@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(PLOTTED))
    return str(path)


def test_plots_are_printed_and_written(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, png = tmp_path / "plots.json", tmp_path / "plots.png"
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "-o", str(out), "--png", str(png)]) == 0
    lines = capsys.readouterr().out.splitlines()
    data = json.loads(out.read_text())
    assert lines[0] == f"five kinds: 1 scans, {len(data['plots'])} plots"
    rows = {line.split("  ")[0]: line.split() for line in lines}
    assert rows["moored"][1:] == ["ship", "300", "m", "1", "1", "1", "1"] and rows["far"][-1] == "-"
    noise = next(kind for kind in data["kinds"] if kind["kind"] == "noise")
    assert rows["noise"][1:3] == [str(noise["cells"]), str(noise["detected"])]
    assert png.read_bytes().startswith(b"\x89PNG")


def test_a_flood_is_told_at_once_on_standard_error(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "--pfa", "0.3"]) == 0
    printed, told = capsys.readouterr()
    assert told.splitlines()[0].startswith("scan 0: ") and "lower pfa (now 0.3)" in told.splitlines()[0]
    assert "remark: 3 of 3 scans flood" in printed


def test_plots_nearer_than_a_distance_are_left_out(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A flood asks for it. The ship, which has a plot above, is moored at 300 m."""
    assert main(["plots", scene, "--scans", "1", "--threshold", "known", "--nearest-m", "350"]) == 0
    (moored,) = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("moored")]
    assert moored[-2] == "0"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--pfa", "0"], "0 is not allowed; a probability between 0 and 1"),
        (["--pfa", "nan"], "nan is not allowed; a probability"),
        (["--nearest-m", "x"], "x is not allowed; a length above 0 m"),
        (["--fidelity", "documented"], "documented has no labels"),
        (["-o", "/dev/null/plots.json"], "a file is in the way of this folder"),
        (["--png", "plots.jpg"], "does not end in .png"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: list[str], words: str, scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["plots", scene, "--scans", "1", *arguments])
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert re.search(words, capsys.readouterr().err)


# record: the command `record`.
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


def test_labels_and_powers_are_recorded(one_target: Path, tmp_path: Path) -> None:
    options = ["--fidelity", "fast", "--labels", "--powers", "256", "-o", str(tmp_path / "a.mcap")]
    assert main(["record", str(one_target), *options]) == 0
    assert not list(read(tmp_path / "a.mcap").crossings())  # without --truth
    made = rs.Simulator(rs.load_scene(one_target), "fast", labels=True, powers=(256,))
    (ours,), its = read(tmp_path / "a.mcap").scans(), made.scan()
    assert ours.labels is not None and its.labels is not None and ours.labels.tobytes() == its.labels.tobytes()
    assert ours.powers is not None and its.powers is not None and ours.powers[256].tobytes() == its.powers[256].tobytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--powers", "7"], "--powers: 7 is no source of this scene; it has 0 noise"),
        (["--powers", "ship"], 'powers: "ship" is not all, nor 1 to 64 numbers'),
        (["--labels", "--fidelity", "documented"], "--labels: the fidelity documented has none"),
        (["--powers", "all", "--fidelity", "documented"], "--powers: the fidelity documented has none"),
    ],
)
@pytest.mark.parametrize(("command", "name"), [("record", "a.mcap"), ("scan", "a.npz")])
def test_sources_that_are_not_there_are_refused_and_no_file_made(
    command: str, name: str, arguments: list[str], words: str, one_target: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    with contextlib.suppress(SystemExit):  # of the parser
        assert main([command, str(one_target), *arguments, "-o", str(tmp_path / name)]) == 2
    assert words in capsys.readouterr().err and not (tmp_path / name).exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_a_clear_error(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    assert main(["record", str(one_target), "-o", str(path), "--overwrite"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"{path}: No space left on device"
