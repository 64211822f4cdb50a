"""Second-time-around echoes: a target at R > Ru is received at R - n Ru, Ru the unambiguous range (Skolnik 2001, ch. 1).

The transmitter keeps its phase from pulse to pulse. A magnetron does not: it would give such echoes a random phase.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radar_service.echo.echoes import SECOND_TIME, AzimuthTimes, BeamWeightedEchoes
from radar_service.numerics import SPEED_OF_LIGHT, Floats
from radar_service.radar import Radar

MARGIN = 10.0  # m: nothing moves farther within a pulse repetition interval


def max_echo_range(radar: Radar) -> float:
    """Range [m] beyond which no echo is received; inf where second-time-around echoes are modelled."""
    return np.inf if radar.second_time_around else max_apparent_range(radar)


def max_apparent_range(radar: Radar) -> float:
    """Apparent range [m] of the last echoes whose range sidelobes, cT/2 long, reach a bin."""
    return radar.range_max + radar.blind_range


def apparent_range(radar: Radar, distance: Floats) -> Floats:
    """Range [m] at which echoes from `distance` (any shape) [m] appear: R - n Ru; R where only the first pulse counts."""
    if not radar.second_time_around:
        return distance
    return np.asarray(distance % radar.unambiguous_range)


def fold_ranges(
    echoes_at: Callable[[AzimuthTimes], BeamWeightedEchoes], azimuths: AzimuthTimes, radar: Radar
) -> list[BeamWeightedEchoes]:
    """Echoes received at these azimuths at their apparent ranges, a record for each pulse that is n intervals old.

    echoes_at: the echoes at the instants at which a pulse was transmitted.
    """
    if not radar.second_time_around:
        return [echoes_at(azimuths)]
    echoes = echoes_at(azimuths)
    oldest = int((echoes.range.max(initial=0.0) + MARGIN) // radar.unambiguous_range)
    parts = [_of_pulse(echoes, 0, radar)]
    for n in range(1, oldest + 1):
        transmitted = replace(azimuths, time=azimuths.time - n * 2.0 * radar.unambiguous_range / SPEED_OF_LIGHT)
        parts.append(_of_pulse(echoes_at(transmitted), n, radar))
    return parts


def _of_pulse(echoes: BeamWeightedEchoes, n: int, radar: Radar) -> BeamWeightedEchoes:
    """The echoes of the pulse n intervals ago, at their apparent ranges."""
    apparent = echoes.range - n * radar.unambiguous_range
    received = np.flatnonzero((apparent >= 0) & (apparent < min(radar.unambiguous_range, max_apparent_range(radar))))
    body = echoes.body[received] if n == 0 else np.full(len(received), SECOND_TIME)
    return BeamWeightedEchoes(apparent[received], echoes.range_migration[received], echoes.amplitude[received], body)
