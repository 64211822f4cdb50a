"""The chart's figure: axis titles, labels and notes are all there, nothing overlaps, and the bytes repeat."""

from functools import cache
from io import BytesIO
from itertools import combinations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from radar_service.study.chart.figure import Panel, chart_figure
from radar_service.study.chart.point import Point
from radar_service.study.plotting import png_bytes, svg_text

NOTES = [f"result {k}: a line that is long enough for the column beside the axes" for k in range(7)]


def panels() -> list[Panel]:
    """Returns a panel of 25 points of eight families, and one of points without error."""
    rng = np.random.default_rng(11)
    field = [
        Point("field", f"method {k % 8}", f"{k} bins", tuple(t * rng.uniform(0.8, 1.2, 3)), k % 8 == 0, e)
        for k, (t, e) in enumerate(zip(10.0 ** rng.uniform(-4, 0, 25), rng.uniform(-120, 0, 25), strict=True))
    ]
    power = [Point("power", "rays", f"{n}", (n * 1e-6,), False, None, None, 1.0) for n in (500, 2000)]
    power.append(Point("power", "scatterers", "4 per cell", (1e-3,), False, 0.2, 0.9, 0.0, "balanced"))
    return [Panel("Chain", "error [dB]", field, -150.0, NOTES), Panel("Samplers", "error [dB]", power, 0.01, NOTES, True)]


@cache
def picture_bytes() -> bytes:
    """The figure of the panels as PNG."""
    return png_bytes(chart_figure("harbour", "a processor", panels(), 3e-3))


def texts(figure: Figure) -> list[Text]:
    """Returns the texts of a figure that are drawn; matplotlib also keeps tick labels outside of the axes."""
    figure.draw_without_rendering()
    hidden = set()
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
        hidden |= {label for tick in ticks if not low <= tick.get_loc() <= high for label in (tick.label1, tick.label2)}
    drawn = [text for text in figure.findobj(Text) if isinstance(text, Text) and text not in hidden]
    return [text for text in drawn if text.get_visible() and text.get_text().strip()]


def test_every_axis_has_a_title_and_every_preset_a_label() -> None:
    figure = chart_figure("harbour", "a processor", panels(), 3e-3)
    words = [text.get_text() for text in texts(figure)]
    for panel, axes in zip(panels(), (a for a in figure.axes if a.get_ylabel()), strict=True):
        assert axes.get_xlabel() == "CPU time per azimuth" and axes.get_ylabel() == "error [dB]" and panel.title in words
    assert words.count("slower than real time") == 2
    assert "no target\nmet" in words and "4 per cell = balanced" in words


def test_texts_stay_on_the_figure_and_do_not_overlap() -> None:
    """All boxes are within the figure; two of them share at most a pixel of height, which is the room between lines."""
    figure = chart_figure("harbour", "a processor", panels(), 3e-3)
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts(figure)]
    width, height = figure.bbox.size
    for text, box in boxes:
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height, text
    for (one, a), (other, b) in combinations(boxes, 2):
        width, height = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert max(0.0, width) * max(0.0, height) <= min(a.width, b.width), (one, other)


def test_the_same_data_gives_the_same_bytes_without_metadata() -> None:
    first, second = (chart_figure("harbour", "a processor", panels(), 3e-3) for _ in range(2))
    assert png_bytes(first) == picture_bytes() and svg_text(first) == svg_text(second)
    with Image.open(BytesIO(picture_bytes())) as picture:
        assert picture.size[0] == 1660 and not picture.text  # two pixels for each of 830


def test_every_family_has_its_colour_in_the_png() -> None:
    """The palette keeps the colours of the marks: blue of the first family, orange of the second."""
    with Image.open(BytesIO(picture_bytes())) as picture:
        pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
        assert (np.abs(pixels - colour).max(axis=1) <= 12).sum() > 100
