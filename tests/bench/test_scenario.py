"""Scenario files: all that are packaged, seeds, and rubbish."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.bench.scenario import GENERAL, Limit, Scenario, ScenarioError, load_scenario, load_scenarios, scenarios
from radar_service.bench.scores.set_scores import POINT
from radar_service.scattering.reflector_patterns import reflector_area
from radar_service.scene_file.load import load_scene
from radar_service.world.seaway_motion import SeawayMotion

PACKAGED = {name: load_scenario(name) for name in scenarios()}
SMALL: dict[str, Any] = {
    "name": "small", "question": "?", "expected": "!", "source": "this test", "scans": 8, "vary_m": 5.0,
    "scene": {
        "radar": {"azimuths": 256, "beamwidth_deg": 4, "range_max_m": 1500, "pulse_s": 1e-6, "bandwidth_hz": 20e6,
                  "sample_rate_hz": 30e6},
        "environment": {"noise": True},
        "body": [{"name": "t", "shape": "point", "position_m": [800, 300, 10], "rcs_dbsm": -15, "course_deg": 90,
                  "speed_kn": 20}],
    },
}  # fmt: skip


@pytest.mark.parametrize("name", PACKAGED)
def test_every_scenario_loads_and_says_what_it_asks(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name and scenario.question.endswith("?") and scenario.limit
    scene = load_scene(scenario.scene_for(3), folder=scenario.folder)
    assert set(scenario.tracked) <= {body.name for body in scene.bodies} and not scene.warnings


def test_the_library_has_the_standards_and_crossings() -> None:
    names = set(PACKAGED)
    assert {f"a823-{n}" for n in (1, 2, 3, 4)} | {f"crossing-cpa-{cpa}" for cpa in (0, 100, 500)} <= names
    assert {
        "crossing-hulls",
        "crossing-freighters",
        "discrimination-range",
        "discrimination-bearing",
        "minimum-range",
        "land-near",
    } <= names
    assert {f"reflector-sea-state-{state}" for state in (2, 3, 5)} <= names
    assert {
        "late",
        "vanishing",
        "missed-scans",
        "fifty-targets",
        "rolling-ships",
        "rain-with-sea",
        "rain-cell-crossing",
        "rain-front",
        "fast-ferries",
    } <= names
    assert len(load_scenario("fifty-targets").tracked) == 50
    assert {f"msc192-table3-{kind}{n}" for kind in ("", "error-free-", "thd-") for n in (1, 2, 3, 4)} <= names
    table_2 = load_scenario("msc192-table2")
    assert set(table_2.standard_nm) == set(table_2.tracked) and not any(limit.decides for limit in table_2.limit)
    recalled = [
        limit for n in (1, 2, 3, 4) for limit in load_scenario(f"a823-{n}").limit if "this project" not in limit.source
    ]
    assert recalled and not any(limit.decides for limit in recalled)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_targets_of_the_standard_are_where_it_says_after_three_minutes(number: int) -> None:
    """A.823(19) appendix 2: range and bearing at the evaluation, within the metre that files are written to."""
    expected = {1: (8, 0), 2: (1, 0), 3: (8, 45), 4: (8, 45)}[number]
    scene = load_scene(
        {**load_scenario(f"a823-{number}").scene_for(0), "body": load_scenario(f"a823-{number}").scene["body"]}
    )
    offset = scene.bodies[0].motion.pose(180.0).position[0] - scene.own_ship.pose(180.0).position[0]
    assert np.hypot(*offset[:2]) / 1852.0 == pytest.approx(expected[0], abs=0.01)
    assert np.degrees(np.arctan2(offset[0], offset[1])) == pytest.approx(expected[1], abs=0.3)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_table_3_is_judged_under_the_errors_that_it_presupposes(number: int) -> None:
    """Table 3 of MSC.192(79): 95 % figures; the same figures without errors, and shown alone with the least heading device.
    Where the best tracker misses one in more than 2.5 % of runs (tests/reference/test_straight_line_fit.py), it is wider. Two
    limits of this project hold in all other scans."""
    judging, free, rung = (load_scenario(f"msc192-table3-{kind}{number}") for kind in ("", "error-free-", "thd-"))
    assert judging.scene["errors"] == {"profile": "imo-2004"} and judging.draw_biases and judging.plot_errors
    assert "errors" not in free.scene and free.plot_errors is None
    figures = {limit.metric: limit.maximum for limit in free.limit}
    wider = {1: {"true_speed_kn_3min": 0.6}, 4: {"true_speed_kn_3min": 1.0, "cpa_nm_1min": 1.2}}
    ours = {"velocity_kn_median": 3.0, "localisation_m": 40.0 if number == 2 else 100.0}
    assert {limit.metric: limit.maximum for limit in judging.limit} == figures | wider.get(number, {}) | ours
    assert figures["bearing_deg_3min"] == 2.0 and figures["range_m_3min"] == (50.0 if number == 2 else 148.0)
    assert all(limit.decides for limit in judging.limit) and not any(limit.decides for limit in rung.limits)
    assert (
        rung.scene["errors"] == {"profile": "msc116-thd"} and rung.plot_errors == load_scenario(f"a823-{number}").plot_errors
    )


def test_seeds_move_each_target_by_a_draw_of_its_own() -> None:
    scenario = Scenario(**SMALL)
    places = np.array([scenario.scene_for(seed)["body"][0]["position_m"][:2] for seed in range(40)])
    assert (abs(places - [800, 300]) <= 5.0).all() and len(np.unique(places)) == 80
    assert scenario.scene_for(3) == scenario.scene_for(3)
    two = Scenario(
        **{
            **SMALL,
            "scene": {**SMALL["scene"], "body": [{**SMALL["scene"]["body"][0], "name": "a"}, *SMALL["scene"]["body"]]},
        }
    )
    assert two.scene_for(3)["body"][1] == scenario.scene_for(3)["body"][0]


def test_meshes_are_read_from_the_folder_of_the_file(tmp_path: Path) -> None:
    packaged = load_scenario("crossing-freighters")
    assert (
        packaged.folder == scenarios()["crossing-freighters"].parent.parent and (packaged.folder / "freighter.obj").is_file()
    )
    path = tmp_path / "mine.toml"
    path.write_text('question = "?"\nexpected = "!"\nsource = "s"\n[scene]\n')
    assert load_scenario(str(path)).folder == tmp_path
    assert Scenario(**SMALL).digest == Scenario(**{**SMALL, "folder": tmp_path}).digest  # where a file lies changes no run


def test_a_changed_scenario_has_another_digest() -> None:
    assert Scenario(**SMALL).digest == Scenario(**SMALL).digest != Scenario(**{**SMALL, "scans": 9}).digest


@pytest.mark.parametrize(
    ("value", "met"), [(10.0, True), (10.1, False), (None, False), (float("nan"), False), (1.0, True), (0.9, False)]
)
def test_limits(value: float | None, met: bool) -> None:
    assert Limit(metric="m", minimum=1.0, maximum=10.0, source="s").is_met(value) is met


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("question = 3", "question"),
        ("scans = 0", "scans"),
        ("fast = true", "fast"),
        ("scans = ", "correct the file"),
        ("[plots]\npfa = nan", "plots.pfa"),
    ],
)
def test_rubbish_is_refused_with_the_key(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(content)
    with pytest.raises(ScenarioError, match=f"bad.toml: .*{message}"):
        load_scenario(str(path))
    with pytest.raises(ScenarioError, match="absent.toml: No such file"):
        load_scenario(str(tmp_path / "absent.toml"))
    with pytest.raises(
        ScenarioError, match="overtakes: there is no such scenario; there are a823-1, .*; did you mean overtaking\\?"
    ):
        load_scenario("overtakes")


def test_two_scenarios_of_one_name_are_refused(tmp_path: Path) -> None:
    """Their runs would mix: two files of one stem, a file named as a packaged scenario, the same scenario twice."""
    (tmp_path / "other").mkdir()
    content = (scenarios()["overtaking"]).read_text()
    for path in (tmp_path / "mine.toml", tmp_path / "other" / "mine.toml", tmp_path / "overtaking.toml"):
        path.write_text(content)
    one, other, packaged = str(tmp_path / "mine.toml"), str(tmp_path / "other/mine.toml"), str(tmp_path / "overtaking.toml")
    assert [scenario.name for scenario in load_scenarios([one, "overtaking"])] == ["mine", "overtaking"]
    for names in ([one, other], ["overtaking", packaged], [one, "overtaking", one]):
        with pytest.raises(ScenarioError, match=f"{names[-1]}: .* is named .* too; give each scenario once"):
            load_scenarios(names)


def test_seeds_draw_the_signs_of_biases_where_a_scenario_says_so() -> None:
    scenario = Scenario(**{**SMALL, "scene": {**SMALL["scene"], "errors": {"profile": "imo-a823"}}, "draw_biases": True})
    biases = {scenario.scene_for(seed)["errors"]["gyro"]["bias_deg"] for seed in range(10)}
    assert biases == {-0.5, 0.5} and scenario.scene_for(3) == scenario.scene_for(3)
    assert Scenario(**{**scenario.model_dump(), "draw_biases": False}).scene_for(0)["errors"] == {"profile": "imo-a823"}


SCENE = """
[radar]
azimuths = 256
beamwidth_deg = 4
[[body]]
name = "quay"
shape = "box"
length_m = 60
width_m = 10
height_m = 4
position_m = [0, 900, 0]
[[body]]
name = "ship"
shape = "point"
position_m = [500, 500, 5]
rcs_dbsm = 10
speed_kn = 8
"""


def test_a_scene_of_one_s_own_is_a_scenario(tmp_path: Path) -> None:
    """What moves is to be tracked, and what stands there may be."""
    path = tmp_path / "my-harbour.toml"
    path.write_text(SCENE)
    scenario = load_scenario(str(path))
    assert (scenario.name, scenario.tracked, scenario.folder) == ("my-harbour", ("ship",), tmp_path)
    assert {limit.metric for limit in scenario.limits} == {limit.metric for limit in GENERAL} - {"spurious"}
    assert scenario.scene_for(0)["body"] == scenario.scene_for(1)["body"]  # no draw moves her onto the land
    assert (scenario.plots.threshold, scenario.plots.max_plots) == ("ca", 200)  # the quay would flood a known threshold
    path.write_text(SCENE.replace('name = "quay"', 'name = "barge"\nspeed_kn = 1'))
    assert (load_scenario(str(path)).tracked, load_scenario(str(path)).plots.threshold) == (("barge", "ship"), "auto")


def test_a_scene_says_more_in_its_table_for_the_bench(tmp_path: Path) -> None:
    """The scene stays one for every other command."""
    path = tmp_path / "my-harbour.toml"
    table = (
        '[bench]\nscans = 7\ntargets = ["quay", "ship"]\n[[bench.limit]]\nmetric = "held"\nminimum = 1\nsource = "mine"\n'
    )
    path.write_text(SCENE + table + "[bench.plots]\npfa = 1e-9\n")
    scenario = load_scenario(str(path))
    assert (scenario.scans, scenario.tracked, scenario.plots.pfa) == (7, ("quay", "ship"), 1e-9)
    assert "bench" not in scenario.scene and scenario.limits[0].metric == "held" and len(scenario.limits) == 1 + len(GENERAL)
    assert {body.name for body in load_scene(path).bodies} == {"quay", "ship"}
    path.write_text(SCENE + "[bench]\nscanss = 7\n")
    with pytest.raises(ScenarioError, match="my-harbour.toml: scanss: "):
        load_scenario(str(path))


def test_limits_of_every_scenario_stand_beside_its_own() -> None:
    """Its own limit on a metric replaces that of all; a scenario of plots has its own alone."""
    own = Limit(metric="spurious", maximum=0.05, source="s")
    limits = {limit.metric: limit for limit in Scenario(**{**SMALL, "limit": (own,)}).limits}
    assert limits["spurious"] is not GENERAL[1] and limits["spurious"].maximum == 0.05
    assert {limit.metric for limit in GENERAL} == set(limits) and limits["completeness"].minimum == 0.95
    assert Scenario(**{**SMALL, "limit": (own,), "judges": "plots"}).limits == (own,)
    assert "spurious" not in {limit.metric for limit in Scenario(**{**SMALL, "not_judged": ("spurious",)}).limits}


@pytest.mark.parametrize(
    "name", [name for name, scenario in PACKAGED.items() if scenario.judges == "tracks" and "error-free" not in name]
)
def test_every_track_scenario_has_plot_errors_and_something_to_notice(name: str) -> None:
    """A target manoeuvres or vanishes, so that a tracker that stops to look is found; but for the error-free table 3. Extended
    targets have errors of their own."""
    scenario = load_scenario(name)
    bodies = [body for body in scenario.scene["body"] if body["name"] in scenario.tracked]
    assert scenario.plot_errors and scenario.plot_errors.range_sd_m > 0.0
    assert any("manoeuvre" in body or "end_s" in body for body in bodies)


@pytest.mark.parametrize(
    "name", [name for name, scenario in PACKAGED.items() if "sea_state" in scenario.scene["environment"]]
)
def test_the_sea_of_a_scenario_moves_all_that_floats_or_its_source_says_why_not(name: str) -> None:
    """Own ship and each body have the sway of a seaway, but for bodies whose `hull` says that they do not float."""
    scenario = load_scenario(name)
    assert "sea_texture_shape" not in scenario.scene["environment"]  # the product's sea, and its extractor
    assert (scenario.plots.threshold, scenario.plots.pfa, scenario.plots.nearest_m) == ("auto", None, 0.0)
    if not scenario.scene["environment"].get("seaway"):
        assert "without a seaway" in scenario.source
        return
    scene = load_scene(scenario.scene_for(0), folder=scenario.folder)
    fixed = {body["name"] for body in scenario.scene["body"] if not body.get("hull", {}).get("floats", True)}
    sways = {"own ship": scene.own_ship.sway} | {body.name: body.motion.sway for body in scene.bodies}
    assert {name for name, sway in sways.items() if not isinstance(sway, SeawayMotion)} == fixed


@pytest.mark.parametrize(("state", "exceeded_dbsm", "median_dbsm"), [(2, 7.7, 8.75), (3, 6.5, 8.75), (5, 8.8, 13.6)])
def test_the_reflector_of_a_rolling_vessel_has_the_standard_s_cross_section_in_the_median(
    state: int, exceeded_dbsm: float, median_dbsm: float
) -> None:
    """7.5 m2 (table 2 of MSC.192(79)), within 0.5 dB; at sea state 5 23 m2, as the source of the scenario says. At 95 % of the
    time it has a cross-section that falls with the sea: that of 20 seeds, within what one seed differs by."""
    scene = load_scene(load_scenario(f"reflector-sea-state-{state}").scene_for(0))
    vessel, time = scene.bodies[0], np.arange(0.0, 95.0, 0.25)
    pose = vessel.motion.pose(time)
    assert vessel.reflector is not None and pose.rotation is not None
    sight = scene.own_ship.pose(time).position + [0.0, 0.0, scene.radar.height] - pose.position
    toward = np.einsum("kij,ki->kj", pose.rotation, sight)
    toward /= np.linalg.norm(toward, axis=1)[:, None]
    level = np.cross(pose.rotation[:, 2], toward)  # its polarization is horizontal
    level /= np.linalg.norm(level, axis=1)[:, None]
    area = reflector_area(vessel.reflector, toward, level, scene.radar.wavelength)
    cross_section = 10.0 * np.log10(4.0 * np.pi * area**2 / scene.radar.wavelength**2)
    assert np.median(cross_section) == pytest.approx(median_dbsm, abs=0.5)
    assert np.percentile(cross_section, 5) == pytest.approx(exceeded_dbsm, abs=1.0)


@pytest.mark.parametrize("name", scenarios())
def test_no_limit_asks_for_more_than_the_digits_of_ttm(name: str) -> None:
    """A digit of 0.01 NM is 18.5 m: sets of tracks may be 20 m off, and a target 10 m in the mean."""
    least = {"ospa_m": 20.0, "ospa_localisation_m": 20.0, "gospa_m": 20.0, "localisation_m": 10.0, "position_error_m": 10.0}
    limits = [limit for limit in load_scenario(name).limits if limit.maximum is not None]
    assert all(limit.maximum is not None and limit.maximum >= least.get(limit.metric, limit.maximum) for limit in limits)
    assert POINT >= 10.0  # m, of which `localisation_share` is a share
