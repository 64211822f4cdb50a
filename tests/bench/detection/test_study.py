"""Detection by range on simulated scans: it is what the radar equation says, and a wrong law is seen."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest

from radar_service.batch.worker_processes import processes
from radar_service.bench.detection import study as module
from radar_service.bench.detection.study import BodyCounts, count, detection_study, study_scene, targets_of
from radar_service.bench.detection.verdicts import Measured, judged
from radar_service.bench.scenario import Scenario, ScenarioError, load_scenario

BODIES = [
    {"name": "buoy", "shape": "point", "position_m": [0, 3000, 3.5], "rcs_dbsm": 0.0},
    {"name": "boat", "shape": "point", "position_m": [0, 3000, 2.0], "rcs_dbsm": 3.0, "swerling": 1},
]
SMALL: dict[str, Any] = {
    "name": "detection", "question": "?", "expected": "!", "source": "this <test>", "standard_nm": {"buoy": 1.5},
    "scene": {
        "radar": {"azimuths": 180, "beamwidth_deg": 5, "range_max_m": 7000, "modulation": "none", "pulse_s": 2.5e-7,
                  "power_w": 100, "pattern": "taylor"},
        "environment": {"noise": True},
        "body": BODIES,
    },
}  # fmt: skip


def scenario(**scene: Any) -> Scenario:
    return Scenario(**{**SMALL, "scene": {**SMALL["scene"], **scene}})


def test_gate_detection_is_what_the_radar_equation_says() -> None:
    """In free space and over the sea; 5 of 8 ranges or more have a Pd that is tested. Of eight tests at 0.001 one fails for one
    seed of 125: seed 0 does with 60 scans (p = 0.0005), and passes with 600 (p = 1)."""
    study = detection_study(scenario(environment={"noise": True, "multipath": True}), 50, 8, seed=1)
    assert [series["environment"] for series in study["series"]] == ["free space", "over the sea"]
    for series in study["series"]:
        assert [one["target"] for one in series["targets"]] == ["buoy", "boat"]
        for one in series["targets"]:
            assert (
                one["word"] != "fail"
                and one["p"] > 0.001
                and abs(one["snr_difference_db"]) < 0.5 + 3.0 * one["snr_error_db"]
            )
            assert sum(row["tested"] for row in one["ranges"]) >= 5
    assert study["eight_of_ten"] == pytest.approx(0.68, abs=0.01) and study["series"][0]["targets"][0]["standard_nm"] == 1.5


def test_a_wrong_law_of_fluctuation_is_seen() -> None:
    """The boat fluctuates, and is judged as a steady target."""
    made = scenario(body=BODIES[1:])
    counts, (scene, layout) = count(made, False, 8, 0, 60), study_scene(made, False, 8)
    its = Measured(
        (layout.cell + 0.5) * scene.radar.range_step, layout.predicted, counts.scans, counts.hits, counts.snr, counts.square
    )
    (boat,) = targets_of(made)
    right, wrong = (judged(scene.radar, scene.environment, replace(boat, swerling=case), its) for case in (1, 0))
    assert right["word"] != "fail" and wrong["word"] == "fail"


def test_bodies_stand_on_spokes_and_in_the_middle_of_cells() -> None:
    scene, layout = study_scene(scenario(), False, 6)
    assert len(scene.bodies) == len(layout.cell) == 12 and layout.target.tolist() == [0] * 6 + [1] * 6
    for body, cell, spoke in zip(scene.bodies, layout.cell, layout.spoke, strict=True):
        east, north, up = body.motion.pose(0.0).position[0]
        ground = np.hypot(east, north)
        z = up - scene.radar.height - ground**2 / (2.0 * 4.0 / 3.0 * 6_371_000.0)
        assert np.hypot(ground, z) / scene.radar.range_step == pytest.approx(cell + 0.5, abs=1e-6)
        assert np.arctan2(east, north) % (2 * np.pi) == pytest.approx(spoke * scene.radar.azimuth_step, abs=1e-9)


def test_parts_add_up_in_any_number_of_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SCANS_PER_JOB", 3)
    seen: list[int] = []

    def progress(parts: Any, whole: int) -> Any:
        seen.append(whole)
        return parts

    one = detection_study(scenario(body=BODIES[:1]), 6, 4, None, progress)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:  # one shows it, at half the cost of two
        assert seen == [2] and detection_study(scenario(body=BODIES[:1]), 6, 4, executor) == one
    half = BodyCounts(1, np.array([1]), np.array([2.0]), np.array([4.0]))
    assert half.plus(half) == BodyCounts(2, np.array([2]), np.array([4.0]), np.array([8.0]))


def test_a_target_that_is_never_in_doubt_is_reported_so() -> None:
    study = detection_study(scenario(body=[{**BODIES[0], "name": "ship", "rcs_dbsm": 60.0}, BODIES[0]]), 2, 2)
    ship = study["series"][0]["targets"][0]
    assert ship["word"] == "no range to test" and ship["p"] is None and ship["ranges"] == []
    assert ship["first_lost_m"] == {"predicted": None, "measured": None} and ship["last_held_m"]["predicted"] > 6900.0
    with pytest.raises(ScenarioError, match="no range has a Pd between 0.05 and 0.95; change range_max_m or power_w"):
        study_scene(scenario(body=[{**BODIES[0], "rcs_dbsm": 60.0}]), False, 2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"body": [{"name": "hull", "shape": "hull", "position_m": [0, 9, 0]}]},
            'body "hull": detection is judged for points',
        ),
        ({"body": [{"name": "p", "shape": "point", "position_m": [0, 9, 0]}]}, 'body "p": detection is judged for points'),
        ({"environment": {"noise": True, "sea_state": 3}}, "judged in noise alone"),
        ({"environment": {}}, "judged in noise alone"),
    ],
)
def test_what_the_radar_equation_does_not_cover_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=f"detection: .*{message}"):
        targets_of(scenario(**change))


@pytest.mark.study
def test_table_2_of_the_standard() -> None:
    """Each target, in free space and over the sea, over 100 scans."""
    with processes(2) as executor:
        study = detection_study(load_scenario("msc192-table2"), 100, 16, executor)
    words = {(series["environment"], one["target"]): one["word"] for series in study["series"] for one in series["targets"]}
    assert len(words) == 12 and "fail" not in words.values()
