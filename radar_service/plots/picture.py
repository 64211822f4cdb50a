"""A picture of plots on the PPI, in the colours of their kinds."""

from pathlib import Path

import numpy as np

from radar_service.display.units import DEFAULT_UNIT, UNITS, Unit
from radar_service.plots.plot_report import KINDS, PlotReport
from radar_service.terminal import extra, written

with extra("pictures", "pictures of plots"):
    from matplotlib.figure import Figure

COLOURS = {  # of kinds
    "ship": "#ff5050", "buoy": "#40ff40", "land": "#c8a060", "clutter": "#50a0ff", "interference": "#ff60ff", "noise": "#ffffff",
}  # fmt: skip
SIZE = {"ship": 40.0, "buoy": 40.0}  # of marks [points^2]
SMALL = 4.0  # of the others, which are many


def write_picture(path: Path, report: PlotReport, unit: Unit = DEFAULT_UNIT) -> None:
    """Writes the last scan of a report with its plots as a PNG. unit: of the axes. Raises OSError."""
    figure = Figure(figsize=(10.0, 9.0), layout="constrained")
    axes = report.last.plot(figure.subplots(), unit=unit)
    for kind in KINDS:
        some = [
            labelled.plot for labelled in report.plots if labelled.kind == kind and labelled.plot.scan == report.last.number
        ]
        distance, bearing = (
            np.array([plot.range / UNITS[unit].metres for plot in some]),
            np.array([plot.bearing for plot in some]),
        )
        axes.scatter(
            distance * np.sin(bearing), distance * np.cos(bearing), s=SIZE.get(kind, SMALL), label=f"{kind}: {len(some)}",
            facecolors="none" if kind in SIZE else COLOURS[kind], edgecolors=COLOURS[kind], linewidths=1.0,
        )  # fmt: skip
    axes.legend(loc="upper right")
    with written(path) as part:
        figure.savefig(part, dpi=110)
