"""CPU of what the bench does in a crowd: plots and tracks are paired, and plots of a harbour at sea state 3 are told apart."""

from time import process_time
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.bench.trackers.gating import Tuning
from radar_service.bench.trackers.stone_soup import StoneSoupTracker
from radar_service.bench.trackers.stone_soup_parts import GatedJointProbabilities, GatedNearestNeighbours
from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.plot_report import labelled_plots
from radar_service.plots.thresholds import CellAveraging
from tests.bench.trackers.test_stone_soup import given, plots_of

COUNT, SCANS = 200, 10


@pytest.mark.bench
@pytest.mark.parametrize(("association", "most"), [("gnn", 0.2), ("jpda", 0.3)])
def test_200_plots_are_associated_with_200_tracks_in_a_fifth_of_a_second_of_cpu(
    association: str, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """JPDA, whose probabilities Stone Soup counts one by one, takes half as much again."""
    kind = GatedJointProbabilities if association == "jpda" else GatedNearestNeighbours
    its_own, seconds = kind.associate, list[float]()

    def timed(self: Any, tracks: Any, plots: Any, time: Any) -> Any:
        began = process_time()
        result = its_own(self, tracks, plots, time)
        if len(tracks) > 0.95 * COUNT:
            seconds.append(process_time() - began)
        return result

    monkeypatch.setattr(kind, "associate", timed)
    rng = np.random.default_rng(0)
    targets = [(*rng.uniform(-6000.0, 6000.0, 2), *rng.uniform(-8.0, 8.0, 2)) for _ in range(COUNT)]
    tracker = StoneSoupTracker(Tuning("jpda" if association == "jpda" else "gnn"))
    for scan in range(SCANS):
        tracker.update(given(scan, plots_of(scan, targets)))
    print(f"\n{association}: {np.median(seconds):.3f} s of CPU a scan")
    assert len(seconds) > SCANS // 2 and np.median(seconds) < most


@pytest.mark.bench
def test_plots_of_the_harbour_take_at_most_twice_the_cpu_of_its_scans() -> None:
    scene = rs.load_scene("harbour")
    bare, told = (rs.Simulator(scene, "balanced", 0, labels=labels) for labels in (False, True))
    for simulator in (bare, told):
        simulator.scan()
    began = process_time()
    for _ in range(SCANS):
        bare.scan()
    between = process_time()
    extractor = PlotExtractor(scene.radar, CellAveraging(scene.radar, 1e-4, 100.0, 300.0), max_plots=10_000, tell=print)
    labelled_plots(told, extractor, SCANS - 2)
    scans, plots = between - began, process_time() - between
    print(f"\nscans {scans / SCANS:.3f} s of CPU, with plots {plots / SCANS:.3f} s: {plots / scans:.2f} times")
    assert plots < 2.0 * scans
