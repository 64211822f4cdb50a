"""The reference tracker: straight targets from plots of many times in a scan, both associations, across north."""

import subprocess
import sys

import numpy as np
import pytest

from radar_service.bench.trackers.stone_soup import StoneSoupTracker, Tuning
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


def test_without_stone_soup_the_remedy_is_named() -> None:
    code = (
        "import sys; sys.modules['stonesoup'] = None\n"
        "from radar_service.bench.trackers.stone_soup import StoneSoupTracker\n"
        "try: StoneSoupTracker()\nexcept ImportError as e: print(e)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "the reference trackers need the package stonesoup, of the extra tracking" in result.stdout
