"""Plots: thresholds and CFAR, clusters, sidelobes, and of which source each plot is."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.plots.clusters import ClusterRule
    from radar_service.plots.extractor import PlotExtractor, ScanPlots
    from radar_service.plots.flood import FloodWarning
    from radar_service.plots.plot import Plot
    from radar_service.plots.plot_report import LabelledPlot, PlotReport, labelled_plots
    from radar_service.plots.thresholds import CellAveraging, KnownThreshold, OrderedStatistic, Threshold

__all__ = [
    "CellAveraging", "ClusterRule", "FloodWarning", "KnownThreshold", "LabelledPlot", "OrderedStatistic", "Plot",
    "PlotExtractor", "PlotReport", "ScanPlots", "Threshold", "labelled_plots",
]  # fmt: skip

__getattr__, __dir__ = lazily(__name__)
