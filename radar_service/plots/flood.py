"""Floods: scans with more detections than a tracker can use, and what to set against them."""

from collections.abc import Sequence
from dataclasses import dataclass

from radar_service.plots.marine import MarineThreshold
from radar_service.plots.thresholds import KnownThreshold, Threshold

FLOODED = 0.2  # of all cells: one strong target without noise, with its sidelobes, has 0.06
MANY = 1000  # plots of a scan: the forty ships of a busy strait and the false alarms at PFA 1e-4 are a third
LOWEST = 1e-7  # pfa of use in clutter: a lower one has no small targets left
NOISE = 3.0  # times the false alarms that noise gives: fewer detections are noise


class FloodWarning(UserWarning):
    """A scan floods the plot extractor."""


@dataclass(frozen=True)
class Flood:
    """A scan of which more plots are dropped than reported, with more than MANY, or with detections in FLOODED of its cells.

    scan: its number.
    detections, cells: number of cells that exceed the threshold, and of all.
    plots, dropped: number of plots that are reported, and of those beyond the maximum.
    remedy: what to set.
    """

    scan: int
    detections: int
    cells: int
    plots: int
    dropped: int
    remedy: str

    def __str__(self) -> str:
        share = 100.0 * self.detections / self.cells
        weakest = (
            f"; the {self.dropped:,} weakest of {self.plots + self.dropped:,} plots are dropped" if self.dropped else ""
        )
        return (
            f"scan {self.scan}: {self.detections:,} of {self.cells:,} cells ({share:.2g} %) exceed the threshold{weakest}: "
            f"{self.remedy}"
        )


def flood_remark(floods: Sequence[Flood], scans: int) -> str | None:
    """Returns a sentence about the floods of so many scans, with the one of most detections; None without floods."""
    if not floods:
        return None
    worst = max(floods, key=lambda flood: flood.detections)
    return f"{len(floods)} of {scans} scans flood the plot extractor; {worst}"


def flood_of(
    scan: int, detections: int, cells: int, plots: int, dropped: int, threshold: Threshold, nearest: float = 0.0
) -> Flood | None:
    """Returns the flood of a scan, None where there is none. Numbers as in Flood; nearest: as of a PlotExtractor [m]."""
    if dropped <= plots and plots + dropped <= MANY and detections <= FLOODED * cells:
        return None
    pfa = getattr(threshold, "pfa", None)
    more = f", or max_plots above {plots}" if dropped else ""
    return Flood(scan, detections, cells, plots, dropped, _remedy(threshold, pfa, detections, cells, nearest) + more)


def _remedy(threshold: Threshold, pfa: float | None, detections: int, cells: int, nearest: float) -> str:
    """Why, and what to set that is not set yet."""
    lower = "a lower pfa" + ("" if pfa is None else f" (now {pfa:g})")
    if pfa is not None and detections < NOISE * pfa * cells:
        return f"noise alone gives {pfa * cells:,.0f}; set {lower}"
    if not isinstance(threshold, MarineThreshold):
        counted = (
            'the threshold "known" counts sea clutter, rain and land as targets'
            if isinstance(threshold, KnownThreshold)
            else "sea clutter is spikier than noise, and land has edges"
        )
        return f'{counted}; set threshold to "marine" (PlotExtractor.for_scene)'
    near = [] if nearest else ["nearest beyond the sea clutter about own ship"]
    return f"the clutter is spikier than its shape says; set {', '.join([f'{lower}, as {LOWEST:g}', *near])}"
