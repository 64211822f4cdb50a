"""The reference tracker: Stone Soup's extended Kalman filter with nearest neighbours (GNN) or joint probabilities (JPDA).

It needs the extra `tracking`. Stone Soup is not imported before a tracker is made.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Literal

import numpy as np

from radar_service.bench.trackers.tracker import TrackerInput, TrackState
from radar_service.plots.plot import Plot
from radar_service.terminal.extras import MissingExtra

EPOCH = datetime(2000, 1, 1)
NEAR = 500.0  # m: farther plots say nothing of when the beam met a track
SAME_TURN = 0.5  # s: plots of one target that are farther apart are of two turns of the antenna, of 1.25 s and more


@dataclass(frozen=True)
class Tuning:
    """How the reference tracker is tuned.

    association: "gnn" or "jpda".
    range_error, bearing_error: standard deviation of plots [m], [rad].
    acceleration: spectral density of the white acceleration of targets [m^2/s^3].
    speed_error: standard deviation of a target's speed before anything is known of it [m/s].
    gate: normalised distance within which a plot may belong to a track.
    confirm: plots that confirm a track.
    delete: scans without a plot after which a track ends.
    detection, clutter: probability of detection, and false plots per m^2, for JPDA.
    """

    association: Literal["gnn", "jpda"] = "gnn"
    range_error: float = 5.0
    bearing_error: float = float(np.radians(0.1))
    acceleration: float = 0.01
    speed_error: float = 10.0
    gate: float = 3.5
    confirm: int = 4
    delete: int = 8
    detection: float = 0.9
    clutter: float = 1e-7


class StoneSoupTracker:
    """A tracker.Tracker."""

    def __init__(self, tuning: Tuning | None = None) -> None:
        """Raises MissingExtra where Stone Soup is absent."""
        try:
            import stonesoup  # noqa: F401
        except ModuleNotFoundError as error:
            raise MissingExtra("the reference trackers", "tracking", error) from None
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
        ndim_state=4, mapping=(0, 2), noise_covar=np.diag([tuning.bearing_error**2, tuning.range_error**2]),
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
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.dataassociator.probability import JPDA
    from stonesoup.deleter.time import UpdateTimeStepsDeleter
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.initiator.simple import MultiMeasurementInitiator
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import ExtendedKalmanPredictor
    from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
    from stonesoup.types.array import StateVector
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import ExtendedKalmanUpdater

    model = CombinedLinearGaussianTransitionModel([ConstantVelocity(tuning.acceleration)] * 2)
    predictor, updater = ExtendedKalmanPredictor(model), ExtendedKalmanUpdater()
    nearest = GNNWith2DAssignment(DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=tuning.gate))
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
    return MultiTargetMixtureTracker(initiator, deleter, feed, JPDA(_InPolarClutter(unit, tuning.clutter)), updater)


def _date_by_its_plot(track: Any) -> None:
    """Gives the newest state of a track the time of its plot: JPDA's updates carry that of the scan instead."""
    plots = [
        hypothesis for hypothesis in getattr(getattr(track.state, "hypothesis", None), "single_hypotheses", ()) if hypothesis
    ]
    if plots:
        track.state.timestamp = max(plots, key=lambda hypothesis: hypothesis.probability).measurement.timestamp


class _InPolarClutter:
    """A hypothesiser of plots that have many times in a scan, among clutter that is even on the map.

    JPDA averages the states of all hypotheses of a track, so they must be of one time: a plot is missed at the time of the
    nearest one, and plots of another turn of the antenna are none of this track. (A scan may have two plots of a target: one
    whose cluster ends beyond north comes a scan later.) Stone Soup compares the likelihood of a plot, a density in bearing and
    range [1/(rad m)], with that of clutter there: at a range R it is R times the one on the map [1/m^2].
    """

    def __init__(self, unit: Any, clutter: float) -> None:
        """unit: a PDAHypothesiser with a density of 1 that does not normalise; clutter: false plots per m^2."""
        self._unit, self._clutter = unit, clutter

    def hypothesise(self, track: Any, detections: Any, timestamp: datetime, **options: Any) -> Any:
        nearest = min(detections, key=lambda detection: _distance(track, detection), default=None)
        time = timestamp if nearest is None or _distance(track, nearest) > NEAR else nearest.timestamp
        of_turn = {each for each in detections if abs((each.timestamp - time).total_seconds()) < SAME_TURN}
        hypotheses = self._unit.hypothesise(track, of_turn, time, **options)
        for hypothesis in hypotheses:
            if hypothesis:
                hypothesis.probability /= self._clutter * float(hypothesis.measurement.state_vector[1, 0])
        hypotheses.normalise_probabilities()
        return hypotheses


def _distance(track: Any, detection: Any) -> float:
    """Distance [m] from a detection to a track, which moves on to its time."""
    east, velocity_east, north, velocity_north = np.ravel(track.state.mean)
    later = (detection.timestamp - track.state.timestamp).total_seconds()
    angle, distance = (float(value) for value in np.ravel(detection.state_vector))
    at = np.ravel(detection.measurement_model.translation_offset) + distance * np.array([np.cos(angle), np.sin(angle)])
    return float(np.hypot(east + later * velocity_east - at[0], north + later * velocity_north - at[1]))
