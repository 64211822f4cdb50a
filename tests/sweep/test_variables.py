"""What is kept of a scan: the same as the simulator, the truth and the plot extractor give."""

from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.display.video import Controls, display_video
from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.thresholds import CellAveraging
from radar_service.sweep.layout import layout_of
from radar_service.sweep.spec import SweepError
from radar_service.sweep.variables import ScanReader, bins_of
from tests.scenes import scene
from tests.sweep.sweeps import SPEC, inputs

EVERYTHING = SPEC.replace(
    '["video", "power", "truth"]', '["video", "power", "field", "labels", "own_ship", "truth", "plots"]'
)


def read(folder: Path, spec: str, scans: int = 1) -> tuple[rs.Simulator, list[rs.Scan], list[dict[str, np.ndarray]]]:
    """A simulator of the first run, its scans, and what is kept of them."""
    of = inputs(folder, spec)
    layout = layout_of(of)
    simulator = rs.Simulator(of.scene(of.runs[0]), seed=of.runs[0].seed, labels="labels" in of.spec.keep)
    reader = ScanReader(simulator, of.spec, layout.arrays, layout.sizes, ["buoy", "cube"])
    some = [simulator.scan() for _ in range(scans)]
    return simulator, some, [reader.arrays(scan) for scan in some]


def test_all_cells_are_those_of_the_scan(tmp_path: Path) -> None:
    simulator, (scan,), (kept,) = read(tmp_path, EVERYTHING.replace("bins = 40", ""))
    np.testing.assert_array_equal(kept["power"], scan.power)
    np.testing.assert_array_equal(kept["field"], scan.field)
    np.testing.assert_array_equal(kept["labels"], scan.labels)
    for name in ("time", "heading", "course", "speed"):
        np.testing.assert_array_equal(kept[name], getattr(scan, name))
    np.testing.assert_array_equal(np.stack([kept["east"], kept["north"]], axis=1), scan.position)
    to = bins_of(simulator.scene.radar, inputs(tmp_path, EVERYTHING.replace("bins = 40", "")).spec)
    np.testing.assert_array_equal(kept["video"], display_video(scan.power, to, Controls(), simulator.noise_power))
    assert {name: array.dtype.name for name, array in kept.items() if array.ndim == 2} == {
        "video": "uint8",
        "power": "float32",
        "field": "complex64",
        "labels": "uint16",
    }


def test_of_each_bin_the_strongest_cell_counts(tmp_path: Path) -> None:
    """Written out cell by cell."""
    simulator, (scan,), (kept,) = read(tmp_path, EVERYTHING)
    assert scan.labels is not None
    cells = scan.power.shape[1]
    owner = [int((n + 0.5) * 40 / cells) for n in range(cells)]
    for row in range(0, 60, 7):
        for bin_number in range(0, 40, 3):
            members = [n for n in range(cells) if owner[n] == bin_number]
            best = max(members, key=lambda n: (scan.power[row, n], -n))
            assert kept["power"][row, bin_number] == scan.power[row, best]
            assert kept["labels"][row, bin_number] == scan.labels[row, best]
            assert abs(kept["field"][row, bin_number]) == pytest.approx(abs(scan.field[row, best]), rel=1e-6)  # float32


def test_cells_of_each_label_are_counted_over_all_scans_of_a_run(tmp_path: Path) -> None:
    of = inputs(tmp_path, EVERYTHING)
    layout, simulator = layout_of(of), rs.Simulator(of.scene(of.runs[0]), labels=True)
    reader = ScanReader(simulator, of.spec, layout.arrays, layout.sizes, ["buoy", "cube"])
    labels = np.stack([reader.arrays(simulator.scan())["labels"] for _ in range(2)])
    counted = reader.of_run()["label_cells"]
    assert counted.tolist() == [int((labels == number).sum()) for number in range(258)]
    assert counted[0] and counted[256] and counted[257] and counted.sum() == 2 * 60 * 40


def test_truth_is_that_of_the_crossings(tmp_path: Path) -> None:
    simulator, _, kept = read(tmp_path, EVERYTHING, 2)
    for number, row in enumerate(kept):
        crossings = simulator.crossings(number)
        count = len(crossings)
        assert 1 <= count < 4 and np.isnan(row["truth_time"][count:]).all() and (row["truth_body"][count:] == -1).all()
        assert [["buoy", "cube"][k] for k in row["truth_body"][:count]] == [crossing.body for crossing in crossings]
        for name in ("time", "range", "bearing", "course", "speed", "aspect", "visible"):
            assert row[f"truth_{name}"][:count].tolist() == [getattr(crossing, name) for crossing in crossings]
        assert row["truth_north"][:count].tolist() == [crossing.position[1] for crossing in crossings]


def test_plots_are_those_of_the_extractor(tmp_path: Path) -> None:
    spec = EVERYTHING.replace(
        "seeds = 2", 'seeds = 2\nplots = {threshold = "ca", guard_m = 20, window_m = 60, max_plots = 7}'
    )
    simulator, scans, kept = read(tmp_path, spec, 3)
    radar = simulator.scene.radar
    extractor = PlotExtractor(radar, CellAveraging(radar, 1e-7, 20.0, 60.0), max_plots=7)
    for scan, row in zip(scans, kept, strict=True):
        plots = extractor.add(scan).plots
        assert row["plot_range"][: len(plots)].tolist() == [plot.range for plot in plots]
        assert row["plot_cells"].tolist() == [plot.cells for plot in plots] + [0] * (7 - len(plots))
    assert any((row["plot_cells"] > 0).any() for row in kept)


def test_errors_on_purpose_have_their_reported_azimuth(tmp_path: Path) -> None:
    spec = SPEC + '"errors.antenna.misalignment_deg" = [2]\n'
    _, (scan,), (kept,) = read(tmp_path, spec)
    np.testing.assert_array_equal(kept["reported_azimuth"], scan.azimuth)
    assert np.rad2deg(kept["reported_azimuth"][5] - 5 * np.pi / 30) == pytest.approx(2.0)


def test_a_crossing_without_room_or_name_is_told(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="^truth: a scan has 2 crossings, and the store room for 1; set max_crossings$"):
        read(tmp_path, SPEC.replace("seeds = 2", "seeds = 2\nmax_crossings = 1"))
    of = inputs(tmp_path)
    layout, simulator = layout_of(of), rs.Simulator(of.scene(of.runs[0]))
    with pytest.raises(SweepError, match="^truth: the store does not know the body 'cube'; vary no names of bodies$"):
        ScanReader(simulator, of.spec, layout.arrays, layout.sizes, ["buoy"]).arrays(simulator.scan())


def test_a_radar_that_does_not_fit_is_told(tmp_path: Path) -> None:
    of = inputs(tmp_path)
    layout = layout_of(of)
    other = rs.Simulator(scene(radar={"azimuths": 90, "beamwidth_deg": 8, "range_max_m": 600}))
    with pytest.raises(SweepError, match="^its radar has 90 in azimuth, and the store 60; vary nothing that changes it$"):
        ScanReader(other, of.spec, layout.arrays, layout.sizes, [])
