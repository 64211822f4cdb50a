"""Gated associations: distances are those of Stone Soup, results those of its own associations, and few pairs are tried.

Readers: a service gives the plots, tracks and truth that a simulator in this process gives.
"""

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

import radar_service as rs
from radar_service.bench import PlotReader, TruthReader, Tuning, reference_tracks
from radar_service.bench.trackers.gating import EPOCH
from radar_service.bench.trackers.stone_soup import StoneSoupTracker
from radar_service.bench.trackers.stone_soup_parts import (
    GatedJointProbabilities,
    GatedNearestNeighbours,
    PlaneMotion,
    detection,
)
from radar_service.radar_feed import RadarFeed, RadarFeeds, RemoteFeed, service
from tests.bench.test_scenario import SMALL
from tests.bench.trackers.test_stone_soup import given, plot, plots_of

TUNING = Tuning(gate=3.5, clutter=1e-6)
END = EPOCH + timedelta(seconds=10.0)
SCANS = 8
SCENE: dict[str, Any] = {"name": "small", **SMALL["scene"], "own_ship": {"speed_kn": 10, "course_deg": 30}}
TURNED = 20 * 2.0 * np.pi / 65536  # rad: 20 units of the wire, by which the antenna is misaligned
MISALIGNED = SCENE | {"errors": {"antenna": {"misalignment_deg": float(np.degrees(TURNED))}}}
RADAR = rs.load_scene(SCENE).radar


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


def detections_of(feed: RadarFeed) -> list[tuple[Any, ...]]:
    """Times, states and own ship's positions of the detections that a reader gives, scan by scan."""
    return [
        (time, sorted((d.timestamp, *np.ravel(d.state_vector), *np.ravel(d.measurement_model.translation_offset)) for d in some))
        for time, some in PlotReader(feed.scans(SCANS), RADAR)
    ]  # fmt: skip


def truth_of(feed: RadarFeed) -> list[tuple[Any, ...]]:
    return [
        (time, [(path.id, len(path), *np.ravel(path[-1].state_vector)) for path in paths])
        for time, paths in TruthReader(feed.snapshots)
    ]


@pytest.fixture(scope="module")
def of_process() -> tuple[Any, Any]:
    with RadarFeeds() as feeds:
        feed = feeds(MISALIGNED, seed=3, fidelity="balanced")
        return detections_of(feed), truth_of(feed)


def test_a_service_gives_the_plots_and_the_truth_of_a_simulator(of_process: tuple[Any, Any]) -> None:
    """Azimuths of a misaligned antenna are rounded on the wire, by 1e-16."""
    with service(MISALIGNED, 3, "max", "balanced") as running:
        feed = RemoteFeed(running.address)
        for (time, some), (its_time, others) in zip(detections_of(feed), of_process[0], strict=True):
            assert time == its_time and [one[0] for one in some] == [one[0] for one in others]
            np.testing.assert_allclose(
                *(np.array([one[1:] for one in those], dtype=float) for those in (some, others)), rtol=1e-12
            )
        assert truth_of(feed) == of_process[1]
        feed.close()


def test_detections_are_where_the_truth_is(of_process: tuple[Any, Any]) -> None:
    """In the scans after the first one; within 2 m, on a map on which own ship moves, less what the antenna is turned by."""
    plots, truth = of_process
    assert (
        [time for time, _ in plots]
        == [time for time, _ in truth]
        == [EPOCH + timedelta(seconds=(k + 1) * 2.5) for k in range(SCANS)]
    )
    for (end, detections), (_, [(name, count, east, v_east, north, v_north)]) in zip(plots[1:], truth[1:], strict=True):
        earlier = {d: (end - d[0]) / timedelta(seconds=1) for d in detections}
        offsets = [
            np.hypot(
                own_east + distance * np.cos(angle + TURNED) - east + earlier[d] * v_east,
                own_north + distance * np.sin(angle + TURNED) - north + earlier[d] * v_north,
            )
            for d in detections
            for _, angle, distance, own_east, own_north in [d]
        ]
        assert name == "t" and count == 1 + plots.index((end, detections)) and min(offsets) < 2.0
        assert all(0.0 < later < 2.5 for later in earlier.values())


@pytest.mark.parametrize("association", ["gnn", "jpda"])
def test_the_reference_chains_take_a_reader(association: str) -> None:
    scene = rs.load_scene(SCENE)
    simulator = rs.Simulator(scene, "balanced", 3)
    reader = PlotReader((simulator.scan() for _ in range(SCANS)), scene.radar)
    *_, (time, tracks) = reference_tracks(Tuning("jpda" if association == "jpda" else "gnn"), reader)
    (track,) = tracks
    assert time == EPOCH + timedelta(seconds=2.5 * SCANS) and time - timedelta(seconds=2.5) < track.timestamp < time
    body = simulator.truth((track.timestamp - EPOCH) / timedelta(seconds=1)).bodies[0]
    east, _, north, _ = np.ravel(track.state.mean).tolist()
    assert np.hypot(east - body.position[0], north - body.position[1]) < 3.0
