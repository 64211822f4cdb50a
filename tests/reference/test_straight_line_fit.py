"""What the best possible tracker misses of table 3 of MSC.192(79), and that limits and 1000 runs let it pass, and no bad one."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import norm

from radar_service.bench.scenario import load_scenario
from radar_service.bench.scores.verdicts import MISSES, RUNS
from tests.reference.straight_line_fit import (
    ALLOWED,
    ENCOUNTERS,
    GLINT,
    KNOT,
    RANGE,
    SCAN,
    STEP,
    errors,
    passes,
)
from tests.reference.straight_line_fit import RUNS as REFERENCE_RUNS

DRAWS = 3000
WORST_SHARE = 0.025  # half of what the standard allows: of 1000 runs more than 38 miss it in 0.4 % of benches
STANDARD = {(1, "true_speed_kn_3min"): 0.5, (4, "cpa_nm_1min"): 1.0}  # where limits follow the scenario, as table 3 has them
OURS = {
    "velocity_kn_median",
    "localisation_m",
}  # over all scans of a run: no clause has them, and these draws end with an instant


@cache
def drawn(number: int, draws: int) -> dict[str, np.ndarray]:
    """Errors of the best estimate in a scenario, by the metrics of the bench."""
    rng = np.random.default_rng(number)
    return {
        f"{name}_{minutes}min": values
        for minutes in (1, 3)
        for name, values in errors(ENCOUNTERS[number], minutes, draws, rng).items()
    }


def misses(draws: int) -> dict[tuple[int, str], float]:
    """The share of draws that misses each limit of the judging set."""
    return {
        (number, limit.metric): float((drawn(number, draws)[limit.metric] > limit.maximum).mean())
        for number in ENCOUNTERS
        for limit in load_scenario(f"msc192-table3-{number}").limit
        if limit.maximum is not None and limit.metric not in OURS
    }


def test_the_true_speed_of_scenario_1_is_that_of_a_line_through_equal_errors() -> None:
    """Glint, range and steps lie along its course, and so does the log: the slope of a straight line has a closed form."""
    plots, spread = 73, np.sqrt(GLINT**2 + RANGE**2 + STEP**2 / 12.0)
    slope = spread * np.sqrt(12.0 / (plots * (plots**2 - 1.0))) / SCAN / KNOT
    expected = norm.sf((0.5 - 0.2) / slope) + norm.sf((0.5 + 0.2) / slope)
    share = (drawn(1, DRAWS)["true_speed_kn_3min"] > 0.5).mean()
    assert share == pytest.approx(expected, abs=4.0 * np.sqrt(expected * (1.0 - expected) / DRAWS))
    assert expected == pytest.approx(0.038, abs=0.0005)


def test_the_best_tracker_misses_each_limit_of_the_judging_set_in_few_runs() -> None:
    """With the figures of the table it misses two in 3.9 and 4.2 %."""
    shares, sampling = misses(DRAWS), 4.0 * np.sqrt(WORST_SHARE * (1.0 - WORST_SHARE) / DRAWS)
    assert len(shares) == 44 and max(shares.values()) < WORST_SHARE + sampling < 0.038


@pytest.mark.study
def test_the_best_tracker_passes_the_judging_set_and_not_with_the_figures_of_the_table() -> None:
    """All limits in 99 % of benches, by Boole's inequality; with the figures of the table in 13 %."""
    draws = 40_000
    shares = misses(draws)
    assert max(shares.values()) < WORST_SHARE and sum(1.0 - passes(share) for share in shares.values()) < 0.01
    standard = [float((drawn(number, draws)[metric] > figure).mean()) for (number, metric), figure in STANDARD.items()]
    assert np.prod([passes(share) for share in standard]) < 0.2


def test_a_tracker_that_misses_six_percent_fails() -> None:
    """In 99.8 % of benches; one that misses 7 % in all but one of 10,000."""
    assert (REFERENCE_RUNS, ALLOWED) == (RUNS, MISSES)
    assert passes(0.06) < 0.002 and passes(0.07) < 1e-4 and passes(WORST_SHARE) > 0.99
