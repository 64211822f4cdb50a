"""The packaged ladders rank trackers as theory says: they are studies, as each rung takes a second a seed."""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from radar_service.bench.kept_plots import observed_run
from radar_service.bench.ladder.ranking import leaderboard
from radar_service.bench.ladder.series import Ladder, ladders, load_ladder
from radar_service.bench.run import answered
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.scoring import metrics_of
from radar_service.bench.single_run import data_sheet, header_of
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import Tracker
from radar_service.bench.trackers.trackers import tracker_for
from radar_service.numerics.types import Floats
from tests.bench import known_trackers as known

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")

SEEDS = 8  # of which equal signs have a p of 0.008
MAKERS: dict[str, Callable[[Scenario], Tracker]] = {
    "gnn": lambda rung: tracker_for("gnn", header_of(rung, 0)),
    "jpda": lambda rung: tracker_for("jpda", header_of(rung, 0)),
    "Kalman": lambda rung: ReckonedTracker(known.Kalman(data_sheet(rung))),
    "narrow": lambda rung: ReckonedTracker(known.NarrowGate(data_sheet(rung))),
    "unfiltered": lambda rung: known.Unfiltered(data_sheet(rung)),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plots")


@cache
def losses(name: str, number: int, tracker: str, folder: Path) -> Floats:
    """The metric of a rung (SEEDS,)."""
    ladder = load_ladder(name)
    return np.array([loss(ladder, ladder.rungs[number], seed, tracker, folder) for seed in range(SEEDS)])


def loss(ladder: Ladder, rung: Scenario, seed: int, tracker: str, folder: Path) -> float:
    results = observed_run(folder, rung, seed).results
    value = metrics_of(list(answered(results, MAKERS[tracker](rung))))[ladder.metric]
    return ladder.worst if value is None else min(value, ladder.worst)


def better(name: str, folder: Path, trackers: Sequence[str], rungs: Sequence[int]) -> str | None:
    """Which of two trackers is better on some rungs of a ladder."""
    values = [np.mean([losses(name, number, tracker, folder) for number in rungs], axis=0) for tracker in trackers]
    named = {f"{place} {tracker}": each for place, (tracker, each) in enumerate(zip(trackers, values, strict=True))}
    (pair,) = leaderboard(named, f"0 {trackers[0]}")["pairs"]
    return pair["better"] and pair["better"].split()[1]


@pytest.mark.study
@pytest.mark.parametrize("good", ["gnn", "jpda"])
@pytest.mark.parametrize("name", ladders())
def test_a_tracker_without_a_filter_is_worse_than_good_ones(name: str, good: str, folder: Path) -> None:
    """On the easiest rung of each ladder, where no good tracker loses a target."""
    assert better(name, folder, ("unfiltered", good), [0]) == good


@pytest.mark.study
@pytest.mark.parametrize("name", ladders())
def test_a_tracker_and_itself_cannot_be_told_apart(name: str, folder: Path) -> None:
    assert better(name, folder, ("gnn", "gnn"), [0]) is None


@pytest.mark.study
def test_a_narrow_gate_loses_targets_that_are_rarely_detected(folder: Path) -> None:
    """The prediction grows uncertain with each scan without a plot, and the gate leaves 14 % of plots out."""
    assert better("detection", folder, ("narrow", "Kalman"), [2, 3, 4]) == "Kalman"
