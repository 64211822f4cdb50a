"""The short modules of plots, each under its name."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageColor

from radar_service.plots.detections import Detections
from radar_service.plots.flood import flood_of
from radar_service.plots.groups import Groups
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.picture import COLOURS, write_picture
from radar_service.plots.plot import Plot, ScanGeometry, plot_columns, plots_of
from radar_service.plots.plot_report import KINDS
from radar_service.plots.thresholds import CellAveraging, KnownThreshold
from tests.plots.test_clusters import detections
from tests.plots.test_plot_report import report_of
from tests.scenes import radar


# picture: the picture of plots: each kind has its colour where its plots are.
def test_ships_and_buoys_are_marked_where_they_are(tmp_path: Path) -> None:
    write_picture(tmp_path / "plots.png", report_of(1))
    pixels = np.asarray(Image.open(tmp_path / "plots.png").convert("RGB")).astype(int)
    middle = pixels.shape[0] / 2
    for kind, of_colour in ((kind, np.array(ImageColor.getrgb(COLOURS[kind]))) for kind in ("ship", "buoy")):
        rows = np.nonzero((np.abs(pixels - of_colour).sum(axis=2) < 30)[:, : pixels.shape[1] * 2 // 3])[0]
        assert len(rows) > 20 and (rows.mean() > middle if kind == "ship" else rows.mean() < middle), kind
    assert set(COLOURS) == set(KINDS)


# groups: groups against sums and extremes in a loop.
def test_groups_are_those_of_a_loop() -> None:
    rng = np.random.default_rng(1)
    label = rng.integers(0, 9, 60) * 7
    values = rng.permutation(60).astype(float)
    groups = Groups(label)
    names = sorted(set(label.tolist()))
    assert len(groups) == len(names)
    for number, name in enumerate(names):
        own = np.flatnonzero(label == name)
        assert groups.members(np.array([number])).tolist() == own.tolist() and groups.count[number] == len(own)
        assert (groups.of_each[own] == number).all()
        assert groups.maximum(values)[number] == values[own].max() and groups.minimum(values)[number] == values[own].min()
        assert groups.total(values)[number] == values[own].sum()
        assert groups.strongest(values)[number] == own[values[own].argmax()]


def test_the_first_of_equals_is_the_strongest() -> None:
    assert Groups(np.array([1, 0, 1, 0])).strongest(np.array([5.0, 2.0, 5.0, 2.0])).tolist() == [1, 0]


def test_nothing_has_no_groups() -> None:
    groups = Groups(np.empty(0, dtype=np.int64))
    assert len(groups) == 0 == len(groups.maximum(np.empty(0))) == len(groups.strongest(np.empty(0)))


def test_members_of_some_groups_follow_each_other() -> None:
    groups = Groups(np.array([2, 0, 1, 0, 2, 2]))
    assert groups.members(np.array([2, 0])).tolist() == [0, 4, 5, 1, 3]
    assert groups.members(np.array([], dtype=np.int64)).tolist() == []


# flood: what is a flood, and what its text says to set.
@pytest.mark.parametrize(
    ("detections", "plots", "dropped", "flooded"),
    [(200, 40, 40, False), (201, 0, 0, True), (200, 40, 41, True), (200, 1000, 0, False), (200, 1000, 1, True), (0, 0, 0, False)],
)  # fmt: skip
def test_a_flood_is_a_fifth_of_all_cells_a_thousand_plots_or_half_of_them_dropped(
    detections: int, plots: int, dropped: int, flooded: bool
) -> None:
    assert (flood_of(3, detections, 1000, plots, dropped, KnownThreshold(radar())) is not None) is flooded


def test_the_text_says_how_many_why_and_what_to_set() -> None:
    known = str(flood_of(3, 64_000, 2_000_000, 40, 2_941, KnownThreshold(radar())))
    assert known == (
        "scan 3: 64,000 of 2,000,000 cells (3.2 %) exceed the threshold; the 2,941 weakest of 2,981 plots are dropped: the "
        'threshold "known" counts sea clutter, rain and land as targets; set threshold to "marine" (PlotExtractor.for_scene), '
        "or max_plots above 40"
    )
    averaging = str(flood_of(3, 64_000, 2_000_000, 1040, 0, CellAveraging(radar(), 1e-4)))
    assert 'set threshold to "marine"' in averaging and "max_plots" not in averaging and "dropped" not in averaging


def test_a_flood_of_noise_alone_is_told_from_clutter() -> None:
    noise = str(flood_of(0, 450, 4_000_000, 200, 201, KnownThreshold(radar(), 1e-4)))
    assert noise.endswith("noise alone gives 400; set a lower pfa (now 0.0001), or max_plots above 200")


def test_what_is_set_already_is_not_asked_for() -> None:
    def text(nearest: float) -> str:
        return str(flood_of(3, 640_000, 2_000_000, 200, 900, MarineThreshold(radar()), nearest)).partition("; set ")[2]

    near = "nearest beyond the sea clutter about own ship"
    assert text(0.0) == f"a lower pfa (now 5e-06), as 1e-07, {near}, or max_plots above 200"
    assert text(300.0) == "a lower pfa (now 5e-06), as 1e-07, or max_plots above 200"


# plot: A plot of a cluster of known cells.
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
