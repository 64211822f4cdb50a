"""The reference tracker: Stone Soup's extended Kalman filter with nearest neighbours (GNN) or joint probabilities (JPDA).

It needs the extra `tracking`. Stone Soup is not imported before a tracker is made.
"""

from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta
from typing import Any, Literal

import numpy as np

from radar_service.bench.trackers.ais_association import AssociatingTracker
from radar_service.bench.trackers.gating import EPOCH, Tuning
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import DataSheet, Tracker, TrackerInput, TrackState
from radar_service.plots.plot import Plot
from radar_service.terminal.extras import extra

LEAST_CLUTTER = 1e-8  # false plots per m^2 where hardly any are told


def gnn(sheet: DataSheet) -> Tracker:
    """Returns the reference tracker with nearest neighbours, tuned by a data sheet; it associates AIS targets."""
    return AssociatingTracker(ReckonedTracker(StoneSoupTracker(tuning_of(sheet, "gnn"))))


def jpda(sheet: DataSheet) -> Tracker:
    """Returns the reference tracker with joint probabilities, tuned by a data sheet."""
    return ReckonedTracker(StoneSoupTracker(tuning_of(sheet, "jpda")))


def tuning_of(sheet: DataSheet, association: Literal["gnn", "jpda"]) -> Tuning:
    """Returns how the reference tracker is tuned: the same but for what the data sheet tells."""
    return Tuning(
        association=association, range_error=sheet.range_error, bearing_error=sheet.bearing_error, glint=sheet.glint,
        clutter=max(sheet.clutter, LEAST_CLUTTER),
    )  # fmt: skip


class StoneSoupTracker:
    """A tracker.Tracker."""

    def __init__(self, tuning: Tuning | None = None) -> None:
        """Raises MissingExtra where Stone Soup is absent."""
        with extra("tracking", "the reference trackers"):
            import stonesoup  # noqa: F401
        self._tuning = tuning or Tuning()
        self._feed = _Feed()
        self._tracker = reference_tracks(self._tuning, self._feed)
        self._names: dict[str, str] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update; each at the time of its last plot, or at the end of the scan."""
        self._feed.put(EPOCH + timedelta(seconds=scan.time), {detection(plot, self._tuning) for plot in scan.plots})
        _, tracks = next(self._tracker)
        first = sorted(tracks, key=lambda track: (track[0].timestamp, *np.ravel(track[0].mean).tolist()))
        return sorted((self._state(track) for track in first), key=lambda state: int(state.track))

    def _state(self, track: Any) -> TrackState:
        east, velocity_east, north, velocity_north = (float(value) for value in np.ravel(track.state.mean))
        name = self._names.setdefault(track.id, str(len(self._names) + 1))
        time = (track.state.timestamp - EPOCH) / timedelta(seconds=1)
        return TrackState(
            track=name, time=time, east=east, north=north, velocity_east=velocity_east, velocity_north=velocity_north
        )


class _Feed:
    """The detection reader of a tracker that asks for one scan at a time."""

    def __init__(self) -> None:
        self._next: tuple[datetime, set[Any]] | None = None

    def put(self, time: datetime, detections: set[Any]) -> None:
        self._next = time, detections

    def __iter__(self) -> Iterator[tuple[datetime, set[Any]]]:
        while self._next:
            given, self._next = self._next, None
            yield given


def detection(plot: Plot, tuning: Tuning) -> Any:
    """Returns a plot as Stone Soup's Detection: its bearing is that of mathematics, from east to north."""
    from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
    from stonesoup.types.angle import Bearing
    from stonesoup.types.array import StateVector
    from stonesoup.types.detection import Detection

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
    """Yields the time and Stone Soup's tracks after each scan of a DetectionReader, as that of stone_soup_readers. Each state
    has the time of its plot, or of the scan where it has none. Raises ImportError."""
    for time, tracks in _multi_target_tracker(tuning, reader):
        for track in tracks:
            _date_by_its_plot(track)
        yield time, tracks


def _multi_target_tracker(tuning: Tuning, feed: Any) -> Any:
    from stonesoup.deleter.time import UpdateTimeStepsDeleter
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.initiator.simple import MultiMeasurementInitiator
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.transition.linear import ConstantVelocity
    from stonesoup.predictor.kalman import ExtendedKalmanPredictor
    from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
    from stonesoup.types.array import StateVector
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import ExtendedKalmanUpdater

    from radar_service.bench.trackers.stone_soup_parts import GatedJointProbabilities, GatedNearestNeighbours, PlaneMotion

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
