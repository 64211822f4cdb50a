"""The short modules of receive, each under its name."""

import numpy as np
import pytest

from radar_service.numerics.random import generator
from radar_service.radar.antenna import grid_rows
from radar_service.receive.beam import azimuth_kernel, beam_filter, beam_spectrum
from radar_service.receive.documented_receiver import beam_spread, detect
from radar_service.receive.gridding import Kernel, spread
from radar_service.receive.noise import MIN_POWER, GaussianSpectrum, integrate
from tests.kernels.both import both
from tests.reference.compressed_pulse import sinc2_beam


# beam: the beam filter and its spectrum against the pattern itself.
@pytest.mark.parametrize(("beamwidth_deg", "azimuths"), [(3.9, 720), (0.9, 2048), (1.0, 720), (0.4, 360), (25.0, 16)])
def test_the_filter_is_the_beam_around_the_full_circle(beamwidth_deg: float, azimuths: int) -> None:
    """A unit point at any azimuth, seen from every boresight, is the pattern itself; error energy below -70 dB of it
    (design: -78 dB at the oversampling that grid_rows keeps)."""
    beamwidth = np.deg2rad(beamwidth_deg)
    rows = grid_rows(azimuths, beamwidth)
    assert rows % azimuths == 0
    kernel, flat = azimuth_kernel(beamwidth, rows, 4), Kernel(4, 4.0)
    fine = np.linspace(-np.pi, np.pi, 200_001)
    expected = azimuths * np.mean(sinc2_beam(fine, beamwidth) ** 2)  # a beam between two spokes may show almost nothing
    for azimuth in np.random.default_rng(2).uniform(0, 2 * np.pi, 5):
        grid = spread(
            (rows, 8), np.array([azimuth * rows / (2 * np.pi)]), np.array([3.0]), np.ones(1, complex), kernel, flat
        )
        column = np.argmax(np.abs(grid).sum(axis=0))
        filtered = beam_filter(grid, lambda offset: sinc2_beam(offset, beamwidth), kernel, azimuths)[:, column]
        boresight = np.arange(azimuths) * 2 * np.pi / azimuths
        exact = sinc2_beam(boresight - azimuth, beamwidth)
        assert np.sum(np.abs(filtered - exact) ** 2) < 1e-7 * expected


def test_beam_spectrum_sums_to_the_boresight_gain() -> None:
    """The pattern at offset 0 is the sum of its Fourier coefficients: 1, up to what lies beyond the band (1e-4)."""
    spectrum = beam_spectrum(lambda offset: sinc2_beam(offset, np.deg2rad(3.9)), 720)
    assert spectrum.sum() / 720 == pytest.approx(1.0, abs=1e-4)


# documented_receiver: detection and beam spreading.
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


# noise: noise spectra: power, shape and independence.
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
