"""A plot of a cluster of known cells."""

import json

import numpy as np
import pytest

from radar_service.plots.detections import Detections
from radar_service.plots.groups import Groups
from radar_service.plots.plot import Plot, ScanGeometry, plot_columns, plots_of
from tests.plots.test_clusters import detections

GEOMETRY = ScanGeometry(azimuths=628, first=5.0, step=10.0, noise_power=0.5)


def plot_of(cells: Detections) -> Plot:
    """The plot of a single cluster."""
    (plot,) = plots_of(plot_columns(cells, Groups(np.zeros(len(cells), dtype=np.int64)), GEOMETRY), np.array([0]))
    return plot


def test_a_symmetric_cluster_is_reported_at_its_middle() -> None:
    image = np.zeros((5, 9))
    image[2, 4], image[1, 4], image[3, 4], image[2, 3], image[2, 5] = 100.0, 30.0, 30.0, 20.0, 20.0
    plot = plot_of(detections(image))
    assert plot.range == pytest.approx(45.0) and plot.bearing == pytest.approx(0.02) and plot.time == pytest.approx(0.2)
    assert plot.cells == 5 and plot.snr_db == pytest.approx(10 * np.log10(200)) and plot.scan == 0
    assert plot.range_extent == (30.0, 60.0) and plot.bearing_extent == pytest.approx(
        (0.01 - np.pi / 628, 0.03 + np.pi / 628)
    )
    assert (plot.east, plot.north) == pytest.approx((45 * np.sin(0.02), 45 * np.cos(0.02)))


def test_the_power_above_the_threshold_weighs() -> None:
    """Weights 9 and 3 over a threshold of 1: a quarter of a cell off the stronger one."""
    image = np.zeros((1, 4))
    image[0, 1], image[0, 2] = 10.0, 4.0
    assert plot_of(detections(image)).range == pytest.approx(15.0 + 10.0 * 3 / 12)


def test_cells_far_below_the_peak_do_not_weigh() -> None:
    image = np.zeros((1, 60))
    image[0, 1], image[0, 50] = 1e6, 900.0
    plot = plot_of(detections(image))
    assert plot.range == 15.0 and plot.range_extent == (10.0, 510.0)


def test_north_is_no_seam() -> None:
    image = np.full((3, 1), 10.0)
    cells = detections(image)
    cells.azimuth[:] = [2 * np.pi - 0.01, 0.0, 0.01]
    plot = plot_of(cells)
    assert min(plot.bearing, 2 * np.pi - plot.bearing) < 1e-12
    assert plot.bearing_extent == pytest.approx((2 * np.pi - 0.01 - np.pi / 628, 0.01 + np.pi / 628))


def test_a_plot_is_plain_data() -> None:
    line = json.loads(json.dumps(plot_of(detections(np.ones((1, 1)) * 2)).as_dict()))
    assert line["type"] == "plot" and {"time", "range", "bearing", "snr_db", "scan"} <= set(line)


def test_plots_of_many_clusters_are_those_of_each_alone() -> None:
    rng = np.random.default_rng(0)
    cells, label = detections(rng.exponential(10.0, (40, 30)) + 1.0), np.repeat(np.arange(120), 10)
    columns = plot_columns(cells, Groups(label), GEOMETRY)
    rows = np.array([7, 3, 119])
    for row, plot in zip(rows, plots_of(columns, rows), strict=True):
        alone = plot_of(cells.only(label == row))
        assert (plot.scan, plot.cells) == (alone.scan, alone.cells) and plot.range_extent == alone.range_extent
        assert plot.bearing_extent == pytest.approx(alone.bearing_extent, rel=1e-12)
        for key in ("time", "range", "bearing", "east", "north", "snr_db"):  # rounding of sums in another order
            assert getattr(plot, key) == pytest.approx(getattr(alone, key), rel=1e-12), key
