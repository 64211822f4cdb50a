"""Noise spectra: power, shape and independence."""

import numpy as np
import pytest

from radar_service.numerics.random import generator
from radar_service.receive.noise import MIN_POWER, GaussianSpectrum, integrate
from tests.kernels.both import both

SIZE, ROWS = 240, 4000
SHAPE = np.exp(-((np.fft.fftfreq(SIZE) / 0.1) ** 2)) * (1.2 + np.sin(7 * np.fft.fftfreq(SIZE)))  # not symmetric


def test_each_frequency_has_its_share_of_the_power() -> None:
    """|S(f)|^2 is exponential with the mean power x size^2 x shape / sum: 5 sigma of 4000 draws. 1e-4 of the power is cut."""
    spectrum = GaussianSpectrum(SHAPE, 3e-6).draw(ROWS, generator(1)).astype(complex)
    kept = SHAPE > MIN_POWER * SHAPE.max()
    expected = 3e-6 * SIZE**2 * SHAPE / SHAPE[kept].sum()
    power = np.mean(np.abs(spectrum) ** 2, axis=0)
    assert np.abs(power[kept] / expected[kept] - 1).max() < 5 / np.sqrt(ROWS)
    assert (power[~kept] == 0).all() and 0 < np.count_nonzero(~kept) < SIZE


def test_rows_have_the_power() -> None:
    """Parseval: 5 sigma of the independent frequencies, of which the shape has sum^2 / sum of squares."""
    rows = np.fft.ifft(GaussianSpectrum(SHAPE, 3e-6).draw(ROWS, generator(2)), axis=1)
    independent = ROWS * SHAPE.sum() ** 2 / np.sum(SHAPE**2)
    assert np.mean(np.abs(rows) ** 2) == pytest.approx(3e-6, rel=5 / np.sqrt(independent))


def test_noise_is_circular() -> None:
    """The pseudo-variance E[S^2] of complex noise is 0, and so is the mean: 5 sigma."""
    spectrum = GaussianSpectrum(np.ones(SIZE), 1.0 / SIZE).draw(ROWS, generator(3)).astype(complex)
    count = ROWS * SIZE
    assert abs(np.mean(spectrum**2)) < 5 * np.sqrt(2 / count) and abs(np.mean(spectrum)) < 5 / np.sqrt(count)


def test_adding_is_drawing_and_a_sum() -> None:
    """With rows whose last word of random numbers goes on in the next one, by the kernel and by numpy: bytes are equal."""
    odd = np.abs(np.fft.fftfreq(SIZE)) * SIZE < 20.5  # 41 frequencies
    noise, before = GaussianSpectrum(odd.astype(float), 1.0), np.full((3, SIZE), 2 - 1j, dtype=np.complex64)

    def drawn() -> tuple[bytes, bytes]:
        added = before.copy()
        noise.add(added, generator(4, 1))
        np.testing.assert_array_equal(added, before + noise.draw(3, generator(4, 1)))
        return added.tobytes(), noise.draw(3, generator(4, 1)).tobytes()

    compiled, by_numpy = both(drawn)
    assert compiled == by_numpy


@pytest.mark.parametrize("snr", [0.0, 4.0])
def test_integrated_power_has_the_law_of_the_mean_over_pulses(snr: float) -> None:
    """Mean snr + 1 and variance (2 snr + 1) / pulses of a steady echo in noise (Marcum 1960), and its third moment by draws of
    every pulse; the phase is that of the sum."""
    pulses, count, rng = 5, 200_000, np.random.default_rng(6)
    noise = (rng.standard_normal((pulses, count, 2)) @ np.array([1.0, 1.0j])) / np.sqrt(2.0)
    each = np.sqrt(snr) + noise
    field = each.mean(axis=0)[None].astype(np.complex64)
    before = np.angle(field)
    integrate(field, pulses, 1.0, np.random.default_rng(7))
    power, expected = np.abs(field[0].astype(complex)) ** 2, (np.abs(each) ** 2).mean(axis=0)
    assert power.mean() == pytest.approx(snr + 1.0, rel=0.01)
    assert power.var() == pytest.approx((2.0 * snr + 1.0) / pulses, rel=0.02)
    assert np.quantile(power, 0.999) == pytest.approx(np.quantile(expected, 0.999), rel=0.02)
    np.testing.assert_allclose(np.angle(field), before, atol=1e-4)
