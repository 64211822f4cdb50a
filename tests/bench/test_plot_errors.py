"""Errors of plots on purpose."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.plot_errors import length_of, lengths_of, roll_error, with_errors
from radar_service.bench.scenario import PROFILES, PlotErrors, Scenario
from tests.bench.scores.test_scoring import truth
from tests.bench.test_scenario import SMALL
from tests.bench.trackers.test_stone_soup import plot


def test_plots_of_points_err_as_the_scenario_says_and_those_of_hulls_do_not() -> None:
    """Standard deviations of 400 plots are within 4 standard errors, 3.5 % each; each seed and scan has its own."""
    errors, exact = PlotErrors(range_sd_m=5.0, bearing_sd_deg=0.2), plot(1.0, 3000.0, 4000.0)
    point = replace(truth("t", 1.0, 3000.0, 4000.0, speed=0.0), position=(3000.0, 4000.0))
    moved = [with_errors([exact], [point], errors, 0.0, 1, scan, {})[0] for scan in range(400)]
    assert np.std([one.range - 5000.0 for one in moved]) == pytest.approx(5.0, rel=4 * 0.0354)
    assert np.std([np.degrees(one.bearing - exact.bearing) for one in moved]) == pytest.approx(0.2, rel=4 * 0.0354)
    assert all(np.hypot(one.east, one.north) == pytest.approx(one.range) for one in moved)
    assert with_errors([exact], [point], errors, 0.0, 2, 0, {}) != with_errors([exact], [point], errors, 0.0, 1, 0, {})
    assert (
        with_errors([exact], [replace(point, length=100.0)], errors, 0.0, 1, 0, {})
        == (exact,)
        == with_errors([exact], [], None, 0.0, 1, 0, {})
    )


def test_a_profile_misses_plots_and_has_others() -> None:
    """400 scans of ten plots at the inland profile: shares within 4 standard errors, others within 500 m of own ship."""
    given = [plot(1.0, 3000.0 + 10.0 * k, 4000.0) for k in range(10)]
    scans = [with_errors(given, [], PROFILES["inland"], 0.0, 1, scan, {}) for scan in range(400)]
    kept = [[one for one in scan if one.range > 2000.0] for scan in scans]
    others = [one for scan in scans for one in scan if one.range <= 500.0]
    assert np.mean([len(scan) for scan in kept]) == pytest.approx(9.0, abs=4 * np.sqrt(0.9 / 400))
    assert len(others) / 400 == pytest.approx(2.5, abs=4 * np.sqrt(2.5 / 400))
    assert all(np.hypot(one.east, one.north) == pytest.approx(one.range) for one in others)


def test_glint_wanders_along_the_ship() -> None:
    """200 m long and heading east, north of own ship: a sixth of her length to either side, and nothing along the range but for
    what the bearing turns: 33 m at 5000 m are 0.1 m."""
    exact = plot(1.0, 0.0, 5000.0)
    target = replace(truth("t", 1.0, 0.0, 5000.0, speed=0.0), heading=np.pi / 2.0)
    moved = [with_errors([exact], [target], PlotErrors(), 0.0, 1, scan, {"t": 200.0})[0] for scan in range(400)]
    assert np.std([one.east for one in moved]) == pytest.approx(200.0 / 6.0, rel=4 * 0.0354)
    assert np.ptp([one.north for one in moved]) < 1.0


def test_a_point_is_as_long_as_the_ship_for_which_it_stands() -> None:
    """By table 2 of MSC.192(79), which names 2.5, 1800 and 50,000 m^2 for 10 m, 500 GT and 5000 GT (some 45 and 105 m)."""
    assert [length_of(section) for section in (2.5, 1800.0, 50_000.0)] == pytest.approx([10.0, 45.0, 105.0], rel=0.15)
    point = {**SMALL["scene"]["body"][0], "rcs_dbsm": 10.0 * np.log10(2.5)}
    bodies = [point, {**point, "name": "declared", "hull": {"length_m": 40.0, "beam_m": 8.0}}]
    scenario = Scenario(**{**SMALL, "scene": {**SMALL["scene"], "body": bodies}, "plot_errors": PlotErrors(), "targets": ()})
    assert lengths_of(scenario) == {point["name"]: pytest.approx(10.0), "declared": 40.0}
    stated = scenario.model_copy(update={"plot_errors": PlotErrors(glint_length_m=200.0)})
    assert (
        set(lengths_of(stated).values()) == {200.0} and lengths_of(scenario.model_copy(update={"plot_errors": None})) == {}
    )


def test_ranges_are_rounded_to_steps() -> None:
    (moved,) = with_errors([plot(1.0, 0.0, 5000.0)], [], PlotErrors(range_step_m=18.52), 0.0, 1, 0, {})
    assert moved.range == pytest.approx(270 * 18.52) == moved.north


@pytest.mark.parametrize("relative", [0.0, 90.0, 180.0, 270.0])
def test_roll_turns_nothing_ahead_and_abeam(relative: float) -> None:
    """Times are so many that each phase comes; rounding of cosines is all that is left."""
    errors = [roll_error(np.radians(relative), np.radians(10.0), 10.0, 0.3, time) for time in np.linspace(0.0, 10.0, 200)]
    assert max(map(abs, errors)) < 1e-15


def test_roll_of_ten_degrees_has_the_figures_of_the_resolution() -> None:
    """A.823(19), appendix 3: at 45 degrees a mean of 0.22 degrees and a sine of 0.22 degrees, twice in each period."""
    time = np.linspace(0.0, 10.0, 1000, endpoint=False)
    errors = np.degrees([-roll_error(np.radians(45.0), np.radians(10.0), 10.0, 0.3, at) for at in time.tolist()])
    spectrum = 2.0 * np.abs(np.fft.rfft(errors)) / len(time)
    assert errors.mean() == pytest.approx(0.22, abs=0.005) and spectrum[2] == pytest.approx(0.22, abs=0.005)
    assert np.delete(spectrum, (0, 2)).max() < 1e-12
