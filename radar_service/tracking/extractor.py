"""The plot extractor: from scans to plots, across north."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from radar_service.radar.parameters import Radar
from radar_service.receive.compression import receiver_noise_power
from radar_service.scan import Scan
from radar_service.tracking.clusters import ClusterRule, clusters, groups, parts
from radar_service.tracking.detections import Detections, detections_of, no_detections
from radar_service.tracking.peak_gate import about_peak
from radar_service.tracking.plot import Plot, SpokeLayout, plot_of
from radar_service.tracking.sidelobes import SidelobeGate
from radar_service.tracking.thresholds import KnownThreshold, Threshold
from radar_service.types import Indices

MARGIN_DB = 3.0  # over the sidelobes of a point at rest: those of moving and of several scatterers are stronger


@dataclass(frozen=True)
class ScanPlots:
    """The plots that ended in one scan.

    scan: its number.
    plots: by time.
    sidelobes: number of plots that the sidelobe gate removed.
    dropped: number of plots beyond the maximum, the weakest.
    cells: the detections of each plot.
    """

    scan: int
    plots: tuple[Plot, ...]
    sidelobes: int
    dropped: int
    cells: tuple[Detections, ...] = field(default=(), compare=False, repr=False)


class PlotExtractor:
    """Turns the scans of one radar into plots.

    A cluster that touches the end of a scan is finished with the next one. One that touches the very first spoke is cut, and
    gives no plot; neither does one that touches the end of the last scan.
    """

    def __init__(
        self, radar: Radar, threshold: Threshold | None = None, *, rule: ClusterRule | None = None, max_plots: int = 200,
        sidelobe_margin_db: float | None = MARGIN_DB, nearest: float = 0.0, gate_db: float = np.inf,
    ) -> None:  # fmt: skip
        """threshold: by default the known noise with PFA; max_plots: per scan; sidelobe_margin_db: None for no sidelobe gate;
        nearest: plots nearer than this [m] are left out, such as sea clutter about own ship; gate_db: cells
        count that connect with the peak of a plot and are this much weaker at most: 20 is the gate of the truth.

        Raises ValueError for a maximum below 1.
        """
        if max_plots < 1:
            raise ValueError(f"max_plots: {max_plots} is not allowed; 1 or more, best 20 to 200")
        self.threshold: Threshold = threshold or KnownThreshold(radar)
        self._rule, self._max_plots, self._nearest = rule or ClusterRule(), max_plots, nearest
        self._gate_db = gate_db
        self._gate = None if sidelobe_margin_db is None else SidelobeGate(radar, sidelobe_margin_db)
        self._layout = SpokeLayout(radar.azimuths, 0.5 * radar.range_step, radar.range_step, receiver_noise_power(radar))
        self._open = self._before = no_detections()  # of clusters that may go on, and all of the scan before
        self._first: int | None = None  # spoke of the first scan

    def scans(self, scans: Iterable[Scan]) -> Iterator[ScanPlots]:
        """Yields the plots of consecutive scans."""
        return map(self.add, scans)

    def add(self, scan: Scan) -> ScanPlots:
        """Returns the plots that end in a scan, which follows the one before. Missing spokes (NaN) hold no detections."""
        if self._first is None:
            self._first = scan.number * self._layout.azimuths
        fresh = detections_of(scan, self.threshold.of(scan.power))
        recent = self._before.and_then(fresh)
        closed = self._closed(fresh, (scan.number + 1) * self._layout.azimuths)
        ended = [self._gated(cluster.only(part)) for cluster in closed for part in parts(cluster, self._rule)]
        kept = [cells for cells in ended if not (self._gate and self._gate.is_sidelobe(cells, recent))]
        layout = replace(self._layout, first=float(scan.range[0]))  # where the feed says that samples stand
        plotted = ((plot_of(cells, layout), cells) for cells in kept)
        plots = sorted((pair for pair in plotted if pair[0].range >= self._nearest), key=lambda pair: -pair[0].snr_db)
        best = sorted(plots[: self._max_plots], key=lambda pair: pair[0].time)
        self._before = fresh
        return ScanPlots(
            scan.number, tuple(plot for plot, _ in best), len(ended) - len(kept), len(plots) - len(best),
            tuple(cells for _, cells in best),
        )  # fmt: skip

    def _gated(self, cells: Detections) -> Detections:
        return cells if np.isinf(self._gate_db) else about_peak(cells, self._gate_db)

    def _closed(self, fresh: Detections, end: int) -> list[Detections]:
        """The clusters that cannot go on at spoke `end`, but for those that the start cut; the others wait."""
        waiting = self._open.and_then(fresh)
        connected = groups(clusters(waiting, self._rule))
        goes_on = [self._goes_on(waiting.spoke[group], end) for group in connected]
        still = np.zeros(len(waiting), dtype=np.bool_)
        for group, stays in zip(connected, goes_on, strict=True):
            still[group] = stays
        self._open = waiting.only(still)
        ended = (waiting.only(group) for group, stays in zip(connected, goes_on, strict=True) if not stays)
        return [cluster for cluster in ended if cluster.spoke.min() >= (self._first or 0) + self._rule.spokes]

    def _goes_on(self, spokes: Indices, end: int) -> bool:
        """Whether detections at these spokes (C,) touch the spoke `end`; after a full circle they are cut."""
        return bool(spokes.max() >= end - self._rule.spokes and spokes.min() > end - self._layout.azimuths)
