"""Receiver noise through the whole video chain: as often over the threshold as the gain says."""

from typing import Any

import numpy as np
import pytest
import scipy.stats

import radar_service as rs
from radar_service.display.video import AUTO_PFA, MARGIN_DB, PFA, Controls, display_video, layout, margin_db
from radar_service.numerics.gamma_law import known_level_factor
from tests.scenes import averaging, scene

NOISE: dict[str, dict[str, Any]] = {"environment": {"noise": True}, "radar": {"range_max_m": 3000, "azimuths": 720}}


RADARS: dict[str, dict[str, Any]] = {
    "hamming": {},
    "blackman": {"window": "blackman"},
    "unweighted": {"window": "none"},
    "5 pulses": averaging(NOISE["radar"], 5),
    "10 pulses": averaging(NOISE["radar"], 10),
    "plain pulse": {"modulation": "none", "pulse_s": 0.25e-6, "sample_rate_hz": 8e6, "range_max_m": 9000},
}


@pytest.mark.parametrize("name", RADARS)
def test_noise_lights_one_cell_in_ten_thousand_at_gain_50(name: str) -> None:
    """At gain 50 a byte is not 0 where power exceeds its threshold, of one pulse ln(1/1e-4) times its mean (the very edge:
    test_video.py). 4 scans; 5 sigma of a Poisson count of clumps of three neighbours."""
    radar = NOISE["radar"] | RADARS[name]
    sim = rs.Simulator(scene([], environment=NOISE["environment"], radar=radar), seed=1)
    cells = layout(len(sim.range), float(sim.range[0]), sim.range_step, pulses=sim.scene.radar.pulses_integrated)
    lit = total = 0
    for _ in range(4):
        video = display_video(sim.scan().power, cells, Controls(gain=50.0, gain_auto=False, sea_auto=False), sim.noise_power)
        lit, total = lit + int(np.count_nonzero(video)), total + video.size
    expected = total * PFA
    assert lit == pytest.approx(expected, abs=5 * np.sqrt(3 * expected))


@pytest.mark.parametrize("pulses", [1, 5, 10])
def test_auto_gain_begins_where_noise_of_its_pulses_has_its_rate(pulses: int) -> None:
    """To 0.01 dB, with auto sea and without: 6.3 dB lower for 10 pulses. In strong clutter it is the margin of one pulse."""
    edge = known_level_factor(AUTO_PFA, pulses) * 10.0 ** np.array([-0.001, 0.001])
    power, cells = np.ones((1, 600), np.float32), layout(600, 5.0, 10.0, pulses=pulses)
    power[0, [300, 301]] = edge
    for sea in (True, False):
        assert display_video(power, cells, Controls(sea_auto=sea), 1.0)[0, 300:302].tolist() == [0, 1]
    assert margin_db(np.array(40.0, np.float32), pulses) == pytest.approx(MARGIN_DB, abs=0.01)


@pytest.mark.parametrize("gain", [42.0, 45.0, 55.0])
def test_gain_shifts_the_threshold_by_its_decibels(gain: float) -> None:
    """Pfa(gain) = Pfa^(10^((50 - gain) / 10))."""
    sim = rs.Simulator(scene([], **NOISE), seed=2)
    cells = layout(len(sim.range), float(sim.range[0]), sim.range_step)
    video = display_video(sim.scan().power, cells, Controls(gain=gain, gain_auto=False, sea_auto=False), sim.noise_power)
    expected = video.size * PFA ** (10 ** ((50 - gain) / 10))
    assert np.count_nonzero(video) == pytest.approx(expected, abs=5 * np.sqrt(3 * expected) + 1)


def test_noise_power_is_exponential_with_the_stated_mean() -> None:
    """Every 6th bin of three scans: Kolmogorov-Smirnov at 1e-4 against the exponential law of sim.noise_power."""
    sim = rs.Simulator(scene([], **NOISE), seed=3)
    power = np.concatenate([sim.scan().power[:, ::6].ravel() for _ in range(3)]) / sim.noise_power
    assert scipy.stats.kstest(power, "expon").pvalue > 1e-4
