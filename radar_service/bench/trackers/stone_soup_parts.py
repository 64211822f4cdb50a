"""Parts of Stone Soup's trackers that pair each track with the plots in its gate alone: a pair takes it half a millisecond."""

from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stonesoup.base import Property
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.dataassociator.probability import JPDAwithEHM2
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel
from stonesoup.types.array import CovarianceMatrix
from typing_extensions import override

from radar_service.bench.trackers.gating import Tuning, pair_distances
from radar_service.numerics.types import Floats

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
    nearest one, and plots of another turn of the antenna are none of this track. (A scan may have two plots of a target: one
    whose cluster ends beyond north comes a scan later.) Stone Soup compares the likelihood of a plot, a density in bearing and
    range [1/(rad m)], with that of clutter there: at a range R it is R times the one on the map [1/m^2]. The hypothesiser is a
    PDAHypothesiser with a density of 1 that does not normalise.
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
