"""Compression of single echoes against closed forms of the pulse, and its count of transforms."""

from typing import Any

import numpy as np
import pytest
import scipy.fft

from radar_service.receive.compression import (
    Compression,
    compression_for,
    range_kernel,
    receiver_noise_power,
    waveform_spectra,
)
from radar_service.receive.gridding import Kernel
from radar_service.receive.plain_pulse import PulseKernel
from tests.reference.compressed_pulse import compressed_pulse
from tests.scenes import radar

CHIRP = {"range_max_m": 1000, "bandwidth_hz": 50e6, "pulse_s": 4e-6}
PLAIN = {"range_max_m": 1000, "modulation": "none", "pulse_s": 0.25e-6, "bandwidth_hz": 5e6, "sample_rate_hz": 40e6}
LONG = PLAIN | {"pulse_s": 1.2e-6, "bandwidth_hz": 1e6, "sample_rate_hz": 75e6}


def gridded(compression: Compression, column: float) -> np.ndarray[Any, np.dtype[np.complex64]]:
    """A row with a unit echo at a column."""
    rows = np.zeros((1, compression.size), dtype=np.complex64)
    compression.spread(rows, np.array([column]), np.zeros((1, 1), np.float32), np.ones((1, 1), np.complex64))
    return rows


@pytest.mark.parametrize("column", [0.0, 100.0, 211.37, 498.5])
def test_an_echo_becomes_the_closed_form_of_the_compressed_chirp(column: float) -> None:
    """Wherever it stands between two samples; -70 dB (a kernel of 6 bins errs by -80 at 1.5 x bandwidth)."""
    made = radar(**CHIRP)
    compression = compression_for(made, 6)
    profile = compression.profiles(gridded(compression, column))[0]
    delay = (np.arange(made.bins) - column) / made.sample_rate
    exact = compressed_pulse(delay, made.bandwidth, made.pulse, (0.54, 0.46))
    assert profile.shape == (made.bins,)
    assert 10 * np.log10(np.sum(np.abs(profile - exact) ** 2) / np.sum(np.abs(exact) ** 2)) < -70


@pytest.mark.parametrize("eclipsing", [False, True])
@pytest.mark.parametrize("settings", [CHIRP, PLAIN, LONG])
def test_all_transforms_are_counted(settings: dict[str, Any], eclipsing: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    compression = compression_for(radar(**settings, eclipsing=eclipsing), 6)
    samples: list[int] = []
    for name in ("fft", "ifft"):
        original = getattr(scipy.fft, name)

        def counting(x: Any, n: int | None = None, original: Any = original, **more: Any) -> Any:
            samples.append(n or x.shape[1])
            return original(x, n, **more)

        monkeypatch.setattr(scipy.fft, name, counting)
    compression.profiles(np.zeros((1, compression.size), dtype=np.complex64))
    assert compression.transformed(gridded=True, noise=False) == compression.transformed(True, True) == sum(samples)
    assert compression.transformed(gridded=False, noise=True) == compression.size
    assert compression.transformed(gridded=False, noise=False) == 0


def test_sidelobes_of_the_last_range_do_not_wrap_to_the_first() -> None:
    """A chirp of 300 samples at the last bin: nothing before its sidelobes, below -80 dB of the peak."""
    compression = compression_for(radar(**CHIRP), 6)
    profile = np.abs(compression.profiles(gridded(compression, compression.bins - 1.0))[0])
    assert profile[: compression.bins - 310].max() < 1e-4


def test_a_short_plain_pulse_is_its_own_kernel_and_a_long_one_is_not() -> None:
    assert isinstance(range_kernel(radar(**PLAIN), 6), PulseKernel)
    for settings, oversampling in ((LONG, 75.0 / 4.4), (LONG | {"bandwidth_hz": 12e6}, 1.5), (CHIRP, 1.5)):
        kernel = range_kernel(radar(**settings), 6)
        assert type(kernel) is Kernel and kernel.width == 6 and kernel.oversampling == pytest.approx(oversampling)


def test_the_filter_compresses_the_spectrum_to_a_unit_peak() -> None:
    """The integral over frequency of spectrum x filter is the output at delay 0; 1e-3: the sum ends at 20 bandwidths."""
    for settings in (CHIRP, PLAIN):
        made = radar(**settings)
        transmitted, filtered = waveform_spectra(made)
        frequency = np.linspace(-20 * made.bandwidth, 20 * made.bandwidth, 200_001)
        peak = np.sum(transmitted(frequency) * filtered(frequency)) * (frequency[1] - frequency[0])
        assert abs(peak - 1.0) < 1e-3


def test_noise_power_of_both_waveforms() -> None:
    """Hamming, F = 4 dB, 10 us: 1.371e-15 W (docs/conventions.md). A matched plain pulse would have k T0 F / T; the Gaussian
    filter at B T = 1.25 loses 10 log10(1.0645 x 1.25 / erf(1.668)^2) = 1.401 dB."""
    assert receiver_noise_power(radar(pulse_s=10e-6, noise_figure_db=4)) == pytest.approx(1.371e-15, abs=0.0005e-15)
    matched = 1.380649e-23 * 290 * 10**0.4 / 0.25e-6
    loss_db = 10 * np.log10(receiver_noise_power(radar(**PLAIN, noise_figure_db=4)) / matched)
    assert loss_db == pytest.approx(1.401, abs=2e-3)


def test_eclipsed_and_whole_echoes_are_spread_alike() -> None:
    """Echoes of a plain pulse spread together are the sum of echoes spread one by one, near and far."""
    compression = compression_for(radar(**PLAIN, eclipsing=True), 6)
    columns = np.array([3.3, 7.9, 100.4])
    rows = np.zeros((2, compression.size), dtype=np.complex64)
    migration = np.array([[0.0, 0.5], [0.0, -0.5], [0.0, 0.25]], dtype=np.float32)
    compression.spread(rows, columns, migration, np.ones((3, 2), dtype=np.complex64))
    for row in range(2):
        alone = sum(gridded(compression, float(c + m))[0] for c, m in zip(columns, migration[:, row], strict=True))
        np.testing.assert_allclose(rows[row], alone, atol=2e-4)  # steps of the kernel's table and its series
