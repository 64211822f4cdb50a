"""What is made of Stone Soup: its trackers with gates of their own, and readers of plots and truth of a radar.

Each track is paired with the plots in its gate alone: a pair takes half a millisecond. Scans of the readers may come from a
Simulator, a file, or a radar_feed.RadarFeed of a service. This module needs the extra `tracking`.
"""

from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stonesoup.base import Property
from stonesoup.buffered_generator import BufferedGenerator
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.dataassociator.probability import JPDAwithEHM2
from stonesoup.deleter.time import UpdateTimeStepsDeleter
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.initiator.simple import MultiMeasurementInitiator
from stonesoup.measures import Mahalanobis
from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import ExtendedKalmanPredictor
from stonesoup.reader.base import DetectionReader, GroundTruthReader
from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
from stonesoup.types.angle import Bearing
from stonesoup.types.array import CovarianceMatrix, StateVector
from stonesoup.types.detection import Detection
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
from stonesoup.types.state import GaussianState
from stonesoup.updater.kalman import ExtendedKalmanUpdater
from typing_extensions import override

from radar_service.bench.trackers.gating import EPOCH, Tuning, pair_distances
from radar_service.numerics import Floats
from radar_service.plots import Plot, PlotExtractor
from radar_service.radar import Radar
from radar_service.records import Snapshot
from radar_service.scans import Scan

SLACK = 1.01  # times the gate: Stone Soup differentiates numerically, which changes a distance by a relative 1e-7
JPDA_GATE = 3.04  # the root of 9.21, which two normal errors exceed in 1 %
NEAR = 500.0  # m: farther plots say nothing of when the beam met a track
SAME_TURN = 0.5  # s: plots of one target that are farther apart are of two turns of the antenna, of 1.25 s and more


class GatedNearestNeighbours(GNNWith2DAssignment):  # type: ignore[misc]  # Stone Soup has no types
    """Nearest neighbours (GNN) among the plots in each track's gate."""

    tuning: Tuning = Property(doc="With the gate.")

    @override
    def generate_hypotheses(self, tracks: Any, detections: Any, timestamp: datetime, **options: Any) -> dict[Any, Any]:
        plots = np.array([*detections], dtype=object)
        _, normalised = pair_distances(tracks, detections, self.tuning)
        near = normalised < SLACK * self.tuning.gate
        return {
            track: self.hypothesiser.hypothesise(track, plots[row].tolist(), timestamp, **options)
            for track, row in zip(tracks, near, strict=True)
        }


class GatedJointProbabilities(JPDAwithEHM2):  # type: ignore[misc]
    """Joint probabilities (JPDA) of plots that have many times in a scan, among clutter that is even on the map.

    JPDA averages the states of all hypotheses of a track, so they must be of one time: a plot is missed at the time of the
    nearest one, and plots of another turn of the antenna are left out. Clutter has a density in bearing and range [1/(rad m)],
    at a range R R times the one on the map [1/m^2]: the hypothesiser is a PDAHypothesiser of density 1 that does not normalise.
    """

    tuning: Tuning = Property(doc="With the density of clutter.")

    @override
    def generate_hypotheses(self, tracks: Any, detections: Any, timestamp: datetime, **options: Any) -> dict[Any, Any]:
        plots = np.array([*detections], dtype=object)
        apart, normalised = pair_distances(tracks, detections, self.tuning)
        result = {}
        for track, far, gated in zip(tracks, apart, normalised < SLACK * JPDA_GATE, strict=True):
            nearest = plots[far.argmin()] if len(plots) and far.min() <= NEAR else None
            time = nearest.timestamp if nearest else timestamp
            of_turn = [each for each in plots[gated] if abs((each.timestamp - time).total_seconds()) < SAME_TURN]
            hypotheses = self.hypothesiser.hypothesise(track, of_turn, time, **options)
            for hypothesis in hypotheses:
                if hypothesis:
                    hypothesis.probability /= self.tuning.clutter * float(hypothesis.measurement.state_vector[1, 0])
            hypotheses.normalise_probabilities()
            result[track] = hypotheses
        return result


class PlaneMotion(CombinedLinearGaussianTransitionModel):  # type: ignore[misc]
    """The same model of motion east and north. The matrices of Stone Soup's take most of the time of a prediction."""

    @override
    def matrix(self, **options: Any) -> NDArray[np.float64]:
        return _twice(self.model_list[0].matrix(**options))

    @override
    def covar(self, **options: Any) -> Any:
        return _twice(self.model_list[0].covar(**options)).view(CovarianceMatrix)


def _twice(block: Floats) -> Floats:
    """A matrix (4, 4) of two blocks (2, 2)."""
    result = np.zeros((4, 4))
    result[:2, :2] = result[2:, 2:] = block
    return result


def detection(plot: Plot, tuning: Tuning) -> Any:
    """Returns a plot as Stone Soup's Detection: its bearing is that of mathematics, from east to north."""
    angle = np.pi / 2.0 - plot.bearing
    own = np.array([[plot.east - plot.range * np.sin(plot.bearing)], [plot.north - plot.range * np.cos(plot.bearing)]])
    model = CartesianToBearingRange(
        ndim_state=4, mapping=(0, 2), noise_covar=np.diag(np.square(tuning.errors_at(plot.range))[::-1]),
        translation_offset=own,
    )  # fmt: skip
    return Detection(
        StateVector([Bearing(angle), plot.range]), timestamp=EPOCH + timedelta(seconds=plot.time), measurement_model=model
    )


def reference_tracks(tuning: Tuning, reader: Any) -> Iterator[tuple[datetime, set[Any]]]:
    """Yields the time and Stone Soup's tracks after each scan of a DetectionReader, as PlotReader. Each state
    has the time of its plot, or of the scan where it has none."""
    for time, tracks in _multi_target_tracker(tuning, reader):
        for track in tracks:
            _date_by_its_plot(track)
        yield time, tracks


def _multi_target_tracker(tuning: Tuning, feed: Any) -> Any:

    model = PlaneMotion([ConstantVelocity(tuning.acceleration)] * 2)
    predictor, updater = ExtendedKalmanPredictor(model), ExtendedKalmanUpdater()
    gated = DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=tuning.gate)
    nearest = GatedNearestNeighbours(gated, tuning=tuning)
    deleter = UpdateTimeStepsDeleter(tuning.delete)
    prior = GaussianState(StateVector([0.0, 0.0, 0.0, 0.0]), np.diag([0.0, tuning.speed_error**2] * 2))
    initiator = MultiMeasurementInitiator(
        prior_state=prior,
        deleter=UpdateTimeStepsDeleter(2),
        data_associator=nearest,
        updater=updater,
        min_points=tuning.confirm,
    )
    if tuning.association == "gnn":
        return MultiTargetTracker(initiator, deleter, feed, nearest, updater)
    unit = PDAHypothesiser(predictor, updater, 1.0, tuning.detection, prob_gate=0.99, normalise=False)
    return MultiTargetMixtureTracker(initiator, deleter, feed, GatedJointProbabilities(unit, tuning=tuning), updater)


def _date_by_its_plot(track: Any) -> None:
    """Gives the newest state of a track the time of its plot: JPDA's updates carry that of the scan instead."""
    plots = [
        hypothesis for hypothesis in getattr(getattr(track.state, "hypothesis", None), "single_hypotheses", ()) if hypothesis
    ]
    if plots:
        track.state.timestamp = max(plots, key=lambda hypothesis: hypothesis.probability).measurement.timestamp


class PlotReader(DetectionReader):  # type: ignore[misc]
    """Yields the end of each scan and the detections of its plots. Each detection has the time of its plot and its own
    measurement model, with range, the bearing of mathematics, and own ship's position."""

    scans: Iterable[Scan] = Property(doc="Consecutive scans of one radar.")
    radar: Radar = Property(doc="Of the scans.")
    tuning: Tuning = Property(default=Tuning(), doc="Errors of plots.")
    extractor: PlotExtractor | None = Property(default=None, doc="A new one for the radar by default.")

    @BufferedGenerator.generator_method  # type: ignore[untyped-decorator]
    @override
    def detections_gen(self) -> Iterator[tuple[datetime, set[Any]]]:
        extractor = self.extractor or PlotExtractor(self.radar)
        for scan in self.scans:
            plots = extractor.add(scan).plots
            end = EPOCH + timedelta(seconds=(scan.number + 1) * self.radar.rotation_period)
            yield end, {detection(plot, self.tuning) for plot in plots}


class TruthReader(GroundTruthReader):  # type: ignore[misc]
    """Yields the end of each scan and the paths of all bodies up to it, with states (east, velocity, north, velocity)."""

    snapshots: Iterable[Snapshot] = Property(doc="Of consecutive scans, as RadarFeed.snapshots.")

    @BufferedGenerator.generator_method  # type: ignore[untyped-decorator]
    @override
    def groundtruth_paths_gen(self) -> Iterator[tuple[datetime, set[Any]]]:
        paths: dict[str, Any] = {}
        for snapshot in self.snapshots:
            time = EPOCH + timedelta(seconds=snapshot.time)
            for body in snapshot.bodies:
                (east, north), (east_speed, north_speed) = body.position[:2], body.velocity[:2]
                state = GroundTruthState(
                    [east, east_speed, north, north_speed], timestamp=time, metadata={"body": body.body}
                )
                paths.setdefault(body.body, GroundTruthPath(id=body.body)).append(state)
            yield time, {*paths.values()}
