"""Records of a seaway: waves travel at their phase velocity, and add up; wave heights and periods by sea state."""

import numpy as np

from radar_service.world.seaway import PEAK_PERIOD, SIGNIFICANT_WAVE_HEIGHT, Waves

G = 9.80665
FREQUENCY = np.array([0.5, 0.9, 1.7])
DIRECTION = np.array([[0.6, 0.8], [-1.0, 0.0], [0.28, -0.96]])
WAVES = Waves(
    np.array([1.0, 0.5, 0.2]), FREQUENCY, (FREQUENCY**2 / G)[:, None] * DIRECTION, FREQUENCY, np.array([0.1, 2.0, 4.0])
)
PLACE = np.array([[300.0, -800.0]])


def test_a_crest_goes_on_at_its_phase_velocity() -> None:
    """The sea is one for all places: what a wave has here, it has at c t farther on."""
    time = np.array([50.0])
    for n in range(3):
        moved = PLACE + G / FREQUENCY[n] * time * DIRECTION[n]
        here, there = WAVES.phases(PLACE, np.zeros(1))[0, n], WAVES.phases(moved, time)[0, n]
        np.testing.assert_allclose(there, here, atol=1e-9)


def test_the_elevation_is_the_sum_of_the_waves() -> None:
    east, north, time = 300.0, -800.0, 123.4
    k = FREQUENCY**2 / G
    expected = sum(
        a * np.cos(k[n] * (east * DIRECTION[n, 0] + north * DIRECTION[n, 1]) - FREQUENCY[n] * time + WAVES.phase[n])
        for n, a in enumerate([1.0, 0.5, 0.2])
    )
    np.testing.assert_allclose(WAVES.elevation(PLACE, np.array([time])), expected, atol=1e-12)


def test_higher_seas_have_longer_waves() -> None:
    assert len(PEAK_PERIOD) == len(SIGNIFICANT_WAVE_HEIGHT) == 10
    assert (np.diff(PEAK_PERIOD) >= 0.0).all() and (np.diff(SIGNIFICANT_WAVE_HEIGHT) > 0.0).all()
