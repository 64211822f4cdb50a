"""Detection in clutter against theory: exponential speckle, the K distribution of shape 1, exact intervals."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import kv

from radar_service.bench.detection.clutter import (
    ClutterCase,
    binomial_interval,
    clutter_scene,
    clutter_study,
    clutter_summary,
    clutter_targets,
)
from radar_service.bench.scenario import Scenario, ScenarioError
from radar_service.numerics.constants import NAUTICAL_MILE
from radar_service.scene_file.load import load_scene

PFA = 0.01
CASE = ClutterCase(3, 0.0, (800.0, 1100.0), PFA)


def scenario(**environment: Any) -> Scenario:
    return Scenario(
        name="clutter", question="?", expected="!", source="this test",
        scene={
            "radar": {"azimuths": 90, "beamwidth_deg": 5, "range_max_m": 3000, "modulation": "none", "pulse_s": 2.5e-7},
            "environment": {"noise": True, **environment},
            "body": [{"name": "boat", "shape": "point", "position_m": [0, 900, 2.0], "rcs_dbsm": 5.0, "swerling": 1}],
        },
    )  # fmt: skip


@cache
def study(shape: float, scans: int) -> dict[str, Any]:
    (series,) = clutter_study(scenario(sea_texture_shape=shape), [CASE], scans)["series"]
    assert [row["direction"] for row in series["rows"]] == ["upwind", "across", "downwind"] * 2
    return dict(series)


def test_a_fluctuating_target_in_speckle_is_detected_as_theory_says() -> None:
    """One spoke is in the beam. Target, clutter and noise are exponential together: Pd is Pfa to the power of mean clutter over
    mean sum. The ratio that gives each Pd is the same at one range up to the wind's factor, which C/N shows."""
    rows = study(1000.0, 40)["rows"]
    for row in rows:
        assert row["threshold_over_mean_db"] == pytest.approx(10.0 * np.log10(-np.log(PFA)), abs=0.5)
        assert row["quantile"]["low"] <= row["quantile"]["value"] <= row["quantile"]["high"]
    near = rows[:3]
    signal = [
        (np.log(PFA) / np.log(row["quantile"]["value"]) - 1.0) * 10.0 ** (row["clutter_to_noise_db"] / 10.0) for row in near
    ]
    assert np.std(np.log(signal)) < 0.5 and near[0]["quantile"]["value"] < near[2]["quantile"]["value"]


def test_the_quantile_of_spiky_clutter_is_that_of_the_k_distribution() -> None:
    """Shape 1, one look: the power exceeds x with probability 2 sqrt(x) K1(2 sqrt(x)) (Ward, Tough and Watts, eq. 4.12)."""
    x = brentq(lambda x: 2.0 * np.sqrt(x) * kv(1, 2.0 * np.sqrt(x)) - PFA, 1.0, 50.0)
    got = [row["threshold_over_mean_db"] for row in study(1.0, 40)["rows"]]
    assert np.mean(got) == pytest.approx(10.0 * np.log10(x), abs=0.4)


def test_false_plots_and_tables() -> None:
    series = study(1.0, 40)
    for row in series["rows"]:
        assert 0.0 <= row["false_plots"]["low"] <= row["false_plots"]["value"] <= row["false_plots"]["high"]
        assert PFA / 10.0 < row["extractor_pfa"] < 10.0 * PFA
    text = clutter_summary({"series": [series]})
    assert "sea state 3, rain 0 mm/h, Pfa 0.01, 1 of 1 scans" in text and text.count("boat") == 6


def test_intervals_are_those_of_clopper_and_pearson() -> None:
    """5 of 10: 0.187 to 0.813 (their chart, 1934); none of 20: the rule of three, about 3.7 / 20."""
    half = binomial_interval(0.5, 10)
    assert (half["low"], half["high"]) == (pytest.approx(0.187, abs=1e-3), pytest.approx(0.813, abs=1e-3))
    assert binomial_interval(0.0, 20)["high"] == pytest.approx(0.168, abs=1e-3)


def test_band_polarization_and_swerling_replace_the_scenario_s() -> None:
    case = ClutterCase(2, 4.0, (800.0,), swerling=3, band="s", polarization="v")
    made = scenario()
    scene = clutter_scene(made, case, clutter_targets(made)[0])
    assert (round(scene.radar.frequency / 1e6), scene.radar.polarization, scene.environment.rain_mm_h) == (3050, "v", 4.0)
    assert len(scene.bodies) == 3 and {body.swerling for body in scene.bodies} == {3}
    assert load_scene(made.scene).radar.frequency != scene.radar.frequency


@pytest.mark.parametrize(("nm", "scale"), [(0.4, 0.75), (1.5, 3.0), (2.0, 3.0)])
def test_a_set_has_the_scale_that_its_range_control_takes(nm: float, scale: float) -> None:
    """The next one beyond 1.5 times the range, and not beyond the scenario's."""
    made = scenario()
    sold = {"set": "furuno-far-2127", "range_max_m": 3.0 * NAUTICAL_MILE}
    made = made.model_copy(update={"scene": {**made.scene, "radar": sold}})
    scene = clutter_scene(made, ClutterCase(2, 0.0, (nm * NAUTICAL_MILE,)), None)
    assert scene.radar.range_max == pytest.approx(scale * NAUTICAL_MILE)


def test_bad_cases_are_refused() -> None:
    for wrong in ({"pfa": 0.0}, {"pfa": 1.0}, {"needed": 3, "of": 2}, {"needed": 0}):
        with pytest.raises(ValueError, match="is not allowed"):
            ClutterCase(3, 0.0, (800.0,), **wrong)
    with pytest.raises(ScenarioError, match="are not all between"):
        clutter_study(scenario(), [ClutterCase(3, 0.0, (2.0, 900.0))], 1)
    made = scenario()
    with pytest.raises(ScenarioError, match="no target is a point"):
        clutter_targets(made.model_copy(update={"scene": {**made.scene, "body": []}, "targets": ()}))
