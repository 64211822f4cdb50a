"""Ladder files: all that are packaged, what their keys put where, and rubbish."""

from pathlib import Path

import pytest

from radar_service.bench.ladder.series import Ladder, ladders, load_ladder
from radar_service.bench.scenario import ScenarioError, load_scenario
from radar_service.scene_file.load import load_scene
from tests.bench.test_bench import FILE

LADDER = """
question = "?"
expected = "!"
source = "this test"
base = "small.toml"
difficulty = "noise of plots [m]"
values = [1, 30]
[set]
"scans" = 6
[vary]
"plot_errors.range_sd_m" = [1, 30]
"""


def ladder(folder: Path, text: str = LADDER) -> Ladder:
    """A ladder of two rungs in a folder, with its base."""
    (folder / "small.toml").write_text(FILE.format(scans=12))
    path = folder / "noisy.toml"
    path.write_text(text)
    return load_ladder(str(path))


@pytest.mark.parametrize("name", ladders())
def test_every_ladder_loads_and_its_rungs_are_scenes(name: str) -> None:
    packaged = load_ladder(name)
    assert packaged.question.endswith("?") and len(packaged.rungs) == len(packaged.values) >= 5
    for rung in packaged.rungs:
        assert not load_scene(rung.scene_for(0), folder=rung.folder).warnings
    digests = {rung.model_copy(update={"name": ""}).digest for rung in packaged.rungs}
    assert len(digests) == len(packaged.rungs)


def test_there_is_one_for_each_difficulty() -> None:
    assert set(ladders()) == {"clutter", "detection", "glint", "sensors", "spacing"}


def test_keys_reach_tables_lists_and_what_is_absent(tmp_path: Path) -> None:
    """A body by its name, each body, and a table that the base has not; the base keeps its own."""
    text = (
        LADDER
        + '"scene.body.t.speed_kn" = [5, 6]\n"scene.body.*.rcs_dbsm" = [1, 2]\n"scene.errors.gyro.bias_deg" = [0, 3]\n'
    )
    first, second = ladder(tmp_path, text).rungs
    assert (first.name, second.name, first.scans, second.scans) == ("noisy-1", "noisy-2", 6, 6)
    assert [rung.plot_errors and rung.plot_errors.range_sd_m for rung in (first, second)] == [1.0, 30.0]
    body = second.scene["body"][0]
    assert (body["name"], body["speed_kn"], body["rcs_dbsm"]) == ("t", 6, 2)
    assert second.scene["errors"] == {"gyro": {"bias_deg": 3}} and first.scene["body"][0]["speed_kn"] == 5
    base = load_scenario(str(tmp_path / "small.toml"))
    assert base.scans == 12 and base.scene["body"][0]["speed_kn"] == 20 and "errors" not in base.scene


def test_a_packaged_scenario_is_a_base_and_keeps_its_folder(tmp_path: Path) -> None:
    rung = ladder(tmp_path, LADDER.replace("small.toml", "crossing-hulls")).rungs[0]
    assert rung.folder == load_scenario("crossing-hulls").folder and rung.limit == load_scenario("crossing-hulls").limit


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[1, 30]\n[set]", "[1, 2, 3]\n[set]", r"noisy.toml: .*'plot_errors.range_sd_m' has 2 values for 3 rungs"),
        ("plot_errors.range_sd_m", "plot_errors.noise", "noisy: plot_errors.noise: Extra inputs are not permitted"),
        (
            "plot_errors.range_sd_m",
            "scene.body.ship.rcs_dbsm",
            "'scene.body.ship.rcs_dbsm': there is no 'ship'; there are t",
        ),
        (
            "plot_errors.range_sd_m",
            "scene.body.rcs_dbsm",
            r"of each table of a list; write the name of one, or \*, before it",
        ),
        ("plot_errors.range_sd_m", "scans.x", "'scans' is no table"),
        ("[1, 30]\n[set]", "[1]\n[set]", "noisy.toml: values: "),
        ("small.toml", "no-such", "no-such: there is no such scenario"),
        ("small.toml", "other.toml", "other.toml: No such file"),
        ("question", "query", "noisy.toml: query: Extra inputs"),
        ("base =", "base", "noisy.toml: Expected '='.*; correct the file"),
    ],
)
def test_rubbish_is_told_with_its_key(old: str, new: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=message):
        assert ladder(tmp_path, LADDER.replace(old, new)).rungs is None


def test_a_name_that_is_none_gets_those_that_there_are() -> None:
    with pytest.raises(
        ScenarioError, match="glitter: there is no such ladder; there are clutter, .*; did you mean clutter\\?"
    ):
        load_ladder("glitter")
