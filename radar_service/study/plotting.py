"""Figures of the studies by matplotlib's object interface; the same data gives the same bytes.

Drawing takes place inside `style()`, so that a user's own settings change nothing. Figures are WIDTH inches wide, and have two
pixels for each one of a page.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO

import matplotlib.style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

WIDTH = 8.3  # inches
DPI = 200
# Okabe and Ito (2008) without their yellow, and a grey: distinct for the common colour blindnesses
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#000000", "#56B4E9", "#777777")
GRID, LIMIT, TEXT = "#e2e2e2", "#b00020", "#333333"
SMALL = 7.5  # points: 10 pixels at 830
STYLE = {
    "font.family": "DejaVu Sans", "font.size": 8.5, "axes.titlesize": 9.5, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.6, "axes.axisbelow": True,
    "axes.spines.right": False, "axes.spines.top": False, "axes.edgecolor": "#444444", "legend.frameon": False,
    "xtick.labelsize": SMALL, "ytick.labelsize": SMALL, "legend.fontsize": SMALL, "lines.linewidth": 1.6,
    "svg.fonttype": "none", "svg.hashsalt": "radar-service", "figure.dpi": DPI, "savefig.dpi": "figure",
}  # fmt: skip


@contextmanager
def style() -> Iterator[None]:
    """Applies matplotlib's defaults and STYLE for the time of the block."""
    with matplotlib.style.context(["default", STYLE]):
        yield


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Returns an empty figure of `width` x `height` [inches]; the caller is inside `style()`."""
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def png_bytes(figure: Figure) -> bytes:
    """Returns the figure as PNG of 256 colours without metadata."""
    drawn, out = BytesIO(), BytesIO()
    with style():
        figure.savefig(drawn, format="png", pil_kwargs={"compress_level": 0})
    image = Image.open(drawn).convert("RGB")
    # Maximum coverage keeps the colours of few pixels apart; a median cut would spend the palette on the greys of letters
    image.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


def svg_text(figure: Figure) -> str:
    """Returns the figure as SVG without metadata; its texts stay texts."""
    out = BytesIO()
    with style():
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    return re.sub(r"<metadata>.*?</metadata>\s*", "", out.getvalue().decode(), flags=re.DOTALL)


def duration(seconds: float) -> str:
    """Returns a time for a reader: 20 us, 3 ms, 1 s."""
    steps = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"))
    size, unit = next((step for step in steps if seconds >= step[0] * 0.999), (1e-9, "ns"))
    return f"{seconds / size:.3g} {unit}"


def percent(share: float) -> str:
    """Returns a share for a reader: 0.52 %."""
    return f"{100.0 * share:.2g} %" if share < 0.1 else f"{100.0 * share:.0f} %"


def number(value: float) -> str:
    """Returns a number for a reader, with three digits: 1,020 or 3.4e38."""
    if value == 0.0 or 1e-4 <= abs(value) < 1e6:
        return f"{float(f'{value:.3g}'):,.10g}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"
