"""Range histories against exact ones, and against the bound that their module states."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.echo.range_history import (
    MAX_AZIMUTH_CHANGE,
    TOLERANCE,
    apparent_position,
    elevation_of,
    exact_history,
    interpolated_history,
    interpolation_error,
    parabola,
    slant_range,
)
from radar_service.numerics.frames import polar_from_map

Floats = NDArray[np.float64]
EARTH = 4 / 3 * 6_371_000.0
TIME = 100_000.0 + np.linspace(0.0, 0.05, 16)  # s, late in a run
SINGLE = 2.0**-23  # relative spacing of float32


def tracks(start: Floats, velocity: Floats, time: Floats) -> Floats:
    """Positions (K, E, 3) of straight tracks that are at `start` (E, 3) in the middle of TIME."""
    middle = (TIME[0] + TIME[-1]) / 2.0
    return np.asarray(start + (time - middle)[:, None, None] * velocity)


def random_tracks(count: int, speed: float) -> tuple[Floats, Floats]:
    """Starts and velocities, at 20 to 2000 m and any aspect."""
    rng = np.random.default_rng(1)
    azimuth, course, distance = rng.uniform(0, 2 * np.pi, (2, count)).tolist() + [np.geomspace(20, 2000, count)]
    start = np.stack([distance * np.sin(azimuth), distance * np.cos(azimuth), rng.uniform(-15, 15, count)], axis=1)
    velocity = speed * np.stack([np.sin(course), np.cos(course), np.zeros(count)], axis=1)
    return start, velocity


def test_interpolated_ranges_keep_the_stated_bound() -> None:
    """0.074 s^3 / R^2 for 100 m/s, s = 2.5 m to either end, R the least range meanwhile; over it the spacing of float32 of
    both ends' changes. Azimuths: 6e-8 rad by the series, and the parabola's own error, (s / R)^3, beside."""
    start, velocity = random_tracks(400, 100.0)
    over = parabola(TIME)
    nodes = list(tracks(start, velocity, over.nodes))
    history, exactly = interpolated_history(nodes, nodes, slant_range(nodes[1], EARTH), EARTH, over)
    each = tracks(start, velocity, TIME)
    exact = slant_range(each, EARTH) - history.range
    error = np.abs(history.range_migration.T - exact).max(axis=0)
    nearest = history.range - 2.5
    bound = 0.074 * 2.5**3 / nearest**2
    assert (error <= bound + 2 * SINGLE * np.abs(exact).max(axis=0)).all()
    assert 0.5 < (error / bound).max()  # somewhere it is nearly reached
    assert (error[~exactly] < 1.1 * TOLERANCE + 2 * SINGLE * 2.5).all() and 10 < exactly.sum() < 390
    turned = np.angle(np.exp(1j * (np.arctan2(each[..., 0], each[..., 1]) - np.arctan2(nodes[1][:, 0], nodes[1][:, 1]))))
    far = ~exactly
    azimuth_bound = 6e-8 + (2.5 / nearest) ** 3 + 2 * SINGLE * MAX_AZIMUTH_CHANGE
    assert (np.abs(history.azimuth_change.T - turned).max(axis=0)[far] < azimuth_bound[far]).all()


def test_echoes_that_leave_their_parabola_are_found_by_the_bound() -> None:
    """At 25 kn, s = 0.32 m: below the range sqrt(0.074 s^3 / TOLERANCE), and where the azimuth changes by more than 0.05."""
    start, velocity = random_tracks(200, 12.86)
    over = parabola(TIME)
    nodes = list(tracks(start, velocity, over.nodes))
    middle = slant_range(nodes[1], EARTH)
    _, exactly = interpolated_history(nodes, nodes, middle, EARTH, over)
    half = 12.86 * 0.025
    near = middle < np.sqrt(0.074 * half**3 / TOLERANCE)
    turn = np.abs([np.angle(np.exp(1j * (np.arctan2(*p[:, :2].T) - np.arctan2(*nodes[1][:, :2].T)))) for p in nodes[::2]])
    steep = np.tan(turn.max(axis=0)) > MAX_AZIMUTH_CHANGE
    assert near.any() and not near.all()
    np.testing.assert_array_equal(exactly, near | steep)


def test_exact_histories_replace_those_requested_and_no_others() -> None:
    """Range to float32 of its change, azimuth too; elevations as of `polar_from_map`."""
    start, velocity = random_tracks(50, 60.0)
    over = parabola(TIME)
    nodes = list(tracks(start, velocity, over.nodes))
    middle = slant_range(nodes[1], EARTH)
    history, _ = interpolated_history(nodes, nodes, middle, EARTH, over)
    before = history.range_migration.copy()
    which, azimuth = np.arange(0, 50, 7), np.arctan2(nodes[1][:, 0], nodes[1][:, 1])
    each = tracks(start, velocity, TIME)[:, which]
    elevation = exact_history(history, which, each, None, azimuth[which], EARTH)
    polar = polar_from_map(each, np.zeros(3), EARTH)
    np.testing.assert_allclose(history.range_migration[which].T, polar.range - middle[which], rtol=2 * SINGLE, atol=1e-7)
    turned = np.angle(np.exp(1j * (polar.azimuth - azimuth[which])))
    np.testing.assert_allclose(history.azimuth_change[which].T, turned, rtol=2 * SINGLE, atol=1e-9)
    np.testing.assert_allclose(elevation.T, polar.elevation, rtol=0, atol=1e-12)
    others = np.setdiff1d(np.arange(50), which)
    np.testing.assert_array_equal(history.range_migration[others], before[others])


def test_a_swaying_antenna_observes_rotated_positions() -> None:
    """By a rotation of 90 degrees about the north axis, which takes east to down: the drop of the earth goes along."""
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    position = np.array([[3000.0, 4000.0, 20.0]])
    drop = 5000.0**2 / (2 * EARTH)
    observed = apparent_position(position, turn, EARTH)
    np.testing.assert_allclose(observed, [[20.0 - drop, 4000.0, -3000.0]], rtol=1e-15)
    assert elevation_of(observed)[0] == pytest.approx(np.arctan2(-3000.0, np.hypot(20.0 - drop, 4000.0)), rel=1e-15)


def test_interpolation_error_of_a_parabola_is_none_and_that_of_a_cubic_is_known() -> None:
    """u^3 over [-1, 1] leaves the parabola through -1, 0, 1, which is u, by 2 / (3 sqrt 3) at most."""
    time = np.linspace(0.0, 2.0, 2001)
    over = parabola(time)

    def error(power: int) -> float:
        def value(t: Floats) -> Floats:
            return np.asarray((t - 1.0) ** power)[:, None]

        return float(interpolation_error(value(time), value(over.nodes), over))

    assert error(2) < 1e-15 and error(3) == pytest.approx(2 / (3 * np.sqrt(3)), rel=1e-6)


def test_a_single_azimuth_changes_nothing() -> None:
    over = parabola(np.array([7.0]))
    assert over.nodes.tolist() == [7.0, 7.0, 7.0] and not over.change(np.ones(3), np.ones(3)).any()
