"""The plot extractor: from scans to plots, across north.

The gate about the peak of a plot is that in which the truth measures where the power of a ship lies (docs/truth.md).
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from radar_service.numerics import Flags, Indices
from radar_service.plots.clusters import ClusterRule, clusters, parts
from radar_service.plots.detections import Detections, detections_of, no_detections
from radar_service.plots.flood import Flood, FloodWarning, flood_of
from radar_service.plots.groups import Groups
from radar_service.plots.marine import LandCells, MarineThreshold
from radar_service.plots.plot import Plot, ScanGeometry, ScanTags, plot_columns, plots_of
from radar_service.plots.sidelobes import SidelobeGate
from radar_service.plots.thresholds import KnownThreshold, Threshold
from radar_service.radar import Radar
from radar_service.receive import receiver_noise_power
from radar_service.records import SpokeBlock
from radar_service.scans import Scan, scan_of
from radar_service.trace import LandMask
from radar_service.world import Scene, is_land

NEIGHBOURS = ClusterRule(1, 1)  # over corners too, as in the truth
MARGIN_DB = 3.0  # over the sidelobes of a point at rest: those of moving and of several scatterers are stronger


def about_peak(detections: Detections, part: Indices, gate_db: float) -> Flags:
    """Returns which detections (C,) are within `gate_db` of the strongest of their part, and connect with it.

    part: the number (C,) of the part of each detection, from 0.
    """
    if not len(detections):
        return np.empty(0, dtype=np.bool_)
    groups = Groups(part)
    peak = groups.strongest(detections.power)[groups.of_each]
    strong = detections.power >= detections.power[peak] * 10.0 ** (-gate_db / 10.0)
    apart = (np.ptp(detections.spoke) + 2) * groups.of_each  # parts of one cluster may touch; here no two do
    label = np.full(len(part), -1, dtype=np.int64)
    label[strong] = clusters(replace(detections, spoke=detections.spoke + apart).only(strong), NEIGHBOURS)
    return np.asarray(label == label[peak], dtype=np.bool_)


@dataclass(frozen=True)
class ScanPlots:
    """The plots that ended in one scan.

    scan: its number.
    plots: by time.
    sidelobes: number of plots that the sidelobe gate removed.
    dropped: number of plots beyond the maximum, the weakest.
    flood: too many detections in this scan, and the remedy; None as a rule.
    cells: the detections of the plots, one plot after the other.
    detections: all of the scan.
    """

    scan: int
    plots: tuple[Plot, ...]
    sidelobes: int
    dropped: int
    flood: Flood | None = None
    cells: Detections = field(default_factory=no_detections, compare=False, repr=False)
    detections: Detections = field(default_factory=no_detections, compare=False, repr=False)


def in_clutter(scene: Scene) -> bool:
    """Returns whether a scene has sea, rain or land."""
    environment = scene.environment
    return bool(environment.sea_state or environment.rain_mm_h or environment.attenuators or any(map(is_land, scene.bodies)))


class PlotExtractor:
    """Turns the scans of one radar into plots.

    A cluster that touches the end of a scan is finished with the next one. One that touches the very first spoke is cut, and
    gives no plot; neither does one that touches the end of the last scan. The first scan with a flood gives a FloodWarning.
    """

    def __init__(
        self, radar: Radar, threshold: Threshold | None = None, *, rule: ClusterRule | None = None, max_plots: int = 200,
        sidelobe_margin_db: float | None = MARGIN_DB, nearest: float = 0.0, gate_db: float = np.inf,
        tell: Callable[[str], None] | None = None, land: LandMask | None = None,
    ) -> None:  # fmt: skip
        """threshold: by default the known noise with PFA; max_plots: per scan; sidelobe_margin_db: None for no sidelobe gate;
        nearest: plots nearer than this [m] are left out, such as sea clutter about own ship; gate_db: cells count that connect
        with the peak of a plot and are this much weaker at most: 20 is the gate of the truth; tell: gets the first flood in
        words, in place of a FloodWarning; land: where a MarineThreshold has no plots, with a beamwidth about it.

        Raises ValueError for a maximum below 1.
        """
        if max_plots < 1:
            raise ValueError(f"max_plots: {max_plots} is not allowed; 1 or more, best 20 to 200")
        self.threshold: Threshold = threshold or KnownThreshold(radar)
        self._rule, self._max_plots, self._nearest = rule or ClusterRule(), max_plots, nearest
        self._gate_db = gate_db
        self._gate = None if sidelobe_margin_db is None else SidelobeGate(radar, sidelobe_margin_db)
        self._geometry = ScanGeometry(radar.azimuths, 0.5 * radar.range_step, radar.range_step, receiver_noise_power(radar))
        self._before = no_detections()  # in the scan before
        self._open = np.zeros(0, dtype=np.bool_)  # which of these are of clusters that may go on
        self._warned, self._tell = False, tell
        self._first: int | None = None  # spoke of the first scan
        marine = isinstance(self.threshold, MarineThreshold)
        self._land = LandCells(land, radar) if land is not None and marine else None
        self._tags = ScanTags(radar) if marine else None

    @classmethod
    def for_scene(cls, scene: Scene, pfa: float | None = None, **settings: Any) -> "PlotExtractor":
        """Returns that of a ship's radar where a scene has sea, rain or land, and else that of the known noise.

        pfa: None for the default of the threshold. settings: as of the constructor.
        """
        make = MarineThreshold if in_clutter(scene) else KnownThreshold
        threshold = make(scene.radar) if pfa is None else make(scene.radar, pfa)
        return cls(scene.radar, threshold, land=LandMask.of(scene.bodies), **settings)

    def scans(self, scans: Iterable[Scan]) -> Iterator[ScanPlots]:
        """Yields the plots of consecutive scans."""
        return map(self.add, scans)

    def add(self, scan: Scan) -> ScanPlots:
        """Returns the plots that end in a scan, which follows the one before. Missing spokes (NaN) hold no detections."""
        power = scan.power if self._land is None else self._land.without(scan)
        return self.add_detections(
            scan.number, detections_of(scan, self.threshold.of(power)), scan.power.size, scan.range[0]
        )

    def add_detections(self, number: int, fresh: Detections, size: int, first: float) -> ScanPlots:
        """Returns the plots that end in the scan of a number, which follows the one before, from its detections.

        size: number of its cells; first: range of its first samples [m].
        """
        if self._first is None:
            self._first = number * self._geometry.azimuths
        recent = self._before.and_then(fresh)
        cells, plot = self._ended(recent, (number + 1) * self._geometry.azimuths)
        geometry = replace(self._geometry, first=float(first))  # where the feed says that samples stand
        groups = Groups(plot)
        of_plots = recent.only(cells)
        columns = plot_columns(of_plots, groups, geometry)
        peak = cells[groups.strongest(of_plots.power)]
        explained = self._explained(recent, peak, cells, groups)
        kept = np.flatnonzero(~explained & (columns["range"] >= self._nearest))
        best = kept[np.argsort(-recent.power[peak[kept]], kind="stable")[: self._max_plots]]
        best = best[np.argsort(columns["time"][best], kind="stable")]
        dropped = len(kept) - len(best)
        flood = flood_of(number, len(fresh), size, len(best), dropped, self.threshold, self._nearest)
        self._warn(flood)
        plots = tuple(plots_of(columns, best))
        return ScanPlots(
            number, plots if self._tags is None else self._tags.of(plots), int(explained.sum()), dropped, flood,
            of_plots.only(groups.members(best)), fresh,
        )  # fmt: skip

    def _warn(self, flood: Flood | None) -> None:
        if flood and not self._warned:
            self._warned = True
            if self._tell is None:
                warnings.warn(str(flood), FloodWarning, stacklevel=4)
            else:
                self._tell(str(flood))

    def _explained(self, recent: Detections, peak: Indices, cells: Indices, groups: Groups) -> Flags:
        """Which plots (P,) are sidelobes. peak: their strongest detections; cells: all of theirs, in groups."""
        if self._gate is None:
            return np.zeros(len(peak), dtype=np.bool_)
        plot = np.full(len(recent), -1, dtype=np.int64)
        plot[cells] = groups.of_each
        return self._gate.sidelobes(recent, peak, plot)

    def _ended(self, recent: Detections, end: int) -> tuple[Indices, Indices]:
        """Detections (K,) of clusters that ended before spoke `end`, and the numbers of their parts, which rise; others wait.

        recent: those of the last scan and of this one. Clusters that the start cut are left out.
        """
        old = len(self._open)
        waiting = np.concatenate([np.flatnonzero(self._open), np.arange(old, len(recent))])
        cluster = clusters(recent.only(waiting), self._rule)
        groups = Groups(cluster)
        first, last = groups.minimum(recent.spoke[waiting]), groups.maximum(recent.spoke[waiting])
        goes_on = (last >= end - self._rule.spokes) & (
            first > end - self._geometry.azimuths
        )  # after a full circle they are cut
        still = np.zeros(len(recent), dtype=np.bool_)
        still[waiting] = goes_on[groups.of_each]
        self._before, self._open = recent.only(slice(old, None)), still[old:]
        ended = (~goes_on & (first >= (self._first or 0) + self._rule.spokes))[groups.of_each]
        cells, part = waiting[ended], parts(recent.only(waiting[ended]), cluster[ended], self._rule)
        if not np.isinf(self._gate_db):
            near = about_peak(recent.only(cells), part, self._gate_db)
            cells, part = cells[near], part[near]
        order = np.argsort(part, kind="stable")
        return cells[order], part[order]


Extract = Callable[[Scan], Sequence[Plot]]  # from a scan, plots that ended in it or in earlier ones


class LivePlots:
    """The plots of spokes as they come, at the end of each scan. After half a scan without spokes it begins anew."""

    def __init__(self, azimuths: int, begun: Callable[[], Extract], note_lost: Callable[[int], None]) -> None:
        """azimuths: of a scan; begun: returns what extracts, with no scan before; note_lost: counts spokes whose numbers do not
        rise, or whose heading is lost."""
        self._azimuths, self._begun, self._note_lost, self._extract = azimuths, begun, note_lost, begun()
        self._parts, self._last = list[SpokeBlock](), -1

    def add(self, block: SpokeBlock) -> list[Plot]:
        """Returns the plots of the scans that end with a block, by time."""
        if block.first <= self._last:
            self._note_lost(len(block))
            return []
        if block.first - self._last > self._azimuths // 2:
            self._parts, self._extract = [], self._begun()
        self._last = block.first + len(block) - 1
        if (unknown := np.isnan(block.heading)).any():
            self._note_lost(int(unknown.sum()))
            block = replace(block, power=np.where(unknown[:, None], np.float32(np.nan), block.power))
        ended = self._ended() if self._parts and self._parts[0].scan != block.scan else []
        self._parts.append(block)
        return ended + (self._ended() if block.index + len(block) == self._azimuths else [])

    def _ended(self) -> list[Plot]:
        parts, self._parts = self._parts, []
        return list(self._extract(scan_of(parts, self._azimuths)))
