"""Relative motion does not depend on the log, and true motion does; without errors of sensors nothing changes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import TrackerInput, TrackState
from tests.bench.trackers.test_stone_soup import plot

PERIOD, OWN = 2.5, np.array([0.0, 8.0])  # own ship makes 8 m/s to the north
TARGET, VELOCITY = np.array([500.0, 3000.0]), np.array([-4.0, 1.0])


class Difference:
    """A tracker with one track: the last plot, and the difference of the last two."""

    def __init__(self) -> None:
        self.given: list[TrackerInput] = []

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.given.append(scan)
        if len(self.given) < 2 or not scan.plots:
            return []
        (before,), (now,) = self.given[-2].plots, scan.plots
        step = now.time - before.time
        return [
            TrackState(
                track="t", time=now.time, east=now.east, north=now.north, velocity_east=(now.east - before.east) / step,
                velocity_north=(now.north - before.north) / step,
            )
        ]  # fmt: skip


def scan(number: int, log: float = 0.0, own_error: tuple[float, float] = (0.0, 0.0)) -> TrackerInput:
    """A scan whose plot is taken in its middle. log: what the log reports too much [m/s]; own_error: of the position [m]."""
    end = (number + 1) * PERIOD
    middle = end - PERIOD / 2.0
    own, east_north = OWN * middle, TARGET + VELOCITY * middle
    seen = plot(middle, *(east_north - own).tolist())
    east, north = (OWN * end + own_error).tolist()
    on_map = replace(seen, east=float(east_north[0] + own_error[0]), north=float(east_north[1] + own_error[1]))
    return TrackerInput(
        scan=number, time=end, east=east, north=north, heading=0.0, course=0.0, speed=float(OWN[1]) + log, plots=(on_map,)
    )


def last(scans: Sequence[TrackerInput]) -> TrackState:
    tracker = ReckonedTracker(Difference())
    return [tracker.update(one) for one in scans][-1][0]


def test_without_errors_tracks_are_those_of_the_map() -> None:
    state, middle = last([scan(k) for k in range(6)]), 5.5 * PERIOD
    assert (state.east, state.north) == pytest.approx(tuple(TARGET + VELOCITY * middle))
    assert (state.velocity_east, state.velocity_north) == pytest.approx(tuple(VELOCITY))


def test_the_error_of_the_log_is_in_true_motion_and_not_in_relative_motion() -> None:
    """0.5 m/s too much: own ship and target are both said to be faster to the north."""
    state = last([scan(k, log=0.5) for k in range(6)])
    assert (state.velocity_east, state.velocity_north) == pytest.approx((-4.0, 1.5))
    own = TARGET + VELOCITY * 5.5 * PERIOD
    assert np.hypot(state.east - own[0], state.north - own[1]) == pytest.approx(0.5 * PERIOD / 2.0)  # half a scan of it


def test_jumps_of_the_position_move_tracks_and_give_them_no_motion() -> None:
    """13 m from scan to scan would be 5 m/s on the map."""
    state = last([scan(k, own_error=(13.0 * (-1) ** k, 0.0)) for k in range(6)])
    assert state.velocity_east == pytest.approx(-4.0) and state.east == pytest.approx(500.0 - 4.0 * 5.5 * PERIOD - 13.0)


def test_plots_of_a_lost_heading_are_left_out() -> None:
    inner = Difference()
    tracker = ReckonedTracker(inner)
    assert tracker.update(replace(scan(0), course=float("nan"))) == [] and inner.given[0].plots == ()
