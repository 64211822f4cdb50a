"""The threshold of a ship's radar in clutter: interference rejection, integration over the beam, STC, and a CA-CFAR whose
multiplier follows the local shape of the clutter.

Each scan is judged by its own cells alone. Correlation from scan to scan is a tag of plots, and never a gate.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from radar_service.display.video import REJECTION
from radar_service.numerics import Flags, Floats, Indices, Singles
from radar_service.plots.false_alarms import (
    CLUTTER_TO_NOISE,
    TAILS,
    effective_looks,
    speckle_factor,
    spread_and_factor,
)
from radar_service.plots.thresholds import (
    MIN_CELLS,
    CellAveraging,
    KnownThreshold,
    OrderedStatistic,
    Threshold,
    check_lengths,
    check_pfa,
)
from radar_service.radar import Radar
from radar_service.receive import receiver_noise_power
from radar_service.scans import Scan
from radar_service.trace import WATER, LandMask

PFA = 5e-6  # false alarms per cell: some 3 plots in the cells of the sea of a scan
SECTORS = 16  # in which the shape is measured: the sea along the waves is spikier than across
GROWTH = 1.35  # of the regions in range, as sea clutter changes with the logarithm of range
REGION_CELLS = 24, 256  # of a region along range, at least and at most
EVERY = 2  # spokes: their median over azimuth is the STC's curve
STC_SAMPLES = 33  # of the curve along range, whose median it is
NOISE_SPREAD = 0.08  # ln: how much interference rejection and reference cells widen noise, and a standard error of a region
BEYOND = 3.0  # independent cells of a region beyond the quantile that tells its shape
FAINT = 0.1  # of the receiver's noise: 1 - exp(-0.1) of the cells of noise are fainter, of several looks fewer
BESIDE_LAND = 2  # cells along range: a pulse is some two cells long
AT_PLACE = 1.0  # m that own ship moves before land is looked up again
LOCAL, LOCAL_SECTORS = 32.0, 64  # times the curve: more than waves and directions of a sea; narrower than a rain cell
AVERAGED_BEAMS = 5, 20  # half-power beams to each side: at a shape of 0.5 and 1e-4, 28 cells lose 2.0 dB, 280 cells 0.2 dB
DEVIATIONS = 3.0  # standard deviations of one beam's level from the sides', as they scatter at its range
MAD = np.float32(1.4826)  # of a Gaussian, standard deviation over the median of absolute deviations
MEAN_RATIO = 1.806  # of the sides, above which clutter is not uniform (Smith and Varshney, IEEE T-AES 36(3), 837, 2000)
BESIDE_BEAMS = 2  # half-power beams to each side: an edge along the beam is shorter in range than the guard
LIMIT = 8.0  # times that curve, at which a reference cell counts at most: a ship among them raises the level little


@dataclass(frozen=True)
class MarineThreshold:
    """The threshold of a ship's radar in sea, rain and land. Cells that are NaN, such as land, have no part in any level.

    radar: whose spokes they are.
    pfa: probability of false alarm per cell of noise or clutter.
    guard: length on each side of a cell that is left out [m].
    window: length on each side that counts [m].
    """

    radar: Radar
    pfa: float = PFA
    guard: float = 100.0
    window: float = 300.0

    def __post_init__(self) -> None:
        check_pfa(self.pfa)
        check_lengths(self.guard, self.window)

    def of(self, power: Singles) -> Floats:
        """Returns thresholds (A, N) [W] of power (A, N) [W] of all spokes of a scan, from north.

        A cell exceeds its own exactly where its integral over the beam exceeds the level.
        """
        integral = self._integrated(_without_interference(power) if self._spokes > 1 else power)
        noise = np.float32(receiver_noise_power(self.radar))
        if (power[::EVERY] < FAINT * noise).mean() > FAINT:  # a scene without noise
            np.maximum(integral, noise, out=integral)
        curve = _stc(integral, self.window / self.radar.range_step)
        flat = integral / curve
        level = self._averaged(flat)
        with np.errstate(divide="ignore", invalid="ignore"):  # cells without any power
            flat /= level
            level *= curve
            clutter = level / noise - 1.0
            factor = np.maximum(self._factors(flat, clutter), self._speckle_factors(clutter))
            factor *= power
            factor /= flat
        return factor

    @cached_property
    def _spokes(self) -> int:
        """Spokes within the half-power beam, an odd number."""
        return 2 * int(self.radar.beamwidth / 2.0 / self.radar.azimuth_step) + 1

    def _integrated(self, power: Singles) -> Singles:
        """The mean over the beam. The first spokes of a scan follow its last ones: a target there has moved by one scan."""
        total = power.copy()
        for apart in range(1, self._spokes // 2 + 1):
            total += np.roll(power, apart, axis=0)
            total += np.roll(power, -apart, axis=0)
        total /= np.float32(self._spokes)
        return total

    def _averaged(self, flat: Singles) -> Singles:
        """The mean (A, N) of the reference cells on both sides and of the beams beside; near an end, of those that there are.

        Where the beams of the two sides differ, as at a shadow's edge, fewer beams, or those of its own beam alone. In and
        beside local clutter, the mean of the greater side (GO-CFAR: Hansen and Sawyers, IEEE T-AES 16(1), 115, 1980), and the
        greatest of the beams beside.
        """
        count = flat.shape[1]
        guard = max(1, min(round(self.guard / self.radar.range_step), count // 8))
        side = max(MIN_CELLS, min(round(self.window / self.radar.range_step), count // 4))
        known = ~np.isnan(flat)
        cell = np.arange(count)
        edges = [np.clip(cell + offset, 0, count) for offset in (-guard - side, -guard, guard + 1, guard + 1 + side)]

        def beside(values: Singles) -> tuple[Singles, Singles]:
            total = np.zeros((len(values), count + 1), dtype=np.float32)
            np.cumsum(values, axis=1, out=total[:, 1:])
            low, near, far, high = (total[:, edge] for edge in edges)
            return near - low, high - far

        local = _local(flat)
        totals = beside(np.where(known, np.minimum(flat, np.float32(LIMIT) * local), np.float32(0.0)))
        cells = beside(known.astype(np.float32)) if not known.all() else beside(np.ones((1, count), dtype=np.float32))
        both = cells[0] + cells[1]
        level: Singles = np.divide(totals[0] + totals[1], both, out=np.ones_like(flat), where=both > 0.0)
        broad = self._over_beams(level, totals[0] + totals[1], both)
        if not (local > 1.0).any():
            return broad
        for total, few in zip(totals, cells, strict=True):
            np.maximum(level, total / np.maximum(few, np.float32(1.0)), out=level, where=local > 1.0)
        beside_beam = 2 * BESIDE_BEAMS * self._spokes + 1
        return np.where(local > 1.0, maximum_filter1d(level, beside_beam, axis=0, mode="wrap"), broad)

    def _over_beams(self, level: Singles, total: Singles, cells: Singles) -> Singles:
        """The mean over the widest sides that are alike (A, N); the own beam's level (A, N) where above by more than its scatter.

        total, cells: of each beam's reference cells, sum (A, N) and number (A or 1, N).
        """
        broad = level
        for beams in AVERAGED_BEAMS:
            spokes = max(1, min(beams * self._spokes, len(level) // SECTORS))
            sums, counts = (uniform_filter1d(each, spokes, axis=0, mode="wrap") for each in (total, cells))
            mean = np.divide(sums, counts, out=np.full_like(level, np.nan), where=counts > 0.0)
            left, right = (np.roll(mean, turn, axis=0) for turn in (spokes // 2 + 1, -spokes // 2 - 1))
            both = 0.5 * (left + right)
            most = _scatter(level, both)
            alike = (np.maximum(left, right) <= MEAN_RATIO * np.minimum(left, right)) & (level <= most * both)
            broad = np.where(alike, np.minimum(both, most * level), broad)
        return broad

    def _factors(self, ratio: Singles, clutter: Singles) -> Floats:
        """The factor (A, N) on the level of each cell, from the spread of ratios to the level in the regions about it.

        ratio: of power to the level (A, N); clutter: of the level to noise (A, N), less 1.
        """
        edges = _regions(ratio.shape[1])
        shape = SECTORS, len(edges) - 1
        measured = np.full(shape, np.nan)
        for sector, rows in enumerate(np.array_split(np.arange(len(ratio)), SECTORS)):
            for k, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
                part = slice(rows[0], rows[-1] + 1), slice(low, high)
                cells = ratio[part].ravel()
                cells = cells[cells > 0.0]  # no NaN
                if len(cells) >= REGION_CELLS[0]:
                    measured[sector, k] = self._log_factor(cells, float(np.nanmean(clutter[part])))
        known = np.isfinite(measured)
        measured = np.where(known, measured, np.median(measured[known]) if known.any() else 0.0)
        around = np.pad(np.pad(measured, ((2, 2), (0, 0)), "wrap"), ((0, 0), (1, 1)), "edge")
        measured = np.median(
            sliding_window_view(around, (5, 3)), axis=(2, 3)
        )  # ships fill regions, the sea their neighbours
        return np.exp(_at_cells(measured, edges, len(ratio)))

    def _speckle_factors(self, clutter: Singles) -> Singles:
        """The factor (A, N) on the level of clutter without texture, which a region of little clutter has too few looks of."""
        pulses = self.radar.pulses_integrated
        ratios = CLUTTER_TO_NOISE / pulses
        factors = speckle_factor(ratios, self._spokes * pulses, effective_looks(self.radar, self._spokes), self.pfa)
        decade = np.log10(np.maximum(clutter, np.float32(ratios[0])))
        return np.interp(decade, np.log10(ratios), factors).astype(np.float32)

    def _log_factor(self, cells: Singles, clutter: float) -> float:
        """The logarithm of the factor for the ratios (C,) of a region; clutter: to noise, in the mean."""
        pulses = self.radar.pulses_integrated
        spread, factor = spread_and_factor(self._spokes, effective_looks(self.radar, self._spokes), self.pfa, pulses)
        deep = int(np.argmin(np.abs(np.log(TAILS * len(cells) / self._spokes / BEYOND))))
        places = [len(cells) // 2, int((1.0 - TAILS[deep]) * len(cells))]
        median, tail = np.log(np.partition(cells, places)[places])
        ratios = CLUTTER_TO_NOISE / pulses
        ratio = max(clutter, ratios[0])
        row = int(np.abs(np.log(ratios / ratio)).argmin())
        wider = NOISE_SPREAD / pulses**0.5 / (1.0 + ratio)
        return float(median + np.interp(tail - median - wider, spread[deep, row], factor[row]) + wider)


def threshold(kind: str, radar: Radar, pfa: float, guard: float, window: float) -> Threshold:
    """Returns a threshold by name: known, ca, os or marine. guard, window: lengths [m] as of the last three."""
    if kind == "known":
        return KnownThreshold(radar, pfa)
    makers: dict[str, Callable[[Radar, float, float, float], Threshold]]
    makers = {"ca": CellAveraging, "os": OrderedStatistic, "marine": MarineThreshold}
    return makers[kind](radar, pfa, guard, window)


class LandCells:
    """The cells of a radar's scans that land covers, where a ship's radar has no plots; kept while own ship stays where it is."""

    def __init__(self, land: LandMask, radar: Radar) -> None:
        self._land, self._beam = land, int(np.ceil(radar.beamwidth / radar.azimuth_step))
        self._position: Floats = np.full((1, 2), np.inf)
        self._cells: Flags = np.zeros((0, 0), dtype=np.bool_)

    def without(self, scan: Scan) -> Singles:
        """Returns the power (A, N) [W] of a scan with NaN in the cells of land."""
        position = np.nan_to_num(scan.position)
        if self._cells.shape != scan.power.shape or not np.abs(position - self._position).max() <= AT_PLACE:
            self._position, self._cells = position, self._covered(scan, position)
        return np.where(self._cells, np.float32(np.nan), scan.power)

    def _covered(self, scan: Scan, position: Floats) -> Flags:
        """Which cells (A, N) are land, or within a beamwidth and BESIDE_LAND of it."""
        azimuth = np.nan_to_num(scan.azimuth)[:, None]
        east, north = (position[:, axis, None] + scan.range * way(azimuth) for axis, way in enumerate((np.sin, np.cos)))
        cells = self._land.material.ravel()[self._land.at(east, north)] != WATER
        beside = maximum_filter1d(cells.view(np.uint8), 2 * BESIDE_LAND + 1, axis=1, mode="nearest")
        return maximum_filter1d(beside, 2 * self._beam + 1, axis=0, mode="wrap").view(np.bool_)


def _without_interference(power: Singles) -> Singles:
    """Cells (A, N), each limited to REJECTION times the stronger of its two neighbours in azimuth; a pulse of another radar meets
    its range in one spoke alone."""
    beside = np.fmax(np.roll(power, 1, axis=0), np.roll(power, -1, axis=0))
    beside *= np.float32(REJECTION)
    return np.minimum(power, beside)


def _scatter(level: Singles, mean: Floats) -> Singles:
    """Returns ratios (N,) within which single beams lie about a mean: DEVIATIONS of the turn's; a sector has too few beams."""
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.sort(np.abs(np.log(level[::EVERY] / mean[::EVERY])), axis=0)  # NaN last
    middle = np.count_nonzero(~np.isnan(apart), axis=0) // 2, np.arange(apart.shape[1])
    return np.asarray(np.fmax(np.exp(DEVIATIONS * MAD * apart[middle]), MEAN_RATIO), dtype=np.float32)


def _stc(power: Singles, window: float) -> Singles:
    """The curve (N,) of sensitivity time control [W]: the median over azimuth, then the interquartile mean along range.

    window: cells to each side at most; near own ship, as far as clutter changes little (GROWTH).
    """
    rows = power[::EVERY]
    few = np.flatnonzero(np.isnan(rows).any(axis=0))
    middle = np.median(rows, axis=0)
    middle[few] = [
        float(np.median(each[~np.isnan(each)])) if not np.isnan(each).all() else np.nan for each in rows[:, few].T
    ]
    good = np.flatnonzero(~np.isnan(middle))
    if not len(good):
        return np.zeros_like(middle)
    cell = np.arange(len(middle))
    curve = np.interp(cell, good, middle[good])
    reach = np.minimum(np.minimum(window, (GROWTH - 1.0) * cell), cell[::-1])
    beside = np.rint(cell[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, STC_SAMPLES)).astype(np.int64)
    quarter = STC_SAMPLES // 4
    return np.asarray(np.sort(curve[beside], axis=1)[:, quarter:-quarter].mean(axis=1), dtype=np.float32)


def _local(flat: Singles) -> Singles:
    """What local clutter, as a rain cell, is times the curve (A, N): its median in small sectors of regions, and beside these;
    1 below LOCAL."""
    edges, sectors = _regions(flat.shape[1]), np.array_split(np.arange(len(flat)), LOCAL_SECTORS)
    parts = [[flat[rows, low:high] for low, high in zip(edges[:-1], edges[1:], strict=True)] for rows in sectors]
    medians = np.array([[np.median(part[part > 0.0]) if (part > 0.0).any() else 0.0 for part in row] for row in parts])
    raised = maximum_filter1d(np.where(medians > LOCAL, medians, 1.0), 3, axis=0, mode="wrap")
    raised = maximum_filter1d(raised, 3, axis=1, mode="nearest").astype(np.float32)
    return np.asarray(raised.repeat([len(rows) for rows in sectors], axis=0).repeat(np.diff(edges), axis=1))


def _regions(count: int) -> Indices:
    """First cells (K + 1,) of regions along range, and the end."""
    least, most = REGION_CELLS
    edges = [0]
    while edges[-1] < count:
        edges.append(edges[-1] + int(np.clip((GROWTH - 1.0) * edges[-1], least, most)))
    return np.minimum(edges if len(edges) < 3 or count - edges[-2] >= least else [*edges[:-2], count], count)


def _at_cells(values: Floats, edges: Indices, spokes: int) -> Floats:
    """Values (spokes, N) at cells, linear between the middles of regions (SECTORS, K)."""
    cell = np.arange(edges[-1])
    middle = 0.5 * (edges[:-1] + edges[1:] - 1)
    along = np.array([np.interp(cell, middle, row) for row in values])
    place = (np.arange(spokes) + 0.5) * SECTORS / spokes - 0.5
    first = np.floor(place).astype(np.int64)
    share = (place - first)[:, None]
    return np.asarray((1.0 - share) * along[first % SECTORS] + share * along[(first + 1) % SECTORS], dtype=np.float32)
