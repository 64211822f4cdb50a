"""Echoes of earlier pulses: what comes from beyond the unambiguous range appears nearer, by the way of whole intervals.

The transmitter keeps its phase from pulse to pulse (a magnetron, which does not, would give such echoes a random one).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.echo.moving import AzimuthTimes
from radar_service.echo.range_history import BeamWeightedEchoes
from radar_service.radar.parameters import Radar

Floats = NDArray[np.float64]
MARGIN = 10.0  # m: more than anything moves within an interval


def echo_reach(radar: Radar) -> float:
    """Range [m] from which echoes, or their sidelobes, are heard; inf where those of earlier pulses are."""
    return np.inf if radar.second_time_around else heard_reach(radar)


def heard_reach(radar: Radar) -> float:
    """Apparent range [m] of the last echoes whose sidelobes, cT/2 long, still reach a bin."""
    return radar.range_max + radar.blind_range


def apparent_range(radar: Radar, distance: Floats) -> Floats:
    """Where echoes from `distance` [m] appear: R - n c / (2 prf), n whole intervals late; R without second-time echoes."""
    if not radar.second_time_around:
        return distance
    return np.asarray(distance % radar.unambiguous_range)


def fold_ranges(
    sweep: Callable[[AzimuthTimes], BeamWeightedEchoes], at: AzimuthTimes, radar: Radar
) -> list[BeamWeightedEchoes]:
    """The echoes heard at these instants, at apparent ranges, each as `sweep` has it when its own pulse was sent."""
    if not radar.second_time_around:
        return [sweep(at)]
    echoes = sweep(at)
    late = int((echoes.range.max(initial=0.0) + MARGIN) // radar.unambiguous_range)
    parts = [_of_interval(echoes, 0, radar)]
    for n in range(1, late + 1):
        sent = replace(at, time=at.time - n * 2.0 * radar.unambiguous_range / SPEED_OF_LIGHT)
        parts.append(_of_interval(sweep(sent), n, radar))
    return parts


def _of_interval(echoes: BeamWeightedEchoes, n: int, radar: Radar) -> BeamWeightedEchoes:
    apparent = echoes.range - n * radar.unambiguous_range
    mine = np.flatnonzero((apparent >= 0) & (apparent < min(radar.unambiguous_range, heard_reach(radar))))
    return BeamWeightedEchoes(apparent[mine], echoes.range_migration[mine], echoes.amplitude[mine])
