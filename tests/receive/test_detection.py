import numpy as np
import pytest

from radar_service.receive.detection import beam_spread, detect, spread_sigma
from tests.reference.printed_formulas import predicted_psf

BEAM, STEP = np.deg2rad(3.9), np.deg2rad(0.5)


def width(power: np.ndarray, step: float) -> float:
    """Full width at half maximum of a single peak sampled at `step`, by linear interpolation."""
    above = np.flatnonzero(power >= power.max() / 2)
    left, right = above[0], above[-1]
    half = power.max() / 2
    outer = (
        (half - power[left - 1]) / (power[left] - power[left - 1]),
        (half - power[right + 1]) / (power[right] - power[right + 1]),
    )
    return float((right - left + 2 - outer[0] - outer[1]) * step)


def point(azimuths: int, index: int) -> np.ndarray:
    power = np.zeros((azimuths, 3))
    power[index, 1] = 7.0
    return power


def test_detection_is_the_squared_magnitude() -> None:
    field = np.array([3 + 4j, -1j], dtype=np.complex64)
    assert detect(field).tolist() == [25.0, 1.0]


def test_spreading_a_single_azimuth_draws_the_gaussian_of_the_beam() -> None:
    spread = beam_spread(point(720, 300), BEAM, STEP)[:, 1]
    offset = (np.arange(720) - 300) * STEP
    expected = np.exp(-0.5 * (offset / (BEAM / 2.355)) ** 2)
    assert spread / spread.max() == pytest.approx(expected, abs=2e-8)  # the tail cut at 6 sigma
    assert width(spread, STEP) == pytest.approx(BEAM, rel=0.01)  # linear interpolation between steps of 0.3 sigma


def test_spreading_keeps_energy_and_ranges_apart() -> None:
    spread = beam_spread(point(720, 300), BEAM, STEP)
    assert spread.sum() == pytest.approx(7.0, rel=1e-12)  # rounding
    assert not spread[:, [0, 2]].any() and spread.min() >= 0.0


@pytest.mark.parametrize("azimuths", [720, 90, 8])
def test_spreading_wraps_round_north(azimuths: int) -> None:
    step = 2 * np.pi / azimuths
    at_north, elsewhere = (beam_spread(point(azimuths, k), BEAM, step)[:, 1] for k in (0, azimuths // 2))
    assert np.roll(at_north, azimuths // 2) == pytest.approx(elsewhere, abs=1e-12)  # rounding


def test_a_beam_far_narrower_than_a_step_spreads_nothing() -> None:
    power = point(8, 3)
    assert beam_spread(power, np.deg2rad(1.0), 2 * np.pi / 8) == pytest.approx(power, abs=1e-12)


def test_predicted_point_spread() -> None:
    resolution = 3.0
    assert predicted_psf(0.0, 0.0, resolution, BEAM) == 1.0
    assert predicted_psf(resolution, 0.0, resolution, BEAM) == pytest.approx(0.0, abs=1e-30)  # first null at c / 2B
    assert predicted_psf(0.0, BEAM / 2, resolution, BEAM) == pytest.approx(0.5, abs=1e-4)  # 2.355 is 2.35482 rounded
    assert predicted_psf(1.5, spread_sigma(BEAM), resolution, BEAM) == pytest.approx(
        (2 / np.pi) ** 2 * np.exp(-0.5), rel=1e-12
    )
