"""The pulse and its compression against closed forms."""

from typing import Any

import numpy as np
import pytest

from radar_service.radar.waveform import (
    chirp_spectrum,
    compressed_spectrum,
    noise_power,
    taylor_coefficients,
    window_coefficients,
)
from radar_service.receive.compression import compression_for
from tests.reference.compressed_pulse import compressed_pulse
from tests.scenes import radar

B, T = 50e6, 10e-6


def test_chirp_spectrum_is_the_transform_of_the_chirp() -> None:
    """Against a midpoint sum over the pulse; its own error is that of the rule, (w dt)^2 / 24 with w dt < 0.04 rad."""
    frequency = np.linspace(-40e6, 40e6, 41)
    steps = 80_000
    t = (np.arange(steps) + 0.5) * (T / steps) - T / 2
    phase = np.pi * B / T * t**2 - 2 * np.pi * frequency[:, None] * t
    expected = np.exp(1j * phase).sum(axis=1) * (T / steps)
    np.testing.assert_allclose(chirp_spectrum(frequency, B, T), expected, atol=1e-4 * T)


@pytest.mark.parametrize("window", ["none", "hamming", "hann", "blackman", "blackman-harris", "nuttall", "taylor"])
def test_compressed_spectrum_is_the_transform_of_the_closed_form(window: str) -> None:
    """Synthesised from its spectrum over +-400 MHz the pulse equals the closed form; what lies beyond is below 1e-4."""
    span, count = 800e6, 2**14
    frequency = np.fft.fftfreq(count, 1 / span)
    pulse = np.fft.ifft(compressed_spectrum(frequency, B, T, window)) * span
    delay = np.fft.fftfreq(count, 1 / count) / span
    expected = compressed_pulse(delay, B, T, tuple(window_coefficients(window)))
    near = np.abs(delay) < T / 2  # the transform is circular: outside, the pulse wraps
    np.testing.assert_allclose(pulse[near], expected[near], atol=1e-4)
    assert abs(pulse[0] - 1.0) < 1e-4  # unit echo, unit peak


def peak_sidelobe_db(profile: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """The highest lobe after the first minimum of a profile that starts at its peak."""
    minima = np.flatnonzero((profile[1:-1] < profile[:-2]) & (profile[1:-1] < profile[2:])) + 1
    return float(20 * np.log10(profile[minima[0] :].max() / profile[0]))


@pytest.mark.parametrize(
    ("window", "levels_db"),
    [
        ("none", {20: -13.97, 100: -13.39, 1000: -13.28}),
        ("hamming", {20: -23.4, 50: -31.2, 100: -37.2, 250: -40.9, 1000: -42.1}),
        ("taylor", {20: -23.6, 50: -29.5, 100: -31.4, 250: -32.9, 1000: -34.1}),
    ],
)
def test_chirp_spectrum_under_a_spectral_window_has_the_sidelobes_of_the_tables(
    window: str, levels_db: dict[int, float]
) -> None:
    """|S|^2 weighted over the band by the window (reference values, LFM table: that is what its "matched x window" means).

    0.07 dB: half the table's last digit and the grid of 1/32 of a resolution cell.
    """
    for bt, level_db in levels_db.items():
        fs, pulse = 32 * B, bt / B
        frequency = np.fft.fftfreq(2**18, 1 / fs)
        weight = sum(a * np.cos(2 * np.pi * m * frequency / B) for m, a in enumerate(window_coefficients(window)))
        weight = weight * (np.abs(frequency) <= B / 2) if window != "none" else 1.0
        profile = np.abs(np.fft.ifft(np.abs(chirp_spectrum(frequency, B, pulse)) ** 2 * weight))
        assert peak_sidelobe_db(profile[: int(pulse * fs)]) == pytest.approx(level_db, abs=0.07)


def test_sidelobes_with_the_window_on_the_reference() -> None:
    """BT = 500, Hamming on the reference: peak sidelobe -42.6 dB, the first -43.3 (docs/specification.md, errata row 11;
    half the last digit)."""
    delay = np.linspace(0, T, 200_001)
    profile = np.abs(compressed_pulse(delay, B, T, tuple(window_coefficients("hamming"))))
    minima = np.flatnonzero((profile[1:-1] < profile[:-2]) & (profile[1:-1] < profile[2:])) + 1
    assert peak_sidelobe_db(profile) == pytest.approx(-42.6, abs=0.06)
    assert 20 * np.log10(profile[minima[0] : minima[1]].max()) == pytest.approx(-43.3, abs=0.06)


def test_taylor_window_reaches_its_sidelobe_level() -> None:
    """Taylor(5, -35): -35.19 dB peak sidelobe and 0.93 dB loss (reference values, windows table)."""
    a = taylor_coefficients(35.0, 5)
    n = 4096
    t = (np.arange(n) + 0.5) / n - 0.5
    w = sum(c * np.cos(2 * np.pi * m * t) for m, c in enumerate(a))
    spectrum = np.abs(np.fft.fft(w, 64 * n))[: 32 * n]
    assert peak_sidelobe_db(spectrum) == pytest.approx(-35.19, abs=0.05)  # the table's window of 4096 points is sampled
    assert 10 * np.log10(np.mean(w**2) / np.mean(w) ** 2) == pytest.approx(0.93, abs=0.005)


def test_noise_power_is_the_stated_level() -> None:
    """Hamming, F = 4 dB, 10 us: 1.371e-15 W (docs/conventions.md; half its last digit)."""
    assert noise_power(10e-6, "hamming", 10**0.4) == pytest.approx(1.371e-15, abs=0.0005e-15)


def test_noise_has_its_power_and_is_uniform_along_range() -> None:
    """Mean of 4000 x 300 cells: neighbours correlate over 1.5 cells, so sigma is 0.11 %; 5 sigma."""
    made = radar(range_max_m=600.0)
    compression = compression_for(made, 6)
    noise = compression.from_spectrum(compression.noise.draw(4000, np.random.default_rng(3)))
    power = np.abs(noise.astype(np.complex128)) ** 2
    level = noise_power(made.pulse, made.window, made.noise_factor)
    assert power.mean() / level == pytest.approx(1.0, abs=0.006)
    assert np.abs(power.mean(axis=0) / level - 1.0).max() < 5 / np.sqrt(4000)  # each bin: exponential, 4000 draws; 5 sigma
    assert (power > level * np.log(1e3)).mean() == pytest.approx(1e-3, rel=0.2)  # Rayleigh: Pfa = exp(-threshold)


def test_unknown_window_is_refused_with_the_names() -> None:
    with pytest.raises(ValueError, match='window: "kaiser" is not one of none, hamming'):
        window_coefficients("kaiser")
