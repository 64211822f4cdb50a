"""Plots told apart by the labels of their cells: which source each is of, and how likely each kind of source is detected.

A cell's label is its strongest source (docs/truth.md). Cells labelled as noise or clutter that exceed the threshold are false
alarms. A plot is of the source that gives most of its power.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, get_args

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.plots.detections import Detections
from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.flood import Flood, flood_remark
from radar_service.plots.plot import Plot
from radar_service.records import Crossing
from radar_service.scans import Scan
from radar_service.simulator import Simulator
from radar_service.sources.numbers import (
    BODY,
    FAINT,
    LAND,
    NOISE,
    SECOND_TIME_AROUND,
)
from radar_service.stages.effect import Kind
from radar_service.stages.registry import numbered_sources
from radar_service.world import Body, Scene

KINDS: tuple[Kind, ...] = get_args(Kind)
COMMON_KINDS: dict[int, Kind] = {  # what comes from an earlier pulse disturbs as clutter does
    NOISE: "noise", SECOND_TIME_AROUND: "clutter", FAINT: "clutter",
}  # fmt: skip
SCHEMA = 1
Progress = Callable[[Iterable[Scan], int], Iterable[Scan]]


@dataclass(frozen=True)
class LabelledPlot:
    """A plot with its source. label, source, kind: of the source; share: of it in the power of the plot's cells."""

    plot: Plot
    label: int
    source: str
    kind: Kind
    share: float

    def as_dict(self) -> dict[str, Any]:
        """Plain data: that of the plot, and `source`, `kind` and `share`."""
        return {**self.plot.as_dict(), "source": self.source, "kind": self.kind, "share": self.share}


@dataclass(frozen=True)
class KindCount:
    """One kind of source in all scans.

    kind: which.
    cells: number of cells that are labelled so.
    detected: number of these that exceed the threshold.
    share: detected over cells: Pd of cells with echoes, Pfa of those with clutter, interference or noise. None without cells.
    plots: number of plots.
    plots_per_scan: their mean.
    """

    kind: Kind
    cells: int
    detected: int
    share: float | None
    plots: int
    plots_per_scan: float


@dataclass(frozen=True)
class BodyCount:
    """One body that is no land.

    name, kind: of the body. range: mean over its crossings [m], None without any.
    crossings: how often the beam crossed it. with_cells: how often it was the strongest source of any cell then.
    with_plot: how often a plot was of it. pd: with_plot over with_cells; None where it never had a cell.
    """

    name: str
    kind: Kind
    range: float | None
    crossings: int
    with_cells: int
    with_plot: int
    pd: float | None


@dataclass(frozen=True)
class PlotReport:
    """What the labels say of the plots of consecutive scans.

    scene, seed, fidelity: of the simulator. scans: their number. kinds: all, in the order of KINDS. bodies: those that are no
    land. plots: by scan. last: the last of the scans. remark: what to set against a flood, None as a rule.
    """

    scene: str
    seed: int
    fidelity: str
    scans: int
    kinds: tuple[KindCount, ...]
    bodies: tuple[BodyCount, ...]
    plots: tuple[LabelledPlot, ...]
    last: Scan = field(compare=False)
    remark: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data, without the scan."""
        tables = {"kinds": [*map(asdict, self.kinds)], "bodies": [*map(asdict, self.bodies)]}
        about = {"schema": SCHEMA, "scene": self.scene, "seed": self.seed, "fidelity": self.fidelity, "scans": self.scans}
        return {**about, "remark": self.remark, **tables, "plots": [plot.as_dict() for plot in self.plots]}


def kind_of(body: Body, scene: Scene) -> Kind:
    """Returns the kind of a body that is no land: as its AIS says; without it a vessel and what moves is a ship, else a buoy."""
    kind = next((ship.kind for ship in scene.ais.ships if ship.body == body.name), None)
    is_ship = body.is_vessel or not body.motion.at_rest if kind is None else kind == "ship"
    return "ship" if is_ship else "buoy"


def kinds_of(scene: Scene, labels: Sequence[int]) -> dict[int, Kind]:
    """Returns the kind of source of each label."""
    return {label: _kind(scene, label) for label in labels}


def _kind(scene: Scene, label: int) -> Kind:
    if label >= BODY:
        return kind_of(scene.bodies[label - BODY], scene)
    if label in (sources := numbered_sources(scene)):
        return sources[label][1].kind
    return "land" if label >= LAND else COMMON_KINDS[label]


def labelled_plots(
    simulator: Simulator, extractor: PlotExtractor, scans: int, progress: Progress = lambda scans, count: scans
) -> PlotReport:
    """Returns what the labels say of the plots of so many scans of a simulator with labels.

    Two more scans are computed: the first and the last one have cut plots, and do not count. extractor: a new one. progress:
    wraps the scans, of which it gets the number. Raises ValueError for a simulator without labels, or less than one scan.
    """
    if scans < 1:
        raise ValueError(f"scans: {scans} is not allowed; 1 or more, best 10")
    count = _Counting(simulator, extractor)
    for scan in progress((simulator.scan() for _ in range(scans + 2)), scans + 2):
        count.add(scan)
    return count.report()


class _Counting:
    """Counts cells, plots and crossings scan by scan."""

    def __init__(self, simulator: Simulator, extractor: PlotExtractor) -> None:
        self._simulator, self._extractor = simulator, extractor
        self._names = simulator.label_names
        self._kinds = kinds_of(simulator.scene, [*self._names])
        self._size = max(self._names) + 1
        self._labels: dict[int, Indices] = {}  # of the last two scans, by number
        self._plots: list[LabelledPlot] = []
        self._crossings: list[Crossing] = []
        self._cells: list[Indices] = []  # (2, size) cells and detected cells of each scan, by label
        self._spokes: list[Indices] = []  # (S, 2) spoke and label of all bodies with cells
        self._scan: list[Scan] = []  # the last two
        self._floods: list[Flood] = []

    def add(self, scan: Scan) -> None:
        """Counts one scan."""
        if scan.labels is None:
            raise ValueError("simulator: it gives no labels; make it with labels=True")
        labels = scan.labels.astype(np.int64)
        self._labels = {**dict(list(self._labels.items())[-1:]), scan.number: labels}
        self._scan = [*self._scan[-1:], scan]
        ended = self._extractor.add(scan)
        detected = labels[ended.detections.spoke - scan.number * len(labels), ended.detections.cell]
        self._cells.append(np.stack([np.bincount(which, minlength=self._size) for which in (labels.ravel(), detected)]))
        rows, columns = np.nonzero(labels >= BODY)
        self._spokes.append(np.unique(np.stack([scan.number * len(labels) + rows, labels[rows, columns]], axis=1), axis=0))
        self._crossings += self._simulator.crossings(scan.number)
        self._floods += [ended.flood] if ended.flood else []
        self._plots += self._labelled(ended.plots, ended.cells)

    def _labelled(self, plots: Sequence[Plot], cells: Detections) -> Iterator[LabelledPlot]:
        scan, row = np.divmod(cells.spoke, self._simulator.scene.radar.azimuths)
        label = np.zeros(len(cells), dtype=np.int64)
        for number, labels in self._labels.items():
            there = scan == number
            label[there] = labels[row[there], cells.cell[there]]
        cell = np.repeat(np.arange(len(plots)), [plot.cells for plot in plots]) * self._size + label
        power = np.bincount(cell, weights=cells.power, minlength=len(plots) * self._size).reshape(-1, self._size)
        best = power.argmax(axis=1)
        shares = power[np.arange(len(plots)), best] / power.sum(axis=1)
        for plot, number, share in zip(plots, best.tolist(), shares.tolist(), strict=True):
            yield LabelledPlot(plot, number, self._names[number], self._kinds[number], share)

    def report(self) -> PlotReport:
        """Returns the counts of all scans but the first and the last one."""
        simulator, numbers = self._simulator, range(self._scan[-1].number + 2 - len(self._cells), self._scan[-1].number)
        plots = [labelled for labelled in self._plots if labelled.plot.scan in numbers]
        cells = np.sum(self._cells[1:-1], axis=0)
        return PlotReport(
            simulator.scene.name, simulator.seed, simulator.fidelity.name, len(numbers),
            tuple(self._kind_count(kind, cells, plots, len(numbers)) for kind in KINDS),
            tuple(self._body_count(body, label, numbers) for label, body in self._bodies().items()),
            tuple(plots), self._scan[0], flood_remark(self._floods, len(self._cells)),
        )  # fmt: skip

    def _kind_count(self, kind: Kind, cells: Indices, plots: Sequence[LabelledPlot], scans: int) -> KindCount:
        labels = [label for label, kind_then in self._kinds.items() if kind_then == kind]
        total, detected = (int(some[labels].sum()) for some in cells)
        count = sum(labelled.kind == kind for labelled in plots)
        return KindCount(kind, total, detected, detected / total if total else None, count, count / scans)

    def _bodies(self) -> Mapping[int, Body]:
        return {label: self._simulator.scene.bodies[label - BODY] for label in self._names if label >= BODY}

    def _body_count(self, body: Body, label: int, scans: range) -> BodyCount:
        """A plot or a cell belongs to the crossing within half a rotation."""
        scene = self._simulator.scene
        radar = scene.radar
        crossings = [crossing for crossing in self._crossings if crossing.body == body.name and crossing.scan in scans]
        spokes = np.concatenate([some[some[:, 1] == label, 0] for some in self._spokes])
        times = np.sort([labelled.plot.time for labelled in self._plots if labelled.label == label])
        has_cells = [2 * _nearest(spokes, crossing.spoke) < radar.azimuths for crossing in crossings]
        has_plot = [2.0 * _nearest(times, crossing.time) < radar.rotation_period for crossing in crossings]
        there, plotted = sum(has_cells), sum(has_plot)
        return BodyCount(
            body.name, kind_of(body, scene), float(np.mean([crossing.range for crossing in crossings])) if crossings else None,
            len(crossings), there, plotted, plotted / there if there else None,
        )  # fmt: skip


def _nearest(values: Sequence[float] | Floats | Indices, value: float) -> float:
    """The distance of a value from the nearest of rising ones (K,); inf without any."""
    at = int(np.searchsorted(values, value))
    return float(min((abs(candidate - value) for candidate in values[max(at - 1, 0) : at + 1]), default=np.inf))
