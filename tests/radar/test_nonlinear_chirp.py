"""Nonlinear chirps against sums over fine samples that are built from their definition."""

import numpy as np
import pytest

from radar_service.radar.waveform import (
    chirp_spectrum,
    group_delay,
    nonlinear_chirp,
    nonlinear_chirp_spectrum,
    range_doppler_coupling,
    window_coefficients,
)
from tests.reference.nonlinear_pulse import chirp_samples, taper

B = 50e6
WINDOWS = ["hamming", "blackman", "nuttall", "taylor"]


@pytest.mark.parametrize("window", WINDOWS)
def test_the_chirp_passes_each_frequency_for_as_long_as_the_taper_weighs_it(window: str) -> None:
    """The principle of stationary phase: the slope of the group delay is the taper over its mean, and T in all. Differences of
    1e-5 of the band err by its square."""
    a, share = window_coefficients(window), np.linspace(-0.499, 0.499, 999)
    ends = group_delay(np.array([-B / 2, 0.0, B / 2]), B, 2e-6, a)
    np.testing.assert_allclose(ends, [-1e-6, 0.0, 1e-6], atol=1e-18)
    slope = (group_delay((share + 1e-5) * B, B, 2e-6, a) - group_delay((share - 1e-5) * B, B, 2e-6, a)) / (2e-5 * 2e-6)
    np.testing.assert_allclose(slope, taper(share, tuple(a)) / a[0], atol=1e-7)


@pytest.mark.parametrize("window", WINDOWS)
def test_its_samples_are_the_sum_of_its_frequency(window: str) -> None:
    """The Legendre transform against Simpson's rule over time, to 1e-5 rad. At the edges of the band, which pass in no time, the
    rule errs by a thousandth of a sample's phase, 2 pi / 128 rad."""
    a = window_coefficients(window)
    time, wave = chirp_samples(B, 10e-6, tuple(a), "nlfm")
    computed = nonlinear_chirp(time, B, 10e-6, a)
    np.testing.assert_allclose(computed[20:-20], wave[20:-20], atol=1e-5)
    np.testing.assert_allclose(computed, wave, atol=6e-4)


@pytest.mark.sample(6)
@pytest.mark.parametrize("product", [4, 20, 100, 500])
@pytest.mark.parametrize("window", WINDOWS)
def test_its_spectrum_is_the_sum_over_its_samples(product: int, window: str) -> None:
    """Against a midpoint rule of 64 samples per 1/B. It errs by (w dt)^2 / 24 = 6e-4 of what the ends of the pulse add,
    0.3 / B at most, and as much by its own phase there; the spectrum is sqrt(T / B)."""
    pulse, a = product / B, window_coefficients(window)
    time, wave = chirp_samples(B, pulse, tuple(a), "nlfm")
    frequency = np.linspace(-0.75, 0.75, 61) * B
    expected = np.exp(-2j * np.pi * frequency[:, None] * time) @ wave * (time[1] - time[0])
    computed = nonlinear_chirp_spectrum(frequency, B, pulse, a)
    np.testing.assert_allclose(computed, expected, atol=4e-4 / B + 3e-6 * np.sqrt(pulse / B))


@pytest.mark.parametrize("product", [4, 20, 500])
def test_without_a_taper_it_is_a_linear_chirp(product: int) -> None:
    """The Fresnel integrals are exact at every frequency: -95 dB of sqrt(T / B). Beyond the samples' band there are the ends
    alone: at a product of 4 their curvature, 1 / (w T), is -80 dB."""
    pulse = product / B
    frequency = np.concatenate([np.linspace(-3.9, 3.9, 1001), np.linspace(4.1, 40.0, 400)]) * B
    computed = nonlinear_chirp_spectrum(frequency, B, pulse, np.array([1.0]))
    assert np.abs(computed - chirp_spectrum(frequency, B, pulse)).max() < np.sqrt(pulse / B) * 10 ** (-80 / 20)


@pytest.mark.parametrize("window", WINDOWS)
def test_doppler_moves_its_echo_as_the_coupling_says(window: str) -> None:
    """An echo that turns by a twentieth of a cycle over the pulse, through its own filter: the peak of a parabola through three
    samples of 1/64 cell. 5 %: ripples of the spectrum, which the taper leaves out."""
    a = window_coefficients(window)
    time, wave = chirp_samples(B, 10e-6, tuple(a), "nlfm")
    moved = wave * np.exp(2j * np.pi * 0.05 * time / 10e-6)
    size = 2 * len(wave)
    spectra = [np.fft.fft(each, size) for each in (wave, moved)]
    frequency = np.fft.fftfreq(size, time[1] - time[0])
    weight = np.where(np.abs(frequency) < B / 2, taper(frequency / B, tuple(a)), 0.0)
    echo = np.abs(np.fft.ifft(spectra[1] * weight / spectra[0]))
    top = int(echo.argmax())
    before, at, after = echo[(top - 1) % size], echo[top], echo[(top + 1) % size]
    shift = (
        ((top + size // 2) % size - size // 2 + 0.5 * (before - after) / (before - 2 * at + after)) * (time[1] - time[0]) * B
    )
    assert -shift / 0.05 == pytest.approx(range_doppler_coupling(a), rel=0.05)
    assert range_doppler_coupling(np.array([1.0])) == pytest.approx(1.0)
