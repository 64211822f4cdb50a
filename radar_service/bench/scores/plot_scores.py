"""How well plots follow the truth: which targets have one in each scan, false plots, and errors in range and bearing."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.scores.set_scores import mean
from radar_service.numerics import wrap_angle
from radar_service.plots import Plot

GATE = 15.0  # m: a plot of a point is no farther from it in range, nor across it ...
GATE_BEARING = 0.01  # rad ... or within this angle, at long range; both with half the length of an extended target
SHARE_OF_SCAN = 0.25  # the beam meets the plot of a crossing within this share of a scan of it


class PlotMatch(NamedTuple):
    """A target's crossing with its plot: error of the range [m] and of the bearing [rad] against where its power lies."""

    truth: TargetTruth
    plot: Plot
    range_error: float
    bearing_error: float


def matches(results: Sequence[ScanResult]) -> list[list[PlotMatch]]:
    """Returns the matches of each scan: one to one, the sum of distances the least. A plot may come a scan later."""
    period = results[0].given.time / (results[0].given.scan + 1) if results else 0.0
    every = [[], *(list(result.given.plots) for result in results), []]
    near = (before + now + after for before, now, after in zip(every, every[1:], every[2:], strict=False))
    return [_matched(result, plots, SHARE_OF_SCAN * period) for result, plots in zip(results, near, strict=True)]


def plot_metrics(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """Returns the metrics of plots by name; None where there is nothing to judge.

    The first scan does not count: a plot that the start of the run cuts is left out.
    """
    matched, truths = matches(results)[1:], [result.truths for result in results[1:]]
    seen = [{truth.body for truth in some if truth.echo} for some in truths]
    detected = [{match.truth.body for match in some} for some in matched]
    shares = {body: _share(body, seen, detected) for body in sorted(set().union(*seen))}
    plots = sum(len(result.given.plots) for result in results[1:])
    return {
        "detected": mean(list(shares.values())), "detected_worst": min(shares.values(), default=None),
        "resolved": mean([float(present == bodies) for present, bodies in zip(detected, seen, strict=True) if bodies]),
        "false_plots": (plots - sum(map(len, matched))) / len(matched) if matched else None,
        **_errors([match for some in matched for match in some]),
    }  # fmt: skip


def _share(body: str, seen: Sequence[set[str]], detected: Sequence[set[str]]) -> float:
    """The share of a target's crossings that have a plot."""
    return sum(body in some for some in detected) / sum(body in some for some in seen)


def _errors(matched: Sequence[PlotMatch]) -> dict[str, float | None]:
    """Mean and standard deviation of the errors."""
    distance, bearing = [match.range_error for match in matched], [np.degrees(match.bearing_error) for match in matched]
    return {
        "range_bias_m": mean(distance), "range_sd_m": _spread(distance),
        "bearing_bias_deg": mean(bearing), "bearing_sd_deg": _spread(bearing),
    }  # fmt: skip


def _spread(values: Sequence[float]) -> float | None:
    return float(np.std(values, ddof=1)) if len(values) > 1 else None


def _matched(result: ScanResult, plots: Sequence[Plot], near: float) -> list[PlotMatch]:
    """The matches of one scan. near: how long a plot may be from its crossing [s]."""
    truths = [truth for truth in result.truths if truth.echo]
    rows = [(*truth.echo, truth.length / 2.0, truth.time) for truth in truths if truth.echo]
    distance, bearing, half, time = np.reshape(rows, (-1, 4, 1)).swapaxes(0, 1)
    plot = np.reshape([(plot.range, plot.bearing, plot.time) for plot in plots], (-1, 3)).T
    range_error, bearing_error = plot[0] - distance, wrap_angle(plot[1] - bearing)
    along = abs(range_error) / (GATE + half)
    across = distance * abs(bearing_error) / (np.maximum(GATE, GATE_BEARING * distance) + half)
    inside = (abs(plot[2] - time) <= near) & (along <= 1.0) & (across <= 1.0)
    cost = np.where(inside, np.hypot(along, across) / np.sqrt(2.0), 1.0)  # share of the gate
    return [
        PlotMatch(truths[i], plots[j], float(range_error[i, j]), float(bearing_error[i, j]))
        for i, j in zip(*(each.tolist() for each in linear_sum_assignment(cost)), strict=True)
        if cost[i, j] < 1.0
    ]
