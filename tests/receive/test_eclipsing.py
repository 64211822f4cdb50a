"""What a one-antenna radar receives of a near echo, against the closed form of the truncated chirp."""

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from radar_service.receive.compression import compression_for
from tests.reference.compressed_pulse import compressed_pulse
from tests.reference.nonlinear_pulse import eclipsed_echo
from tests.reference.point_scene import COSINE_SUMS
from tests.scenes import radar

HAMMING = (0.54, 0.46)


def received(settings: dict[str, Any], share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Profile of a unit echo whose delay is this share of the pulse: ours, the closed form, and that of the whole echo."""
    made = radar(eclipsing=True, **settings)
    compression, fs = compression_for(made, 6), made.sample_rate
    late = share * made.pulse
    one, still = np.ones((1, 1), np.complex64), np.zeros((1, 1), np.float32)
    gridded = np.zeros((1, compression.size), np.complex64)
    compression.spread(gridded, np.array([late * fs - 0.5]), still, one)
    delay = (np.arange(made.bins) + 0.5) / fs - late
    exact = compressed_pulse(delay, made.bandwidth, made.pulse, HAMMING, made.pulse / 2 - late)
    return compression.profiles(gridded)[0], exact, compressed_pulse(delay, made.bandwidth, made.pulse, HAMMING)


@pytest.mark.parametrize(
    ("settings", "bound_db"),
    [
        ({"range_max_m": 3000}, -61),
        ({"range_max_m": 3000, "sample_rate_hz": 200e6}, -75),
        ({"range_max_m": 900, "pulse_s": 2e-6}, -51),
    ],
    ids=["75 MSPS", "200 MSPS", "BT 100"],
)  # fmt: skip
def test_a_truncated_echo_meets_its_closed_form(settings: dict[str, Any], bound_db: float) -> None:
    """Error over the energy of the whole echo. A cut on a grid of 3 fs, counted half, leaves (pi / 6)^2 B^3 / (12 (3 fs)^4)
    of the chirp's T: -68 dB of BT = 500 at 1.5 B, as (BT)^-1 fs^-4. 7 dB are for the chirp, known up to fs / 2 only."""
    for share in (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98):
        computed, exact, whole = received(settings, share)
        error = np.sum(np.abs(computed - exact) ** 2) / np.sum(np.abs(whole) ** 2)
        assert 10 * np.log10(error) < bound_db, share


def test_an_echo_that_ends_with_the_own_pulse_is_eclipsed_and_one_behind_it_is_whole() -> None:
    """Where the edge of the chirp, known up to fs / 2, rings into the cut: -45 dB on it, -50 near it, -80 far off."""
    for share, bound_db in ((1.0, -45), (1.01, -50), (1.5, -80)):
        computed, exact, whole = received({"range_max_m": 3000}, share)
        assert 10 * np.log10(np.sum(np.abs(computed - whole) ** 2) / np.sum(np.abs(whole) ** 2)) < bound_db
    computed, _, whole = received({"range_max_m": 3000}, 1e-4)
    assert 10 * np.log10(np.sum(np.abs(computed) ** 2) / np.sum(np.abs(whole) ** 2)) < -40


def test_the_peak_is_the_windows_tail() -> None:
    """The share of the area of the window that is received, by its integral."""
    for share in (0.3, 0.5, 0.8):
        computed, _, _ = received({"range_max_m": 3000, "sample_rate_hz": 400e6}, share)
        start = 0.5 - share
        area = 0.54 * (0.5 - start) + 0.46 * (np.sin(np.pi) - np.sin(2 * np.pi * start)) / (2 * np.pi)
        position = share * 10e-6 * 400e6 - 0.5
        at_peak = np.interp(position, np.arange(len(computed)), np.abs(computed))
        assert at_peak == pytest.approx(area / 0.54, rel=0.02)  # between samples of 0.125 resolution cells: 2 %


@pytest.mark.sample(3)
@pytest.mark.parametrize(("modulation", "compression"), [("nlfm", "matched"), ("nlfm", "inverse"), ("lfm", "inverse")])
@pytest.mark.parametrize("window", ["blackman", "nuttall"])
def test_truncated_nonlinear_and_inversely_filtered_echoes(window: str, modulation: str, compression: str) -> None:
    """Against the cut samples of the pulse behind its filter, over the energy of the whole echo: the bound of the chirp of
    75 MSPS above. The response of an inverse filter to a part of the pulse lasts two pulse lengths."""
    settings = {"range_max_m": 6000, "window": window, "modulation": modulation, "compression": compression}
    made = radar(eclipsing=True, **settings)
    compressed, fs = compression_for(made, 6), made.sample_rate
    exact = {}
    for received in (0.1, 0.7, 2.0):
        lag, field = eclipsed_echo(made.bandwidth, made.pulse, COSINE_SUMS[window], modulation, compression, received)
        order = np.argsort(lag)
        exact[received] = CubicSpline(lag[order], field[order])
    for share, cut in exact.items():
        late = share * made.pulse
        row = np.zeros((1, compressed.size), np.complex64)
        compressed.spread(row, np.array([late * fs - 0.5]), np.zeros((1, 1), np.float32), np.ones((1, 1), np.complex64))
        delay = (np.arange(made.bins) + 0.5) / fs - late
        error = np.sum(np.abs(compressed.profiles(row)[0] - cut(delay)) ** 2) / np.sum(np.abs(exact[2.0](delay)) ** 2)
        assert 10 * np.log10(error) < -61, share
