"""What is a flood, and what its text says to set."""

import pytest

from radar_service.plots.flood import flood_of
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.thresholds import CellAveraging, KnownThreshold
from tests.scenes import radar


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
