import numpy as np
import pytest
from scipy.signal import windows as scipy_windows

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.receive.documented_receiver import (
    chirp,
    chirp_sum,
    compress,
    echo,
    exact_chirp_sum,
    impulse_sum,
    printed_phase,
    pulse_times,
    sample_delay,
    window,
)
from tests.reference.printed_formulas import printed_response

BANDWIDTH, PULSE, RATE = 50e6, 10e-6, 200e6
SENT = chirp(pulse_times(PULSE, RATE), BANDWIDTH, PULSE)


def response(bandwidth_time: float, name: str) -> np.ndarray:
    """Magnitude of one side of the compressed pulse, from its peak on, 16 samples a resolution cell."""
    pulse, rate = bandwidth_time / BANDWIDTH, 16 * BANDWIDTH
    sent = chirp(pulse_times(pulse, rate), BANDWIDTH, pulse)
    received = np.concatenate([sent, np.zeros(sent.size)])
    return np.abs(compress(received, sent, window(name, sent.size), sent.size))


def sidelobes_db(profile: np.ndarray) -> np.ndarray:
    """Heights of the sidelobes of one side of a pulse, in order."""
    middle = profile[1:-1]
    peak = (middle >= profile[:-2]) & (middle > profile[2:])
    return 20 * np.log10(middle[peak])


def test_chirp_sweeps_the_bandwidth_about_the_carrier() -> None:
    time = np.linspace(-PULSE / 2, PULSE / 2, 200_001)
    frequency = np.diff(np.unwrap(np.angle(chirp(time, BANDWIDTH, PULSE)))) / np.diff(time) / (2 * np.pi)
    assert frequency[[0, -1]] == pytest.approx([-25e6, 25e6], rel=1e-5)  # one step of the grid of 200 000
    assert np.diff(frequency).mean() / np.diff(time).mean() == pytest.approx(5e12, rel=1e-6)  # K of eq. 7; rounding


def test_chirp_is_silent_outside_the_pulse() -> None:
    assert np.array_equal(np.abs(chirp(np.array([-5.01e-6, -5e-6, 0.0, 5e-6, 5.01e-6]), BANDWIDTH, PULSE)), [0, 1, 1, 1, 0])


def test_pulse_is_sampled_symmetrically() -> None:
    time = pulse_times(PULSE, RATE)
    assert time.size == 2000 and np.array_equal(time, -time[::-1])


def test_phase_turns_once_in_half_a_wavelength() -> None:
    # docs/specification.md#echo: 1.6 cm is half a wavelength; rounding of 4 pi R / lambda near 1e4 rad
    assert printed_phase(100.0 + 0.03186 / 2, 0.03186) - printed_phase(100.0, 0.03186) == pytest.approx(2 * np.pi, abs=1e-9)


def test_one_echo_is_the_scaled_and_turned_chirp() -> None:
    assert np.allclose(echo(3.0, np.pi / 2, SENT), 3j * SENT, rtol=0, atol=1e-14)  # rounding


def test_delay_of_the_worked_example() -> None:
    assert sample_delay(np.array([200.0]), RATE).tolist() == [267]  # docs/specification.md#worked-example step 1


def test_a_unit_echo_compresses_to_a_unit_peak_in_its_bin() -> None:
    weights = window("hamming", SENT.size)
    received = chirp_sum(np.array([267]), np.array([1.0]), np.array([0.7]), SENT, 1000)
    profile = compress(received, SENT, weights, 1000)
    assert int(np.argmax(np.abs(profile))) == 267
    assert profile[267] == pytest.approx(np.exp(0.7j), abs=1e-12)  # rounding of the FFT


def test_the_literal_sum_is_the_convolution_with_impulses() -> None:
    random = np.random.default_rng(0)
    delay, amplitude = random.integers(-50, 1100, 300), random.exponential(size=300)
    phase = random.uniform(0, 2 * np.pi, 300)
    literal = chirp_sum(delay, amplitude, phase, SENT, 1000)
    assert np.abs(impulse_sum(delay, amplitude, phase, SENT, 1000) - literal).max() < 1e-11  # FFT rounding of sums of 300


def test_echoes_outside_the_window_are_not_received() -> None:
    received = chirp_sum(np.array([-1, 1000, 5000]), np.ones(3), np.zeros(3), SENT, 1000)
    assert not received.any() and received.size == 1000 + SENT.size - 1


def test_compression_is_the_correlation_in_time() -> None:
    random = np.random.default_rng(1)
    sent, weights = SENT[:40], window("hann", 40)
    received = random.normal(size=139) + 1j * random.normal(size=139)
    slow = [np.sum(received[n : n + 40] * np.conj(weights * sent)) / weights.sum() for n in range(100)]
    assert np.abs(compress(received, sent, weights, 100) - slow).max() < 1e-12  # eq. 15: both its forms; FFT rounding


def test_unweighted_response_is_the_printed_sinc() -> None:
    profile = response(500, "none")[: 16 * 10]
    delay = np.arange(profile.size) / (16 * BANDWIDTH)
    # eq. 16 leaves out the overlap 1 - tau / T, which shrinks the height and, inside the sinc, the argument: tau / T in all
    assert profile == pytest.approx(printed_response(delay, BANDWIDTH), abs=1.05 * delay[-1] / PULSE)
    assert printed_response(np.array([0.0, 1 / BANDWIDTH]), BANDWIDTH) == pytest.approx([1, 0], abs=1e-15)


@pytest.mark.parametrize("name", ["hamming", "hann", "blackman"])
def test_windows_are_the_textbook_ones(name: str) -> None:
    assert window(name, 751) == pytest.approx(scipy_windows.get_window(name, 751, fftbins=False), abs=1e-12)  # rounding


def test_no_window_is_flat_and_an_unknown_one_refused() -> None:
    assert np.array_equal(window("none", 5), np.ones(5))
    with pytest.raises(ValueError, match='"kaiser" is not one of'):
        window("kaiser", 5)


@pytest.mark.parametrize(("bandwidth_time", "sidelobe_db"), [(20, -13.97), (100, -13.39), (1000, -13.28)])
def test_peak_sidelobe_without_a_window(bandwidth_time: float, sidelobe_db: float) -> None:
    # half the last digit, and as much again for a peak between two of 16 samples a cell
    assert sidelobes_db(response(bandwidth_time, "none")).max() == pytest.approx(sidelobe_db, abs=0.01)


def test_peak_sidelobe_of_a_hamming_window_needs_a_long_pulse() -> None:
    levels = [sidelobes_db(response(bt, "hamming")).max() for bt in (20, 100, 500, 1000)]
    assert levels == sorted(levels, reverse=True)
    # docs/specification.md, errata row 11; the window's own -42.68 as BT grows
    assert levels[2:] == pytest.approx([-42.6, -42.68], abs=0.05)


def test_exact_delays_agree_with_whole_samples_and_are_smooth_between_them() -> None:
    step = SPEED_OF_LIGHT / (2 * RATE)
    weights = window("hamming", SENT.size)

    def profile(position: float) -> np.ndarray:
        args = np.array([position]), np.ones(1), np.zeros(1), BANDWIDTH, PULSE, RATE, 300
        received = exact_chirp_sum(*args)
        assert received.size == 300 + SENT.size - 1
        return compress(received, SENT, weights, 300)

    whole = compress(chirp_sum(np.array([100]), np.ones(1), np.zeros(1), SENT, 300), SENT, weights, 300)
    assert np.abs(profile(100 * step) - whole).max() < 1e-9  # rounding of 2R/c, at the pulse's very edges one sample
    between = np.abs(profile(100.5 * step))
    assert between[100] == pytest.approx(between[101], rel=1e-3)  # one sample of 2000 enters the pulse, another leaves it
