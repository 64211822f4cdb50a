"""Errors of plots on purpose, for points: a tracker that is judged by perfect plots needs no filter.

Meshes and hulls have such errors from the engine, so plots of extended targets stay as they are.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radar_service.bench.scenario import PlotErrors
from radar_service.bench.scores.scan_result import TargetTruth, as_reported
from radar_service.numerics.frames import wrap_bearing
from radar_service.numerics.random import PLOT_ERRORS, generator
from radar_service.plots.plot import Plot

NEAR = 50.0  # m: a plot within half the length of an extended target and this is hers


def with_errors(
    plots: Sequence[Plot], truths: Sequence[TargetTruth], errors: PlotErrors | None, seed: int, scan: int
) -> tuple[Plot, ...]:
    """Returns the plots of a scan with errors in range and bearing, but for those of extended targets.

    errors: None for none. Each scan of a seed has draws of its own, in the order of its plots.
    """
    if errors is None:
        return tuple(plots)
    draws = generator(seed, PLOT_ERRORS, scan).standard_normal((len(plots), 2))
    extended = [as_reported(truth) for truth in truths if truth.length]
    return tuple(
        plot
        if _is_of(plot, extended)
        else _moved(plot, along * errors.range_sd_m, np.radians(across * errors.bearing_sd_deg))
        for plot, (along, across) in zip(plots, draws.tolist(), strict=True)
    )


def _is_of(plot: Plot, extended: Sequence[TargetTruth]) -> bool:
    return any(
        np.hypot(plot.east - truth.position[0], plot.north - truth.position[1]) < truth.length / 2.0 + NEAR
        for truth in extended
    )


def _moved(plot: Plot, along: float, turn: float) -> Plot:
    """A plot that is farther by a range [m] and turned about the antenna by an angle [rad]."""
    own_east, own_north = plot.east - plot.range * np.sin(plot.bearing), plot.north - plot.range * np.cos(plot.bearing)
    distance, bearing = max(plot.range + along, 0.0), float(wrap_bearing(np.asarray(plot.bearing + turn)))
    return replace(
        plot, range=distance, bearing=bearing, east=float(own_east + distance * np.sin(bearing)),
        north=float(own_north + distance * np.cos(bearing)),
    )  # fmt: skip
