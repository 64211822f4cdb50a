"""Distances of tracks and plots are those of Stone Soup."""

import numpy as np
import pytest
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.measures import Mahalanobis

from radar_service.bench.trackers.gating import pair_distances
from tests.bench.trackers.test_stone_soup_parts import END, TUNING, parts, plots, tracks


def test_distances_are_those_of_stone_soup() -> None:
    """To what its numerical derivatives leave."""
    rng = np.random.default_rng(0)
    rows, columns = tracks(rng, 5), plots(rng, 6)
    apart, normalised = pair_distances(rows, columns, TUNING)
    every = DistanceHypothesiser(*parts(), Mahalanobis(), missed_distance=np.inf, include_all=True)
    for row, track in enumerate(rows):
        for hypothesis in every.hypothesise(track, columns, END):
            if hypothesis:
                column = columns.index(hypothesis.measurement)
                assert normalised[row, column] == pytest.approx(float(hypothesis.distance), rel=1e-5)
                east, _, north, _ = np.ravel(hypothesis.prediction.mean)
                angle, distance = np.ravel(columns[column].state_vector).astype(float)
                at = distance * np.exp(1j * angle) - complex(east, north)
                assert apart[row, column] == pytest.approx(abs(at), rel=1e-9)


def test_no_track_and_no_plot_have_no_distance() -> None:
    rng = np.random.default_rng(0)
    assert [one.shape for one in pair_distances([], plots(rng, 3), TUNING)] == [(0, 3)] * 2
    assert [one.shape for one in pair_distances(tracks(rng, 2), [], TUNING)] == [(2, 0)] * 2
