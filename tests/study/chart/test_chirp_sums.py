"""Chirp sums: they agree where theory says that they do."""

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.numerics.types import Floats
from radar_service.radar.parameters import Radar
from radar_service.receive.chirp_sum import chirp_sum, impulse_sum
from radar_service.study.chart.chirp_sums import chirp_sums, chirps, exact_chirps
from tests.scenes import radar
from tests.study.chart.settings import SMALL

SPOKES = np.arange(8, 20)
SMALL_RADAR = radar(**SMALL)


def echoes_at(radar: Radar, steps: Floats) -> Echoes:
    """Returns two echoes at ranges (2,) [range steps], 45 and 70 degrees from north."""
    return Echoes(steps * radar.range_step, np.deg2rad([45.0, 70.0]), np.array([1.0, 0.5j]))


def gain(offset: Floats) -> Floats:
    return SMALL_RADAR.pattern.gain(offset, SMALL_RADAR.beamwidth)


def test_impulses_and_chirps_with_rounded_delays_are_the_same_sum() -> None:
    """Convolution is linear. Both round to complex64, 1e-6 of the peak."""
    echoes, reach = echoes_at(SMALL_RADAR, np.array([200.3, 410.8])), np.pi
    one, other = (chirps(SMALL_RADAR, reach, gain, add)(echoes, SPOKES) for add in (chirp_sum, impulse_sum))
    assert np.abs(one).max() > 0.3 and np.abs(one - other).max() < 1e-6


def test_exact_delays_change_nothing_for_echoes_on_samples() -> None:
    """An echo on a sample has no delay to round; between two samples the two sums differ by several per cent."""
    for steps, differs in ((np.array([200.0, 410.0]), False), (np.array([200.4, 410.6]), True)):
        echoes = echoes_at(SMALL_RADAR, steps)
        rounded = chirps(SMALL_RADAR, np.pi, gain, chirp_sum)(echoes, SPOKES)
        exact = exact_chirps(SMALL_RADAR, np.pi, gain)(echoes, SPOKES)
        assert (np.abs(rounded - exact).max() > 0.03) == differs


def test_the_documented_preset_is_the_printed_beam() -> None:
    assert [m.setting for m in chirp_sums(SMALL_RADAR) if m.preset == "documented"] == ["printed beam"]
