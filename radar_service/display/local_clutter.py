"""The level of clutter along a spoke, for auto sea and auto gain: a threshold of constant false alarm rate (CFAR).

Each spoke is judged by its own cells. It is cut into intervals along range; each has a mean power. An order statistic of the
means of the intervals around it is the level of a interval: ships are short against them and do not raise it (Rohling 1983,
OS-CFAR).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from radar_service.numerics.gamma_law import clutter_level_factor, known_level_factor
from radar_service.numerics.types import Flags, Floats, Singles

AUTO_PFA = 1e-6  # false alarms per cell of noise or exponential clutter under auto gain: one or two in a scan
MARGIN_DB = 10.0 * math.log10(known_level_factor(AUTO_PFA))  # threshold over the mean of exponential power
LEVELS_DB = np.arange(0.0, 50.5, 0.5)  # of clutter and noise over noise, of a table of margins
INTERVAL = 150.0  # m, length of a interval: several waves long, short against the range over which clutter changes
NEAR_INTERVAL = 0.25  # of the range: nearer intervals are shorter, as clutter falls as R^-3 and more
MIN_CELLS = 16  # of a interval
WINDOW = 11  # intervals among which one is judged
RANK = (
    8  # of their means, from 1 for the weakest, is the level: near the mean of spiky clutter too, whose intervals differ by
)
# 4 dB. Ships may cover the three above
MIN_INTERVALS = 4  # of a spoke: in fewer, a target cannot be told from clutter
CEILING_FROM = 400.0  # m; nearer, clutter may still rise with range, as the beam passes above the sea
MAX_RISE_DB = 6.0  # over the minimum level at shorter range: sea clutter falls with range, so that what rises more is land
SEA_SLOPE_DB = 30.0  # per decade: sea clutter falls as R^-3, its cell growing as R (Skolnik 2001, section 7.2)
SEA_RANGE = 50.0  # m; from here on it falls
NEGLIGIBLE = 0.1  # of the noise: weaker clutter counts as none, as the mean of a interval errs by as much
MAX_CLUTTER = 1e30  # of the noise, so that single precision holds it
EMPTY = 1e-6  # of the noise: clutter of a interval whose mean is that of the noise or less


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
