"""From power to display video: sea control, gain, rain control and quantiser, and fewer bins without loss of a peak.

The order is that of a logarithmic receiver: log detector, sensitivity time control (STC), gain, differentiation (FTC),
quantiser. Functions of arrays; no state: the bytes of a spoke depend on its own cells, the controls and, where these are on, the
spoke before (interference rejection) and the scan before (scan correlation).

Auto sea and auto gain judge a spoke by its own cells: an order statistic of the means of intervals along range, against which
ships are short (Rohling 1983, OS-CFAR).
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from radar_service.display.scan_correlation import excess_db
from radar_service.numerics import Flags, Floats, Profiles, Singles, clutter_level_factor, known_level_factor

AUTO_PFA = 1e-6  # false alarms per cell of noise or exponential clutter under auto gain: one or two in a scan
MARGIN_DB = 10.0 * math.log10(known_level_factor(AUTO_PFA))  # threshold over the mean of exponential power
LEVELS_DB = np.arange(0.0, 50.5, 0.5)  # of clutter and noise over noise, of a table of margins
INTERVAL = 150.0  # m, length of an interval: several waves long, short against the range over which clutter changes
NEAR_INTERVAL = 0.25  # of the range: nearer intervals are shorter, as clutter falls as R^-3 and more
MIN_CELLS = 16  # of an interval
WINDOW = 11  # intervals among which one is judged
# Of their means, from 1 for the weakest, the level: near the mean of spiky clutter too, whose intervals differ by 4 dB. Ships may
# cover the three above.
RANK = 8
MIN_INTERVALS = 4  # of a spoke: in fewer, a target cannot be told from clutter
CEILING_FROM = 400.0  # m; nearer, clutter may still rise with range, as the beam passes above the sea
MAX_RISE_DB = 6.0  # over the minimum level at shorter range: sea clutter falls with range, so that what rises more is land
SEA_SLOPE_DB = 30.0  # per decade: sea clutter falls as R^-3, its cell growing as R (Skolnik 2001, section 7.2)
SEA_RANGE = 50.0  # m; from here on it falls
NEGLIGIBLE = 0.1  # of the noise: weaker clutter counts as none, as the mean of a interval errs by as much
MAX_CLUTTER = 1e30  # of the noise, so that single precision holds it
EMPTY = 1e-6  # of the noise: clutter of a interval whose mean is that of the noise or less
Bytes = NDArray[np.uint8]
Number = TypeVar("Number", bound=np.floating | np.uint8)

DB_PER_STEP = 0.25  # of u8: 255 steps span 64 dB, the contrast of a display, up to a near ship
PFA = 1e-4  # false alarms per cell at gain 50: one or two per spoke, as on a well-adjusted display
MAX_SEA_DB = 60.0  # attenuation of full sea control at SEA_RANGE
STRETCH = 0.01  # of the display range: 3 pixels of a picture of 600
REJECTION = 4.0  # times the power in the spoke before: at a beamwidth of three spokes and more an echo grows by less, but at
# the skirts of the beam; noise before a pulse seldom lets it pass the threshold
FEW_CELLS = 8  # of a bin, up to which a pass for each of them takes 0.2 to 0.4 of the time of `reduceat`
RAIN_LENGTH = 50.0  # m over which rain control averages: long against a buoy, short against a shower


class _Grid(NamedTuple):
    """The intervals of a spoke.

    start, length: (B,) first cell and number of cells.
    falling: (B,) level of clutter that falls as R^-3 [dB].
    near: (B,) intervals without a ceiling.
    before, after: (N,) the intervals around each cell; share: (N,) of the one after.
    """

    start: NDArray[np.intp]
    length: Floats
    falling: Singles
    near: Flags
    before: NDArray[np.intp]
    after: NDArray[np.intp]
    share: Singles


@lru_cache(maxsize=16)
def _grid(cells: int, first: float, step: float) -> _Grid:
    edges = [0]
    while edges[-1] < cells:
        near_interval = NEAR_INTERVAL * (first + edges[-1] * step)
        edges.append(edges[-1] + max(MIN_CELLS, round(min(INTERVAL, near_interval) / step)))
    if len(edges) > 2 and cells - edges[-2] < MIN_CELLS:
        del edges[-2]
    edge = np.minimum(edges, cells)
    length = np.diff(edge)
    middle = edge[:-1] + 0.5 * (length - 1)
    distance = first + middle * step
    falling = (-SEA_SLOPE_DB * np.log10(np.maximum(distance, SEA_RANGE))).astype(np.float32)
    place = np.interp(np.arange(cells), middle, np.arange(len(middle)))
    before = place.astype(np.intp)
    after = np.minimum(before + 1, len(middle) - 1)
    share = (place - before).astype(np.float32)
    return _Grid(edge[:-1], length.astype(np.float64), falling, distance < CEILING_FROM, before, after, share)


def clutter_level(power: Singles, noise_power: float, first: float, step: float) -> Singles:
    """The local mean (K, N) of sea clutter and noise over that of the noise [dB], at least 0; 0 in spokes of few intervals.

    power: (K, N) [W] of cells at first + n step [m]; noise_power: of a cell [W].
    """
    grid = _grid(power.shape[1], first, step)
    if len(grid.start) < MIN_INTERVALS:
        return np.zeros_like(power)
    mean = np.add.reduceat(power, grid.start, axis=1) / (noise_power * grid.length)
    clutter_db = (10.0 * np.log10(np.clip(mean - 1.0, EMPTY, MAX_CLUTTER))).astype(np.float32)
    flat = _ranked(clutter_db - grid.falling)
    ceiling = np.minimum.accumulate(np.where(grid.near, np.float32(np.inf), flat), axis=1) + np.float32(MAX_RISE_DB)
    level = np.minimum(flat, ceiling) + grid.falling
    total = np.float32(1.0 - NEGLIGIBLE) + np.power(np.float32(10.0), level / 10)
    return _at_cells(np.float32(10.0) * np.log10(np.maximum(total, 1)), grid)


def margin_db(level_db: Singles, pulses: int) -> float | Floats:
    """Threshold [dB] over the local mean, which power exceeds with AUTO_PFA; of one pulse the same everywhere.

    level_db: of that mean over the noise, any shape. pulses: over which noise is averaged.
    """
    return MARGIN_DB if pulses == 1 else np.interp(level_db, LEVELS_DB, _margins(pulses))


@lru_cache(maxsize=16)
def _margins(pulses: int) -> Floats:
    clutter = 10.0 ** (LEVELS_DB / 10.0) - 1.0
    return np.array([10.0 * math.log10(clutter_level_factor(AUTO_PFA, each, pulses)) for each in clutter.tolist()])


def _ranked(means: Singles) -> Singles:
    """The value (K, B) of RANK among the WINDOW intervals around each; at the ends, among the WINDOW outermost ones."""
    count = means.shape[1]
    window = min(WINDOW, count)
    ordered = np.sort(sliding_window_view(means, window, axis=1), axis=2)
    first = np.clip(np.arange(count) - window // 2, 0, count - window)
    return ordered[:, first, window * RANK // WINDOW - 1]


def _at_cells(means: Singles, grid: _Grid) -> Singles:
    """Values (K, N) at cells, linear between the middles of intervals (K, B)."""
    before = means[:, grid.before]
    return before + grid.share * (means[:, grid.after] - before)


@dataclass(frozen=True)
class Controls:
    """The controls of a display: gain, sea and rain are 0 to 100 percent each.

    gain: 1 dB per percent around 50, where noise is visible with probability PFA; counts where gain_auto is off.
    sea: 0 is off; counts where sea_auto is off.
    rain: 0 is off.
    gain_auto: the threshold leaves AUTO_PFA of noise, and of what auto sea leaves of clutter.
    sea_auto: the local level of sea clutter is subtracted.
    echo_stretch: 0 to 2; lengthens echoes outward by this many times STRETCH of the display range.
    interference_rejection: a cell counts for at most REJECTION times what the spoke before it has at its range.
    scan_correlation: a cell counts for at most what the scan before has around its place (`scan_correlation`).
    """

    gain: float = 45.0
    sea: float = 0.0
    rain: float = 0.0
    gain_auto: bool = True
    sea_auto: bool = True
    echo_stretch: float = 0.0
    interference_rejection: bool = False
    scan_correlation: bool = False

    def __post_init__(self) -> None:
        for name in ("gain", "sea", "rain"):
            value = getattr(self, name)
            if not 0.0 <= value <= 100.0:
                raise ValueError(f"{name}: {value:g} is not from 0 to 100 percent")
        if not 0.0 <= self.echo_stretch <= 2.0:
            raise ValueError(f"echo_stretch: {self.echo_stretch:g} is not from 0 to 2")


@dataclass(frozen=True)
class Layout:
    """How the first `samples` native cells become `bins`: bin of cell n is floor((n + 1/2) bins / samples).

    native_first: range of cell 0 [m]; native_step: between cells [m]; first and step: the same of the bins.
    pulses: whose powers are averaged in a cell.
    """

    samples: int
    bins: int
    native_first: float
    native_step: float
    pulses: int = 1

    @property
    def step(self) -> float:
        """Length of a bin [m]."""
        return self.native_step * self.samples / self.bins

    @property
    def first(self) -> float:
        """Range of bin 0 [m]: the middle of its cells."""
        return self.native_first + 0.5 * (self.step - self.native_step)

    @property
    def range(self) -> float:
        """Far edge of the last bin [m]."""
        return self.native_first + (self.samples - 0.5) * self.native_step

    @property
    def starts(self) -> NDArray[np.intp]:
        """First cell of each bin (bins,): the minimum n with (n + 1/2) bins >= b samples, in whole numbers."""
        b = np.arange(self.bins, dtype=np.intp)
        return -((self.bins - 2 * b * self.samples) // (2 * self.bins))


def layout(
    cells: int, first: float, step: float, bins: int | None = None, range_max: float | None = None, pulses: int = 1
) -> Layout:
    """The layout of `bins` bins up to range_max [m]; None, or more than there are cells, means one bin per cell.

    first: range of cell 0 [m]; step: between cells [m]. Cells that begin beyond range_max are dropped, except the first.
    pulses: whose powers are averaged in a cell.
    Raises ValueError for fewer than one bin or a range that is not positive.
    """
    if bins is not None and bins < 1:
        raise ValueError(f"bins: {bins} is not a whole number from 1 up")
    if range_max is not None and not range_max > 0:
        raise ValueError(f"range: {range_max:g} m is not above 0")
    samples = cells
    if range_max is not None:
        near_edge = first - 0.5 * step
        samples = min(cells, max(1, math.ceil((range_max - near_edge) / step - 1e-9)))
    return Layout(samples, samples if bins is None else min(bins, samples), first, step, pulses)


def peaks(values: NDArray[Number], to: Layout) -> NDArray[Number]:
    """The maximum of the cells (K, N) in each bin (K, bins)."""
    samples = values[:, : to.samples]
    if to.bins == to.samples:
        return samples
    starts = to.starts
    longest = -(-to.samples // to.bins)  # cells of a bin
    if longest > FEW_CELLS:
        return np.maximum.reduceat(samples, starts, axis=1)
    lasts = np.append(starts[1:], to.samples) - 1
    highest = samples[:, starts]
    for later in range(1, longest):
        np.maximum(highest, samples[:, np.minimum(starts + later, lasts)], out=highest)
    return highest


def strongest(field: Profiles, to: Layout) -> Profiles:
    """The sample of maximum magnitude in each bin (K, bins) of a field (K, N); the first one where several are equal."""
    samples = field[:, : to.samples]
    if to.bins == to.samples:
        return samples
    edges = np.append(to.starts, to.samples)
    longest = int(np.diff(edges).max())
    cells = np.minimum(edges[:-1, None] + np.arange(longest), edges[1:, None] - 1)
    groups = samples[:, cells]
    pick = np.argmax(groups.real**2 + groups.imag**2, axis=2)
    return np.take_along_axis(groups, pick[..., None], axis=2)[..., 0]


def decibels(power: Singles) -> Singles:
    """10 log10 of power [W], -inf where it is 0; float32 [dBW]."""
    with np.errstate(divide="ignore"):
        return np.float32(10.0) * np.log10(power)


def noise_threshold_db(noise_power: float, pulses: int = 1) -> float:
    """Level [dBW] that noise of mean power [W], averaged over so many pulses, exceeds with probability PFA."""
    return 10.0 * math.log10(noise_power * known_level_factor(PFA, pulses))


def sea_attenuation_db(distance: Floats, sea: float) -> Floats:
    """Attenuation [dB] of sea control (STC) at slant ranges [m]: 0.6 dB per percent up to SEA_RANGE, then -30 dB per decade."""
    decades = np.log10(np.maximum(distance, SEA_RANGE) / SEA_RANGE)
    return np.maximum(MAX_SEA_DB * sea / 100.0 - SEA_SLOPE_DB * decades, 0.0)


def rain_level_db(video_db: Singles, step: float, rain: float) -> Singles:
    """Level [dB] that rain control (FTC) subtracts: a share of the mean log video of the cells before each cell.

    video_db: (K, N) [dB above the threshold; below counts as 0]; step: range step [m]. Cell 0 has none before it.
    """
    length = max(1, round(RAIN_LENGTH / step))
    total = np.cumsum(np.maximum(video_db, 0.0), axis=1, dtype=np.float64)
    before = np.concatenate([np.zeros_like(total[:, :1]), total[:, :-1]], axis=1)
    ends = np.arange(video_db.shape[1])
    begins = np.maximum(ends - length, 0)
    window = before - before[:, begins]
    level: Singles = (rain / 100.0 * window / np.maximum(ends - begins, 1)).astype(np.float32)
    return level


def without_interference(power: Singles, before: Singles | None) -> Singles:
    """Cells (K, N) [W], each limited to REJECTION times that at its range in the spoke before.

    Pulses of another radar come at other times after each own pulse, so that they meet the same range in one spoke alone.
    before: (N,) cells of the spoke before the first one; None: it is not known, and the first spoke keeps its cells.
    """
    previous = np.concatenate([power[:1] if before is None else before[None], power[:-1]])
    return np.minimum(power, np.float32(REJECTION) * previous)


def stretched(video_db: Singles, cells: int) -> Singles:
    """Video (K, N) [dB] in which each cell has the maximum of itself and the `cells` before it."""
    longer, length = video_db.copy(), 1
    while length <= cells:  # each cell has the maximum of `length` cells
        step = min(length, cells + 1 - length)
        longer[:, step:] = np.maximum(longer[:, step:], longer[:, :-step])
        length += step
    return longer


def display_video(
    power: Singles, to: Layout, controls: Controls, noise_power: float, before: Singles | None = None,
    earlier: Singles | None = None,
) -> Bytes:  # fmt: skip
    """Video bytes (K, bins) of cells (K, N) [W]: 0 is below the threshold, b > 0 is b - 1 to b steps above it.

    By hand, the threshold before the controls is noise_threshold_db, and gain raises the video by 1 dB per percent over 50.
    before: see `without_interference`, which alone uses it. earlier: (K, N) [W] by
    `ScanMemory.take`, None where it is not known; scan correlation alone uses it. It lowers cells, and no level that is
    subtracted, so it makes no cell stronger.
    """
    video, cells = video_level_db(power, to, controls, noise_power, before, earlier), stretch_cells(to, controls)
    return quantise(peaks(stretched(video, cells) if cells else video, to), -0.5 * DB_PER_STEP, DB_PER_STEP)


def video_level_db(
    power: Singles, to: Layout, controls: Controls, noise_power: float, before: Singles | None, earlier: Singles | None
) -> Singles:
    """Level (K, samples) of the shown cells of (K, N) [W] above the threshold [dB], before echo stretch; as `display_video`."""
    if controls.interference_rejection:
        power = without_interference(power, before)
    cells = power[:, : to.samples]
    level = np.zeros((1, 1), dtype=np.float32)
    if controls.sea_auto:  # of all cells, so that a change of range changes no level
        level = clutter_level(power, noise_power, to.native_first, to.native_step)[:, : to.samples]
    threshold: float | Floats = noise_threshold_db(noise_power, to.pulses) - (controls.gain - 50.0)
    if controls.gain_auto:
        threshold = 10.0 * math.log10(noise_power) + margin_db(level, to.pulses)
    video = decibels(cells) - np.asarray(threshold, dtype=np.float32)
    if controls.sea_auto:
        video -= level
    elif controls.sea > 0:
        distance: Floats = to.native_first + to.native_step * np.arange(to.samples, dtype=np.float64)
        video -= sea_attenuation_db(distance, controls.sea).astype(np.float32)
    if controls.rain > 0:
        video -= rain_level_db(video, to.native_step, controls.rain)
    if controls.scan_correlation and earlier is not None:
        video -= excess_db(cells, earlier[:, : to.samples])
    return video


def stretch_cells(to: Layout, controls: Controls) -> int:
    """How many cells echo stretch lengthens an echo by."""
    return math.ceil(STRETCH * controls.echo_stretch * to.samples)


def quantise(level_db: NDArray[np.floating], offset_db: float, db_per_step: float) -> Bytes:
    """Bytes b = (level - offset) / step, all in dB, rounded to the nearest and clipped to 0 to 255."""
    steps = (level_db - np.float32(offset_db)) * np.float32(1.0 / db_per_step)
    clipped: Bytes = np.rint(np.clip(steps, 0.0, 255.0)).astype(np.uint8)
    return clipped
