"""Plots told apart by labels: what is where by the scene, Pfa of noise as it was set, and plots across north."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.plot_report import PlotReport, kinds_of, labelled_plots
from radar_service.plots.thresholds import KnownThreshold
from radar_service.scans.scan import Scan

PFA = 0.01
SCENE: dict[str, Any] = {
    "name": "five kinds",
    "radar": {"azimuths": 64, "beamwidth_deg": 8, "range_max_m": 600, "pulse_s": 1e-6, "bandwidth_hz": 20e6,
              "sample_rate_hz": 30e6, "power_w": 1, "height_m": 10},
    "environment": {"noise": True},
    "body": [
        {"name": "under way", "shape": "point", "position_m": [-20, -300, 5], "rcs_dbsm": 0, "course_deg": 90, "speed_kn": 20},
        {"name": "moored", "shape": "point", "position_m": [300, 0, 5], "rcs_dbsm": 0, "mmsi": 299000001},
        {"name": "reflector", "shape": "point", "position_m": [0, 300, 5], "rcs_dbsm": 0},
        {"name": "far", "shape": "point", "position_m": [-400, 0, 5], "rcs_dbsm": -60},
        {"name": "pier", "shape": "box", "length_m": 20, "width_m": 5, "height_m": 5, "position_m": [-200, -200, 0],
         "material": "concrete"},
    ],
}  # fmt: skip


def report_of(scans: int = 4, **tables: Any) -> PlotReport:
    scene = rs.load_scene(SCENE | tables)
    simulator = rs.Simulator(scene, "balanced", 1, labels=True)
    return labelled_plots(simulator, PlotExtractor(scene.radar, KnownThreshold(scene.radar, PFA), tell=print), scans)


@pytest.fixture(scope="module")
def report() -> PlotReport:
    return report_of()


def test_each_label_has_a_kind() -> None:
    simulator = rs.Simulator(rs.load_scene(SCENE), "balanced", labels=True)
    kinds = {name: kinds_of(simulator.scene, [label])[label] for label, name in simulator.label_names.items()}
    assert kinds == {
        "noise": "noise", "sea": "clutter", "rain": "clutter", "interference": "interference",
        "second time around": "clutter", "land: concrete": "land", "under way": "ship", "moored": "ship",
        "reflector": "buoy", "far": "buoy", "range sidelobes and faint parts": "clutter",
    }  # fmt: skip


def test_bodies_have_their_plots_also_across_north(report: PlotReport) -> None:
    """The reflector stands at north, where scans end: one plot for each crossing, in whichever scan its centroid lies."""
    assert {one.name: (one.kind, one.crossings, one.with_cells, one.with_plot, one.pd) for one in report.bodies} == {
        "under way": ("ship", 4, 4, 4, 1.0), "moored": ("ship", 4, 4, 4, 1.0), "reflector": ("buoy", 4, 4, 4, 1.0),
        "far": ("buoy", 4, 0, 0, None),
    }  # fmt: skip
    assert [round(one.range) for one in report.bodies if one.name in ("moored", "reflector")] == [300, 300]
    for name, position in (("moored", (300, 0)), ("reflector", (0, 300))):
        plots = [one for one in report.plots if one.source == name and one.plot.cells > 5]
        assert len(plots) >= 3 and all(one.share > 0.9 for one in plots)  # at north one may fall outside of the scans
        for one in plots:  # 2 m of noise at 25 dB and more, a beam of 40 m across
            assert np.hypot(one.plot.east - position[0], one.plot.north - position[1]) < 4.0


def test_noise_alone_has_the_false_alarms_that_the_threshold_sets() -> None:
    """Within 4 sigma: samples are correlated, so the variance is 1.5 times binomial."""
    report = report_of(4, body=[SCENE["body"][3]])
    noise = report.kinds[-1]
    assert (noise.kind, noise.cells) == ("noise", 4 * 64 * 121) and noise.share == noise.detected / noise.cells
    assert abs(noise.share - PFA) < 4.0 * np.sqrt(1.5 * PFA * (1 - PFA) / noise.cells)
    assert noise.plots == len(report.plots) > 10 and noise.plots_per_scan == noise.plots / 4


def test_every_cell_has_a_kind(report: PlotReport) -> None:
    """600 m have 121 cells of c / (2 x 30 MHz)."""
    kinds = {one.kind: one for one in report.kinds}
    land = kinds["land"]
    assert sum(one.cells for one in report.kinds) == 4 * 64 * 121
    assert sum(one.plots for one in report.kinds) == len(report.plots)
    assert land.share is not None and land.share > 0.3 and land.plots >= 4
    assert kinds["interference"].plots == 0 and 0 < kinds["clutter"].cells < 400  # range sidelobes of bodies alone
    echoes = report_of(4, radar=SCENE["radar"] | {"labels_within_db": "none"}).kinds
    whole = {one.kind: one for one in echoes}
    assert (whole["clutter"].cells, whole["clutter"].share, whole["interference"].plots) == (0, None, 0)
    for kind in ("land", "noise"):
        assert whole[kind].cells == kinds[kind].cells
    assert (whole["ship"].share or 0.0) < (kinds["ship"].share or 0.0)


def test_sea_is_clutter() -> None:
    report = report_of(1, environment={"noise": True, "sea_state": 5})
    assert report.remark is not None and report.remark.startswith("3 of 3 scans flood the plot extractor; scan ")
    kinds = {one.kind: one for one in report.kinds}
    clutter, noise = kinds["clutter"], kinds["noise"]
    assert clutter.cells > 1000 and clutter.share is not None and noise.share is not None and clutter.share > noise.share


def test_the_ais_of_a_body_says_what_it_is() -> None:
    bodies = [
        {"name": kind, "shape": "point", "position_m": [300 - 50 * k, 0, 5], "rcs_dbsm": 0, "mmsi": 1 + k, "ais": {"kind": kind}}
        for k, kind in enumerate(("ship", "aid", "sart"))
    ]  # fmt: skip
    simulator = rs.Simulator(rs.load_scene(SCENE | {"body": bodies}), "balanced", labels=True)
    kinds = kinds_of(simulator.scene, list(simulator.label_names))
    assert [kinds[label] for label, name in simulator.label_names.items() if name in ("ship", "aid", "sart")] == [
        "ship",
        "buoy",
        "buoy",
    ]


def test_plain_data_has_no_arrays(report: PlotReport) -> None:
    data = report.as_dict()
    assert (data["scene"], data["seed"], data["scans"], len(data["plots"])) == ("five kinds", 1, 4, len(report.plots))
    assert data["plots"][0].keys() >= {"type", "range", "bearing", "source", "kind", "share"}
    assert report.last.number == 4 and {plot["scan"] for plot in data["plots"]} == {1, 2, 3, 4}


def test_what_is_not_allowed_is_named() -> None:
    scene = rs.load_scene(SCENE)
    with pytest.raises(ValueError, match="labels=True"):
        labelled_plots(rs.Simulator(scene, "balanced"), PlotExtractor(scene.radar), 1)
    with pytest.raises(ValueError, match="scans: 0 is not allowed"):
        labelled_plots(rs.Simulator(scene, "balanced", labels=True), PlotExtractor(scene.radar), 0)


def test_the_first_flood_is_told_after_its_scan() -> None:
    """Each scan has more plots than two; the first one is told of before the next one is computed."""
    scene = rs.load_scene(SCENE)
    simulator, told = rs.Simulator(scene, "balanced", 1, labels=True), list[tuple[str, int]]()
    done: list[Scan] = []
    extractor = PlotExtractor(
        scene.radar, KnownThreshold(scene.radar, 0.3), tell=lambda flood: told.append((flood[:8], len(done)))
    )

    def watched(scans: Iterable[Scan], count: int) -> Iterator[Scan]:
        for scan in scans:
            done.append(scan)
            yield scan

    report = labelled_plots(simulator, extractor, 2, watched)
    assert told == [("scan 0: ", 1)] and report.remark is not None and report.remark.startswith("4 of 4 scans flood")
