"""The reference tracker: straight targets from plots of many times in a scan, both associations, across north."""

import sys

import numpy as np
import pytest

from radar_service.bench.trackers.gating import Tuning
from radar_service.bench.trackers.stone_soup import StoneSoupTracker
from radar_service.bench.trackers.tracker import TrackerInput, TrackState
from radar_service.plots.plot import Plot

PERIOD = 2.5


def plot(time: float, east: float, north: float) -> Plot:
    distance, bearing = float(np.hypot(east, north)), float(np.arctan2(east, north) % (2 * np.pi))
    return Plot(
        scan=int(time / PERIOD), time=time, range=distance, bearing=bearing, east=east, north=north, snr_db=30.0, cells=9,
        range_extent=(distance - 5, distance + 5), bearing_extent=(bearing - 0.01, bearing + 0.01),
    )  # fmt: skip


def plots_of(scan: int, targets: list[tuple[float, float, float, float]], skip: set[int] = frozenset()) -> tuple[Plot, ...]:
    """Where the beam meets targets (east, north, velocities) in a scan; each at its own time."""
    made = []
    for k, (east, north, v_east, v_north) in enumerate(targets):
        time = scan * PERIOD
        for _ in range(5):  # the beam turns while the target moves
            e, n = east + v_east * time, north + v_north * time
            time = (scan + np.arctan2(e, n) % (2 * np.pi) / (2 * np.pi)) * PERIOD
        if k not in skip:
            made.append(plot(time, e, n))
    return tuple(sorted(made, key=lambda p: p.time))


def given(scan: int, plots: tuple[Plot, ...]) -> TrackerInput:
    return TrackerInput(scan=scan, time=(scan + 1) * PERIOD, east=0, north=0, heading=0, course=0, speed=0, plots=plots)


def tracked(association: str, scans: int = 20, skip: dict[int, set[int]] | None = None) -> list[list[TrackState]]:
    tracker = StoneSoupTracker(Tuning("jpda" if association == "jpda" else "gnn"))
    targets = [(-300.0, 2000.0, 12.0, 0.0), (1500.0, -800.0, -3.0, 6.0)]
    return [
        list(tracker.update(given(scan, plots_of(scan, targets, (skip or {}).get(scan, set()))))) for scan in range(scans)
    ]


@pytest.mark.parametrize("association", ["gnn", "jpda"])
def test_straight_targets_are_tracked_exactly(association: str) -> None:
    """Plots without noise: states at the times of the plots, within 1 m and 0.2 m/s after twenty scans; the first one passes
    north."""
    states = tracked(association)[-1]
    assert [state.track for state in states] == ["1", "2"]
    for state, (east, north, v_east, v_north) in zip(
        sorted(states, key=lambda s: -s.north), [(-300.0, 2000.0, 12.0, 0.0), (1500.0, -800.0, -3.0, 6.0)], strict=True
    ):
        assert np.hypot(state.east - east - v_east * state.time, state.north - north - v_north * state.time) < 1.0
        assert np.hypot(state.velocity_east - v_east, state.velocity_north - v_north) < 0.2
        assert 19 * PERIOD <= state.time <= 20 * PERIOD


@pytest.mark.parametrize("association", ["gnn", "jpda"])
def test_a_track_survives_missed_scans_and_ends_after_many(association: str) -> None:
    missed = tracked(association, skip={scan: {1} for scan in (10, 11, 12)})
    assert all(len(states) == 2 for states in missed[6:])
    lost = tracked(association, 30, skip={scan: {1} for scan in range(10, 30)})
    assert len(lost[9]) == 2 and len(lost[-1]) == 1


def test_a_track_is_confirmed_after_four_plots() -> None:
    assert [len(states) for states in tracked("gnn")[:6]] == [0, 0, 0, 2, 2, 2]


@pytest.mark.parametrize("association", ["gnn", "jpda"])
def test_two_plots_of_one_target_in_a_scan_are_of_two_turns(association: str) -> None:
    """A strong target west of north, whose cluster ends beyond north in scans 8 and 11: its plot comes a scan later, beside the
    next one. An average of both, 2.5 s apart, would lie 15 m behind."""
    east, north, v_east = -700.0, 1900.0, 12.0
    tracker = StoneSoupTracker(Tuning("jpda" if association == "jpda" else "gnn"))
    every = [plots_of(scan, [(east, north, v_east, 0.0)]) for scan in range(13)]
    every[9], every[12] = every[8] + every[9], every[11] + every[12]
    every[8] = every[11] = ()
    for scan, plots in enumerate(every):
        states = tracker.update(given(scan, plots))
    (state,) = states
    assert np.hypot(state.east - east - v_east * state.time, state.north - north) < 1.0
    assert np.hypot(state.velocity_east - v_east, state.velocity_north) < 0.2


def pull(distance: float, ahead: float, clutter: float) -> float:
    """How far [m] jpda moves a track of a ship at rest due east, at a distance, to a plot that is `ahead` too far, after five
    plots without errors of 10 m both ways. These confirm it by nearest neighbours."""
    tuning = Tuning("jpda", 10.0, 10.0 / distance, clutter=clutter, confirm=5)
    tracker = StoneSoupTracker(tuning)
    for scan in range(5):
        tracker.update(given(scan, (plot((scan + 0.25) * PERIOD, distance, 0.0),)))
    (state,) = tracker.update(given(5, (plot(5.25 * PERIOD, distance + ahead, 0.0),)))
    return state.east - distance


@pytest.mark.parametrize("distance", [1000.0, 4000.0])
def test_jpda_weighs_plots_against_clutter_on_the_map(distance: float) -> None:
    """The weight of the only plot is L / (1 - Pd Pg + L), where L is Pd times its likelihood [1/m^2] over the false plots per
    m^2 (Bar-Shalom, Daum and Huang 2009, eq. 37), with a Kalman filter of one axis beside it: at each range the same. The
    range of the plot, by which its likelihood is divided, is that of the prediction to `ahead` of it."""
    tuning, clutter, ahead = Tuning(), 1e-3, 25.0
    p, step = np.diag([100.0, tuning.speed_error**2]), np.array([[1.0, PERIOD], [0.0, 1.0]])
    noise = tuning.acceleration * np.array([[PERIOD**3 / 3.0, PERIOD**2 / 2.0], [PERIOD**2 / 2.0, PERIOD]])
    for _ in range(4):
        p = step @ p @ step.T + noise
        p = p - np.outer(p[:, 0], p[0]) / (p[0, 0] + 100.0)
    expected = (step @ p @ step.T + noise)[0, 0]
    likelihood = np.exp(-0.5 * ahead**2 / (expected + 100.0)) / (2.0 * np.pi * (expected + 100.0))
    ratio = tuning.detection * likelihood / clutter
    weight = ratio / (1.0 - tuning.detection * 0.99 + ratio)
    assert 0.3 < weight < 0.8
    assert pull(distance, ahead, clutter) == pytest.approx(
        weight * expected / (expected + 100.0) * ahead, rel=ahead / distance
    )


def test_without_stone_soup_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "radar_service.bench.trackers.stone_soup_parts", raising=False)
    monkeypatch.setitem(sys.modules, "stonesoup.base", None)  # type: ignore[arg-type]
    with pytest.raises(ImportError, match="the reference trackers need the package stonesoup, of the extra tracking"):
        StoneSoupTracker()
