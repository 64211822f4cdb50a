"""The picture of plots: each kind has its colour where its plots are."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageColor

from radar_service.plots.picture import COLOURS, write_picture
from radar_service.plots.plot_report import KINDS
from tests.plots.test_plot_report import report_of


def test_ships_and_buoys_are_marked_where_they_are(tmp_path: Path) -> None:
    write_picture(tmp_path / "plots.png", report_of(1))
    pixels = np.asarray(Image.open(tmp_path / "plots.png").convert("RGB")).astype(int)
    middle = pixels.shape[0] / 2
    for kind, of_colour in ((kind, np.array(ImageColor.getrgb(COLOURS[kind]))) for kind in ("ship", "buoy")):
        rows = np.nonzero((np.abs(pixels - of_colour).sum(axis=2) < 30)[:, : pixels.shape[1] * 2 // 3])[0]
        assert len(rows) > 20 and (rows.mean() > middle if kind == "ship" else rows.mean() < middle), kind
    assert set(COLOURS) == set(KINDS)
