"""Plots: thresholds and CFAR, clusters, sidelobes, and of which source each plot is."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.plots.clusters import ClusterRule
    from radar_service.plots.detections import Detections
    from radar_service.plots.extractor import Extract, LivePlots, PlotExtractor, ScanPlots, in_clutter
    from radar_service.plots.flood import Flood, FloodWarning, flood_remark
    from radar_service.plots.marine import PFA, threshold
    from radar_service.plots.plot import Plot
    from radar_service.plots.plot_process import PlotProcess, extraction
    from radar_service.plots.plot_report import LabelledPlot, PlotReport, labelled_plots
    from radar_service.plots.thresholds import CellAveraging, KnownThreshold, OrderedStatistic, Threshold
else:
    __getattr__, __dir__ = lazily(__name__)

__all__ = [
    "CellAveraging", "ClusterRule", "FloodWarning", "KnownThreshold", "LabelledPlot", "OrderedStatistic", "Plot",
    "PlotExtractor", "PlotReport", "ScanPlots", "Threshold", "labelled_plots",
]  # fmt: skip
