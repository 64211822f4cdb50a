"""The unmodulated pulse behind its receiver: closed form, noise, and the kernel that grids it."""

import numpy as np
import pytest
from scipy.integrate import quad

from radar_service.numerics.random import generator
from radar_service.receive.compression import compression_for, receiver_noise_power
from radar_service.receive.gridding import spread_moving
from radar_service.receive.plain_pulse import (
    PulseKernel,
    plain_filter,
    plain_filter_power,
    plain_noise_power,
    plain_response,
    plain_spectrum,
)
from tests.scenes import radar

T, B = 0.3e-6, 8e6
MAGNETRON = {"modulation": "none", "pulse_s": T, "bandwidth_hz": B, "range_max_m": 1500.0}


def test_the_answer_is_the_pulse_passed_through_the_filter() -> None:
    """Against the Fourier integral of sinc x filter, by quadrature to 1e-9."""
    for delay in (0.0, 0.4 * T, 0.5 * T, 0.7 * T, -0.6 * T):
        exact, _ = quad(
            lambda f: float((plain_spectrum(np.array(f), T) * plain_filter(np.array(f), T, B)).real)
            * np.cos(2 * np.pi * f * delay),  # noqa: B023 - evaluated at once
            -8 * B, 8 * B, limit=400, epsabs=1e-9,
        )  # fmt: skip
        assert plain_response(np.array(delay), T, B) == pytest.approx(exact, abs=1e-8)


def test_a_unit_echo_peaks_at_one_and_half_way_up_its_edge_at_half() -> None:
    """At the edge of the pulse half the filter's answer has passed: 1/2 to the tail of the far edge (1e-9 at B T = 2.4)."""
    middle, edge = plain_response(np.array([0.0, T / 2]), T, B)
    assert middle == 1.0
    assert edge == pytest.approx(0.5, abs=2e-3)  # the peak is erf(3.2) = 0.999994; the far edge adds its own 1e-9


def test_filter_is_down_three_db_at_half_its_bandwidth() -> None:
    np.testing.assert_allclose(plain_filter_power(np.array([0.0, B / 2, -B / 2, B]), B), [1, 0.5, 0.5, 1 / 16], rtol=1e-12)


def test_best_receiver_is_half_a_decibel_short_of_the_matched_filter() -> None:
    """A rectangular pulse through a Gaussian filter: the least loss, 0.5 dB, lies at B T = 0.73 (Skolnik 2001, non-matched
    filters: 0.49 dB at 0.72); the customary 1.2 costs 1.27 dB. Matched filter: k T0 F / T. Half the last digit of each."""
    matched = 1.380649e-23 * 290 / T
    products = np.linspace(0.3, 3, 271)
    losses = np.array([10 * np.log10(plain_noise_power(T, p / T, 1.0) / matched) for p in products])
    assert losses.min() == pytest.approx(0.50, abs=0.015)
    assert products[losses.argmin()] == pytest.approx(0.73, abs=0.015)
    assert losses[np.argmin(np.abs(products - 1.2))] == pytest.approx(1.27, abs=0.005)


def test_noise_has_its_power_in_every_bin_and_the_filters_correlation() -> None:
    """4000 rows: mean over some 100 000 independent cells to 5 sigma; neighbours correlate as exp(-(pi B dt)^2 / (4 ln 2)),
    the transform of the filter's |H|^2, folding included: 5 sigma of as many products."""
    made = radar(**MAGNETRON)
    compression = compression_for(made, 6)
    noise = compression.from_spectrum(compression.noise.draw(4000, generator(5))).astype(complex)
    level = receiver_noise_power(made)
    sigma = 1 / np.sqrt(noise.size / 2)
    assert np.mean(np.abs(noise) ** 2) / level == pytest.approx(1.0, abs=5 * sigma)
    for lag in (1, 2):
        expected = np.exp(-((np.pi * B * lag / made.sample_rate) ** 2) / (4 * np.log(2)))
        measured = np.mean(noise[:, lag:] * np.conj(noise[:, :-lag])).real / level
        assert measured == pytest.approx(expected, abs=5 * sigma)


def test_the_pulse_kernel_is_as_wide_as_the_filtered_pulse() -> None:
    """What lies beyond the kernel's width is below -100 dB of the peak, and its tables hold the answer itself."""
    compression = compression_for(radar(**MAGNETRON), 6)
    kernel = compression.kernel
    assert isinstance(kernel, PulseKernel)
    assert kernel.width == 2 * np.ceil((T / 2 + 5 * 0.2650 / B) * 12e6)
    beyond = plain_response(np.array([kernel.width / 2 / 12e6]), T, B)
    assert abs(float(beyond[0])) < 1e-5
    one, still = np.ones((1, 1), np.complex64), np.zeros((1, 1), np.float32)
    gridded = np.zeros((1, 64), np.complex64)
    spread_moving(gridded, np.array([30.3]), still, one, kernel.tables())
    exact = plain_response((np.arange(64) - 30.3) / 12e6, T, B)
    np.testing.assert_allclose(
        gridded[0].real, exact, atol=1e-4
    )  # the nearest of 8192 entries a sample, on an edge a sample long


def test_a_long_pulse_finely_sampled_goes_by_way_of_the_band() -> None:
    """1.2 us at 75 MSPS are 90 samples: spread with a short kernel, filtered by a transform, and the same to -60 dB."""
    made = radar(modulation="none", pulse_s=1.2e-6, bandwidth_hz=3e6, sample_rate_hz=75e6, range_max_m=1500.0)
    compression = compression_for(made, 6)
    assert compression.kernel.width == 6
    row = np.zeros((1, compression.size), np.complex64)
    compression.spread(row, np.array([300.4]), np.zeros((1, 1), np.float32), np.ones((1, 1), np.complex64))
    profile = compression.profiles(row)[0]
    exact = plain_response((np.arange(made.bins) - 300.4) / 75e6, 1.2e-6, 3e6)
    assert np.abs(profile - exact).max() < 1e-3
