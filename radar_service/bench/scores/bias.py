"""Whether a feed is biased in range or in bearing, by how much, and what in the feed may be the cause."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from radar_service.bench.scores.plot_scores import matches
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.numerics import Floats

ROUNDING = 1e-9  # m or rad: plots are no surer
SURE = 4.0  # standard errors: a bias of none exceeds them in one of 15 000 runs


@dataclass(frozen=True)
class Bias:
    """The mean of errors. value, error: mean and its standard error, [m] or [rad]; count: number of plots."""

    value: float
    error: float
    count: int

    @property
    def is_sure(self) -> bool:
        """Whether it exceeds SURE times its standard error."""
        return abs(self.value) > SURE * self.error


@dataclass(frozen=True)
class BiasCause:
    """What explains biases of feeds with different cells.

    constant: the same in all feeds, as of a gyro or of a delay, [m] or [rad]. cells: in proportion to the cell, as a number of
    cells: 0.5 for an azimuth that is the start of a spoke, or a range that is the start of a bin. constant_error, cells_error:
    standard errors.
    """

    constant: float
    constant_error: float
    cells: float
    cells_error: float


def range_and_bearing_bias(results: Sequence[ScanResult]) -> tuple[Bias, Bias]:
    """Returns the biases of range [m] and bearing [rad] of the plots of a run against where the power of their targets lies.

    Raises ValueError for fewer than two plots of targets.
    """
    errors = np.array([(match.range_error, match.bearing_error) for scan in matches(results) for match in scan])
    if len(errors) < 2:
        raise ValueError(f"results: {len(errors)} plots of targets are too few for a bias; 2 or more, best 100")
    return _bias(errors[:, 0]), _bias(errors[:, 1])


def bias_cause(biases: Mapping[float, Bias]) -> BiasCause:
    """Returns what a bias consists of, from feeds that differ in their cells alone: by the width of a spoke [rad] for a bearing,
    by the length of a bin [m] for a range.

    Raises ValueError for fewer than two widths: a single feed cannot tell half a spoke from an error of the gyro.
    """
    if len(biases) < 2:
        raise ValueError(f"biases: {len(biases)} width of cells is not allowed; 2 or more tell a spoke from a gyro")
    cell = np.array(list(biases))
    error = np.array([max(bias.error, ROUNDING) for bias in biases.values()])
    design = np.stack([np.ones_like(cell), cell], axis=1) / error[:, None]
    covariance = np.linalg.inv(design.T @ design)
    constant, cells = covariance @ design.T @ (np.array([bias.value for bias in biases.values()]) / error)
    spread = np.sqrt(np.diag(covariance))
    return BiasCause(float(constant), float(spread[0]), float(cells), float(spread[1]))


def _bias(errors: Floats) -> Bias:
    return Bias(float(errors.mean()), float(errors.std(ddof=1) / np.sqrt(len(errors))), len(errors))
