"""Records of a seaway: waves travel at their phase velocity, and add up; wave heights and periods by sea state."""

import numpy as np
import pytest

from radar_service.world.seaway import Waves, sea_state_of, significant_wave_height, wind_speed

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


@pytest.mark.parametrize(
    ("state", "height", "wind"), [(1, 0.14, 3.16), (3, 1.04, 7.61), (5, 2.98, 11.45), (2.5, 0.72, 6.58)]
)
def test_one_table_of_sea_states_by_hand(state: float, height: float, wind: float) -> None:
    """0.04 + 0.1 s^2.1 m, as the NRL report prints them: 0.14, 0.47, 1.04, 1.88, 2.98, 4.35; 3.16 s^0.8 m/s; and back."""
    assert significant_wave_height(state) == pytest.approx(height, abs=5e-3)
    assert wind_speed(state) == pytest.approx(wind, abs=5e-3)
    assert sea_state_of(significant_wave_height(state)) == pytest.approx(state, rel=1e-12)


def test_sea_states_beyond_the_table_are_refused() -> None:
    for state in (-0.1, 9.1):
        with pytest.raises(ValueError, match=f"sea_state: {state} is not allowed; 0 to 9"):
            significant_wave_height(state)
    assert significant_wave_height(0) == 0.0
    with pytest.raises(ValueError, match="sea_state: 0 has no wind"):
        wind_speed(0)
