"""The bench is tested by trackers: each fault misses the limit that is made for it, and good trackers miss none."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from radar_service.bench.kept_plots import ObservedRun, observed_run
from radar_service.bench.run import answered
from radar_service.bench.scenario import Scenario, load_scenario
from radar_service.bench.scores.scoring import metrics_of
from radar_service.bench.scores.verdicts import is_gross
from radar_service.bench.single_run import data_sheet, header_of
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import Tracker
from radar_service.bench.trackers.trackers import tracker_for
from tests.bench import known_trackers as known
from tests.bench.test_scenario import PACKAGED

FAST_RADAR = {"azimuths": 360, "beamwidth_deg": 3.0, "bandwidth_hz": 5e6, "sample_rate_hz": 7.5e6}
FROM_THE_FUTURE = "from the future"

TABLE: list[tuple[str, str, str]] = [
    ("Frozen", "crossing-cpa-500", "completeness"),
    ("Extrapolates", "crossing-cpa-500", "gone_scans"),
    ("Extrapolates", "target-manoeuvre", "localisation_share"),
    ("Silent", "crossing-cpa-500", "first_state_scans"),
    ("Silent", "crossing-cpa-500", "completeness"),
    ("Still", "crossing-cpa-500", "velocity_kn_1min"),
    ("HalfSpeed", "crossing-cpa-500", "velocity_kn_3min"),
    ("NeverDeletes", "vanishing", "gone_scans"),
    ("Late", "crossing-cpa-500", FROM_THE_FUTURE),
    ("Ghost", "crossing-cpa-500", "spurious"),
    ("Twice", "crossing-cpa-500", "ambiguity"),
    ("NewNames", "crossing-cpa-500", "identity_changes"),
    ("Swaps", "crossing-cpa-500", "identity_changes"),
    ("Unfiltered", "crossing-cpa-500", "velocity_kn_1min"),
    ("Far", "crossing-cpa-500", "localisation_share"),
    ("Turned", "crossing-cpa-500", "localisation_share"),
    ("VeryFar", "msc192-table3-1", "range_m_3min"),
    ("VeryTurned", "msc192-table3-1", "bearing_deg_3min"),
    ("DropsAtOnce", "missed-scans", "bridged"),
    ("DropsAtOnce", "reflector-sea-state-5", "identity_changes"),
    ("VeryTurned", "reflector-sea-state-5", "ospa_m"),
    ("StartOnly", "late", "first_state_scans"),
    ("StartOnly", "vanishing", "completeness"),
    ("SlowOnly", "fast-ferries", "completeness"),
    ("FewTracks", "fifty-targets", "completeness"),
    ("Lags", "target-manoeuvre", "course_after_turn_deg"),
    ("VelocityForExams", "crossing-cpa-500", "velocity_kn_median"),
    ("VelocityForExams", "msc192-table3-1", "velocity_kn_median"),
    ("PositionForExams", "crossing-cpa-500", "localisation_share"),
    ("PositionForExams", "msc192-table3-1", "localisation_m"),
    ("FreezesAndCatchesUp", "crossing-cpa-500", "localisation_share"),
    ("FreezesAndCatchesUp", "msc192-table3-2", "localisation_m"),
    ("UnfilteredBetweenExams", "crossing-cpa-500", "velocity_kn_median"),
    ("UnfilteredBetweenExams", "msc192-table3-2", "velocity_kn_median"),
    ("TakesTurns", "crossing-cpa-500", "completeness"),
    ("TwoNames", "crossing-cpa-500", "identity_changes"),
    ("SwapsLate", "crossing-cpa-500", "identity_changes"),
    ("NearOnly", "msc192-table3-1", "completeness"),
    ("RenamesTheLost", "vanishing", "spurious"),
    ("Ghosts", "land-near", "false_noise_h"),
    ("Ghost", "missed-scans", "false_noise_h"),
    ("NewNames", "crossing-cpa-0", "identity_changes"),
    ("Reverses", "crossing-cpa-500", "velocity_kn_95"),
    ("Reverses", "missed-scans", "velocity_kn_95"),
    ("Delays", "crossing-cpa-500", "delay_s"),
    ("Delays", "missed-scans", "delay_s"),
    ("Lags", "target-manoeuvre", "turn_lag_s"),
]
QUICK = {"crossing-cpa-500", "missed-scans", "target-manoeuvre"}  # the others are studies: their plots take a second each
TURNS = {
    "target-manoeuvre",
    "merging",
}  # of 1 degree a second: one process noise is too small for them, or too large for table 3
SEEDS = 3  # of a study
GOOD: dict[str, Callable[[Scenario, ObservedRun], Tracker]] = {
    "IMM": lambda scenario, run: ReckonedTracker(known.Imm(data_sheet(scenario))),
    "truth": lambda scenario, run: known.Truth(run.results),
    "gnn": lambda scenario, run: tracker_for("gnn", header_of(scenario, 0)),
}
ROWS = [pytest.param(*row, marks=() if row[1] in QUICK else pytest.mark.study) for row in TABLE]


@cache
def observed(name: str, seed: int, folder: Path) -> tuple[Scenario, ObservedRun]:
    """A packaged scenario with a radar of a sixteenth of the cells, and what it sees; with its own one where it sees the sea."""
    scenario = load_scenario(name)
    radar = {} if "sea_state" in scenario.scene["environment"] else FAST_RADAR
    scene = {**scenario.scene, "radar": {**scenario.scene["radar"], **radar}}
    fast = scenario.model_copy(update={"scene": scene})
    return fast, observed_run(folder, fast, seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plots")


def missed(scenario: Scenario, run: ObservedRun, tracker: Tracker) -> dict[str, bool]:
    """The limits that a tracker misses in one run, and whether grossly."""
    try:
        metrics = metrics_of(list(answered(run.results, tracker)), run.around)
    except TrackerError as error:
        return {FROM_THE_FUTURE: True} if "after the end of the scan" in str(error) else {}
    judged = [limit for limit in scenario.limits if limit.decides and (limit.metric in metrics or not limit.where_judged)]
    values = {limit.metric: metrics.get(limit.metric) for limit in judged}
    return {
        limit.metric: is_gross(limit, values[limit.metric]) for limit in judged if not limit.is_met(values[limit.metric])
    }


@pytest.mark.parametrize(("wrong", "name", "metric"), ROWS)
def test_each_fault_misses_the_limit_that_is_made_for_it(wrong: str, name: str, metric: str, folder: Path) -> None:
    scenario, run = observed(name, 0, folder)
    assert metric in missed(scenario, run, known.WRONG[wrong](data_sheet(scenario)))


@pytest.mark.parametrize("good", ["IMM", "truth"])
@pytest.mark.parametrize("name", sorted(QUICK))
def test_good_trackers_miss_nothing_there(good: str, name: str, folder: Path) -> None:
    scenario, run = observed(name, 0, folder)
    assert missed(scenario, run, GOOD[good](scenario, run)) == {}


@pytest.mark.study
@pytest.mark.parametrize(("wrong", "name", "metric"), TABLE)
def test_smoke_finds_each_fault(wrong: str, name: str, metric: str, folder: Path) -> None:
    """Gross in one of three runs, or missed in all of them."""
    runs = [observed(name, seed, folder) for seed in range(SEEDS)]
    found = [missed(scenario, run, known.WRONG[wrong](data_sheet(scenario))) for scenario, run in runs]
    assert any(one.get(metric) for one in found) or all(metric in one for one in found)


@pytest.mark.study
@pytest.mark.parametrize(
    ("good", "name"),
    [
        (good, name)
        for name, scenario in PACKAGED.items()
        for good in GOOD
        if scenario.judges == "tracks" and not (good == "gnn" and name in TURNS)
    ],
)
def test_smoke_lets_good_trackers_pass(good: str, name: str, folder: Path) -> None:
    found = []
    for seed in range(SEEDS):
        scenario = load_scenario(name)
        run = observed_run(folder, scenario, seed)
        found.append(missed(scenario, run, GOOD[good](scenario, run)))
    gross = {metric for one in found for metric, is_so in one.items() if is_so}
    assert not gross and not set.intersection(*map(set, found))
