"""Gated associations: distances are those of Stone Soup, results those of its own associations, and few pairs are tried."""

from datetime import timedelta
from typing import Any

import numpy as np
import pytest
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.dataassociator.probability import JPDA
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.measures import Mahalanobis
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import ExtendedKalmanPredictor
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.updater.kalman import ExtendedKalmanUpdater

from radar_service.bench.trackers.gating import EPOCH, Tuning
from radar_service.bench.trackers.stone_soup import StoneSoupTracker, detection
from radar_service.bench.trackers.stone_soup_parts import (
    GatedJointProbabilities,
    GatedNearestNeighbours,
    PlaneMotion,
)
from tests.bench.trackers.test_stone_soup import given, plot, plots_of

TUNING = Tuning(gate=3.5, clutter=1e-6)
END = EPOCH + timedelta(seconds=10.0)


def tracks(rng: np.random.Generator, count: int, half: float = 1000.0) -> list[Track]:
    """Tracks in a square, of some seconds ago, whose errors of position and velocity go together."""
    made = []
    for _ in range(count):
        root = rng.normal(0.0, 1.0, (4, 4)) * [[20.0], [3.0], [20.0], [3.0]]
        place = rng.uniform(-half, half, 2) + 2.0 * half
        mean = np.array([place[0], rng.uniform(-10, 10), place[1], rng.uniform(-10, 10)])[:, None]
        time = EPOCH + timedelta(seconds=float(rng.uniform(6.0, 9.0)))
        made.append(Track([GaussianState(mean, root @ root.T, timestamp=time)]))
    return made


def plots(rng: np.random.Generator, count: int, half: float = 1000.0) -> list[Any]:
    """Plots in the same square, some of them before a track's state."""
    return [
        detection(plot(float(rng.uniform(7.5, 10.0)), *(rng.uniform(-half, half, 2) + 2.0 * half)), TUNING)
        for _ in range(count)
    ]


def parts() -> tuple[Any, Any]:
    model = PlaneMotion([ConstantVelocity(TUNING.acceleration)] * 2)
    return ExtendedKalmanPredictor(model), ExtendedKalmanUpdater()


class Counted(DistanceHypothesiser):
    """Counts the pairs that it is given."""

    pairs = 0

    def hypothesise(self, track: Any, detections: Any, timestamp: Any, **options: Any) -> Any:
        Counted.pairs += len(detections)
        return super().hypothesise(track, detections, timestamp, **options)


def test_matrices_of_motion_are_those_of_stone_soup() -> None:
    models, step = [ConstantVelocity(0.3)] * 2, timedelta(seconds=2.5)
    ours, its = PlaneMotion(models), CombinedLinearGaussianTransitionModel(models)
    assert np.array_equal(ours.matrix(time_interval=step), its.matrix(time_interval=step))
    assert np.array_equal(ours.covar(time_interval=step), its.covar(time_interval=step))


@pytest.mark.parametrize("seed", range(3))
def test_gated_nearest_neighbours_are_the_nearest_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, columns = tracks(rng, 8, 200.0), plots(rng, 8, 200.0)
    hypothesiser = DistanceHypothesiser(*parts(), Mahalanobis(), missed_distance=TUNING.gate)
    its = GNNWith2DAssignment(hypothesiser).associate({*rows}, {*columns}, END)
    ours = GatedNearestNeighbours(hypothesiser, tuning=TUNING).associate({*rows}, {*columns}, END)
    assert any(its.values()) and {track: one.measurement for track, one in ours.items() if one} == {
        track: one.measurement for track, one in its.items() if one
    }


@pytest.mark.parametrize("seed", range(3))
def test_joint_probabilities_are_those_of_all_joint_hypotheses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    unit = PDAHypothesiser(*parts(), 1.0, TUNING.detection, prob_gate=0.99, normalise=False)
    gated = GatedJointProbabilities(unit, tuning=TUNING)
    rows, columns = tracks(rng, 4, 60.0), [one for one in plots(rng, 6, 60.0) if (END - one.timestamp).total_seconds() < 0.5]
    hypotheses = gated.generate_hypotheses(rows, columns, END)

    class Same:
        def hypothesise(self, track: Any, *_: Any, **__: Any) -> Any:
            return hypotheses[track]

    its, ours = JPDA(Same()).associate({*rows}, {*columns}, END), gated.associate({*rows}, {*columns}, END)
    for track in rows:
        weights = {one.measurement if one else None: float(one.probability) for one in its[track]}
        assert {one.measurement if one else None: float(one.probability) for one in ours[track]} == pytest.approx(weights)


def test_far_pairs_are_not_tried() -> None:
    """Sixty plots and sixty tracks far from each other: a few pairs of 3600."""
    rng, Counted.pairs = np.random.default_rng(0), 0
    columns = [detection(plot(9.0, 300.0 * k, 5000.0), TUNING) for k in range(60)]
    rows = [Track([GaussianState([[300.0 * k], [0.0], [5000.0], [0.0]], np.eye(4), timestamp=END)]) for k in range(60)]
    its = GatedNearestNeighbours(Counted(*parts(), Mahalanobis(), missed_distance=3.5), tuning=TUNING)
    found = its.associate({*rows}, {*rng.permutation(columns)}, END)
    assert Counted.pairs == 60 and all(found[row].measurement is column for row, column in zip(rows, columns, strict=True))


def test_jpda_ends_where_joint_hypotheses_are_too_many_to_list() -> None:
    """Thirty ships far apart have 2^30 of them."""
    targets = [(300.0 * k - 4500.0, 4000.0, 2.0, 0.0) for k in range(30)]
    tracker = StoneSoupTracker(Tuning("jpda"))
    assert [len(tracker.update(given(scan, plots_of(scan, targets)))) for scan in range(6)][-1] == 30
