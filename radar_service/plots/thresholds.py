"""Detection thresholds: a known noise level, and detectors of constant false alarm rate (CFAR) along range."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from radar_service.numerics import Complexes, Floats, Indices, Singles, known_level_factor
from radar_service.plots.false_alarms import cell_averaging_factor, noise_correlation, ordered_statistic_factor
from radar_service.radar import Radar
from radar_service.receive import receiver_noise_power

PFA = 1e-4  # false alarms per cell, as MSC.192(79) 5.3.1.1 asks
RANK = 0.75  # of the reference cells, as Rohling chose
MIN_CELLS = 4  # reference cells on each side
ROWS = 64  # spokes that an ordered statistic sorts at once


class Threshold(Protocol):
    """Decides what power a cell must exceed to be a detection."""

    def of(self, power: Singles) -> Floats:
        """Returns thresholds [W] that broadcast to power (K, N) [W] of K spokes."""


@dataclass(frozen=True)
class KnownThreshold:
    """The threshold over receiver noise of known power, the same for all cells.

    radar: whose receiver it is. pfa: probability of false alarm per cell of noise.
    """

    radar: Radar
    pfa: float = PFA

    def __post_init__(self) -> None:
        check_pfa(self.pfa)

    def of(self, power: Singles) -> Floats:
        """Returns thresholds, as Threshold.of."""
        return np.full((1, 1), receiver_noise_power(self.radar) * known_level_factor(self.pfa, self.radar.pulses_integrated))


Window = tuple[int, int]  # first offset from the cell under test, and number of cells


@dataclass(frozen=True)
class _AlongRange(ABC):
    """A level from reference cells on both sides of the cell under test, beyond guard cells; near an end, from one side alone.

    radar: whose receiver noise it is.
    pfa: probability of false alarm per cell of noise.
    guard: length on each side that is left out [m]: longer than the targets.
    window: length on each side that counts [m].
    """

    radar: Radar
    pfa: float = PFA
    guard: float = 60.0
    window: float = 200.0

    def __post_init__(self) -> None:
        check_pfa(self.pfa)
        check_lengths(self.guard, self.window)

    def of(self, power: Singles) -> Floats:
        """Returns thresholds, as Threshold.of. Raises ValueError where a spoke is shorter than all windows."""
        cells, guard, side = power.shape[1], *self._cells
        edge = guard + side
        if cells < 2 * edge + side:
            raise ValueError(
                f"window: guards and windows of {self.guard:g} and {self.window:g} m need {2 * edge + side} cells; spokes have "
                f"{cells}: set a shorter guard or window"
            )
        both_sides, one_side = self._factors
        near = self._level(power, 0, edge, [(guard + 1, 2 * side)])
        middle = self._level(power, edge, cells - edge, [(-edge, side), (guard + 1, side)])
        far = self._level(power, cells - edge, cells, [(-guard - 2 * side, 2 * side)])
        return np.concatenate([one_side * near, both_sides * middle, one_side * far], axis=1)

    @property
    def _cells(self) -> tuple[int, int]:
        """Guard and reference cells on each side."""
        step = self.radar.range_step
        return max(1, round(self.guard / step)), max(MIN_CELLS, round(self.window / step))

    @cached_property
    def _factors(self) -> tuple[float, float]:
        """The factor with cells on both sides, and that with as many on one side."""
        guard, side = self._cells
        right = guard + 1 + np.arange(2 * side)
        both = np.concatenate([-right[:side][::-1], right[:side]])
        correlation = noise_correlation(self.radar, 2 * (guard + side) + 1)
        return self._factor(both, correlation), self._factor(right, correlation)

    @abstractmethod
    def _factor(self, offsets: Indices, correlation: Complexes) -> float:
        """The factor on the level of reference cells at these offsets."""

    @abstractmethod
    def _level(self, power: Singles, first: int, stop: int, windows: Sequence[Window]) -> Floats:
        """Levels (K, stop - first) [W] of cells under test `first` to `stop`, from their windows."""


class CellAveraging(_AlongRange):
    """CA-CFAR: the mean of the reference cells (Finn and Johnson 1968)."""

    def _factor(self, offsets: Indices, correlation: Complexes) -> float:
        return cell_averaging_factor(self.pfa, offsets, correlation, self.radar.pulses_integrated)

    def _level(self, power: Singles, first: int, stop: int, windows: Sequence[Window]) -> Floats:
        total = np.zeros((len(power), power.shape[1] + 1))
        np.cumsum(power, axis=1, dtype=np.float64, out=total[:, 1:])
        level = np.zeros((len(power), stop - first))
        for offset, count in windows:
            level += total[:, first + offset + count : stop + offset + count] - total[:, first + offset : stop + offset]
        level /= sum(count for _, count in windows)
        return level


class OrderedStatistic(_AlongRange):
    """OS-CFAR: the value of rank RANK among the reference cells; other targets among them raise it little (Rohling 1983)."""

    def _factor(self, offsets: Indices, correlation: Complexes) -> float:
        rank, pulses = self._rank(len(offsets)), self.radar.pulses_integrated
        return ordered_statistic_factor(self.pfa, rank, offsets, correlation, pulses)

    def _level(self, power: Singles, first: int, stop: int, windows: Sequence[Window]) -> Floats:
        rank = self._rank(sum(count for _, count in windows)) - 1
        parts = []
        for start in range(0, len(power), ROWS):
            rows = power[start : start + ROWS]
            views = [sliding_window_view(rows, n, axis=1)[:, first + offset : stop + offset] for offset, n in windows]
            parts.append(np.partition(np.concatenate(views, axis=2), rank, axis=2)[:, :, rank])
        return np.concatenate(parts).astype(np.float64)

    @staticmethod
    def _rank(count: int) -> int:
        return max(1, round(RANK * count))


def check_pfa(pfa: float) -> None:
    """Raises ValueError unless it is a probability."""
    if not 0.0 < pfa < 1.0:
        raise ValueError(f"pfa: {pfa} is not allowed; a probability between 0 and 1, as 1e-4")


def check_lengths(guard: float, window: float) -> None:
    """Raises ValueError unless both are lengths [m]."""
    for name, value in (("guard", guard), ("window", window)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name}: {value} is not allowed; a length above 0 m, as 60")
