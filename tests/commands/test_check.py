"""The command `check`, and which radar it and `plan` speak of."""

import json
import re
from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.world import large_mesh
from radar_service.world.shapes import sphere
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
    monkeypatch.setattr(large_mesh, "MAX_JUDGED", 1600)
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
