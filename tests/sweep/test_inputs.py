"""What a sweep is made of: scenes and files by content, wherever they came from."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.sweep.inputs import SceneSource, inputs_from_bytes, inputs_of
from radar_service.sweep.spec import SweepError
from tests.sweep.sweeps import CUBE, SCENE, SPEC, inputs, written


def test_scenes_are_beside_the_file_or_packaged(tmp_path: Path) -> None:
    of = inputs(tmp_path / "a", 'scene = ["small.toml", "open-sea"]')
    assert [(scene.name, scene.content["name"]) for scene in of.scenes] == [
        ("small.toml", "small"),
        ("open-sea", "open sea"),
    ]
    assert of.scenes[0].files == {"cube.obj": CUBE.encode()}


def test_the_scene_of_a_run_is_that_of_a_file_with_its_values(tmp_path: Path) -> None:
    of = inputs(tmp_path)
    (tmp_path / "fifteen.toml").write_text(SCENE.replace("rcs_dbsm = 10", "rcs_dbsm = 15"))
    expected = rs.Simulator(rs.load_scene(tmp_path / "fifteen.toml"), seed=of.runs[3].seed)
    sim = rs.Simulator(of.scene(of.runs[3]), seed=of.runs[3].seed)
    np.testing.assert_array_equal(sim.scan().field, expected.scan().field)


def test_nothing_but_bytes_is_needed_elsewhere(tmp_path: Path) -> None:
    """The order of keys, which numbers the runs, is kept too."""
    keys = '"environment.noise" = [true, false]\n"body.cube.material" = ["steel", "wood"]\n'
    of = inputs(tmp_path / "a", SPEC + keys)
    description, files = of.as_bytes()
    again = inputs_from_bytes(description, dict(enumerate(files)))
    shutil.rmtree(tmp_path / "a")
    assert [*again.runs] == [*of.runs] and again.made_of("x") == of.made_of("x")
    assert len(again.scene(again.runs[0]).bodies) == 2


def test_files_that_only_values_name_travel_too(tmp_path: Path) -> None:
    written(tmp_path)
    (tmp_path / "other.obj").write_text(CUBE.replace("9", "19"))
    of = inputs(tmp_path, SPEC + '"body.cube.mesh" = ["cube.obj", "other.obj"]\n')
    assert set(of.scenes[0].files) == {"cube.obj", "other.obj"}
    heights = [float(np.ptp(of.scene(of.runs[k]).bodies[1].mesh.vertices[:, 2])) for k in (0, 2)]  # type: ignore[union-attr]
    assert heights == [9.0, 19.0]


def test_a_file_out_of_the_folder_is_neither_read_nor_written(tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text(CUBE)
    of = inputs(tmp_path / "a", scene=SCENE.replace("cube.obj", "../secret.obj"))
    assert not of.scenes[0].files
    with pytest.raises(SweepError, match="leaves the scene's folder"):
        of.scene(of.runs[0])
    hostile = SceneSource("x", of.scenes[0].content, {"../secret.obj": b"changed"})
    with pytest.raises(SweepError):
        type(of)(of.spec, (hostile,)).scene(of.runs[0])
    assert (tmp_path / "secret.obj").read_text() == CUBE


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (lambda spec: spec.replace("[5, 15]", "[5, 16]"), "spec"),
        (lambda spec: spec + '"name" = ["a"]', "spec"),
        (lambda spec: spec.replace("scans = 3", "scans = 4"), "spec"),
        (lambda spec: spec + " ", None),
    ],
)
def test_all_that_values_depend_on_is_told(change: object, key: str | None, tmp_path: Path) -> None:
    one, other = inputs(tmp_path / "a").made_of("x"), inputs(tmp_path / "b", change(SPEC)).made_of("x")  # type: ignore[operator]
    assert [name for name in one if one[name] != other[name]] == ([key] if key else [])


def test_scenes_files_and_arithmetic_are_told_by_content(tmp_path: Path) -> None:
    one = inputs(tmp_path / "a").made_of("x")
    other = inputs(tmp_path / "b", scene=SCENE.replace("speed_kn = 10", "speed_kn = 11")).made_of("y")
    assert [name for name in one if one[name] != other[name]] == ["arithmetic", "scenes"]
    (tmp_path / "b" / "cube.obj").write_text(CUBE + "\n")
    third = inputs_of(tmp_path / "b" / "sweep.toml").made_of("y")
    assert [name for name in other if other[name] != third[name]] == ["files"]
    assert json.loads(json.dumps(one)) == one and one["program"].startswith("0.")


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ('scene = "nowhere"', "sweep.toml: scene: nowhere: neither a file nor a packaged scene"),
        (
            SPEC + '"body.tug.rcs_dbsm" = [1]',
            r"^vary: 'body.tug.rcs_dbsm' in small.toml: there is no 'tug'; there are buoy, cube",
        ),
        (SPEC + '"radar.rmp" = [1]', r"^small.toml, .*radar.rmp = 1: radar.rmp: this is not a known key"),
        (SPEC + '"radar.rpm" = ["fast"]', r"^small.toml, .*radar.rpm = 'fast': radar.rpm: "),
        (SPEC + '"radar.rpm" = [-3]', r"^small.toml, .*radar.rpm = -3: radar.rpm: "),
        (SPEC.replace("seeds", 'radars = ["pier"]\nseeds'), 'radar: "pier" is not a radar of this scene; it has 0'),
    ],
)
def test_what_no_scene_has_is_named(spec: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=message):
        of = inputs(tmp_path, spec)
        of.radar(of.runs[0])
