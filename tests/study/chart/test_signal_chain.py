"""Methods of the signal chain and chirp sums: their errors are those of theory."""

import numpy as np
import pytest

from radar_service.echo.echoes import Echoes
from radar_service.numerics.types import Floats
from radar_service.radar.parameters import Radar
from radar_service.receive.documented_receiver import chirp_sum, impulse_sum
from radar_service.study.chart.field_panel import field_points, workload_of
from radar_service.study.chart.point import Point
from radar_service.study.chart.signal_chain import Method, chirps, methods
from tests.scenes import radar
from tests.study.chart.settings import SMALL


def random_echoes(count: int, small: Radar) -> Echoes:
    """Returns echoes of unit amplitude at random ranges, azimuths and phases."""
    rng = np.random.default_rng(3)
    phase = np.exp(2j * np.pi * rng.random(count))
    return Echoes(rng.uniform(60.0, 0.95 * small.range_max, count), rng.uniform(0, 2 * np.pi, count), phase)


def chain_points(small: Radar, echoes: Echoes, *families: str) -> dict[tuple[str, str], Point]:
    """Returns the points of the methods of these families, or of all."""
    chosen = [method for method in methods(small) if not families or method.family in families]
    workload = workload_of(small, echoes, len(echoes.range), 2, 0)
    return {(p.family, p.setting): p for p in field_points(workload, chosen, 1)}


def decibels_of(points: dict[tuple[str, str], Point]) -> dict[tuple[str, str], float]:
    return {key: p.error_db or 0.0 for key, p in points.items()}


def test_errors_of_the_signal_chain_are_those_of_theory() -> None:
    """Delays rounded to a step of 1/(1.5 B) have an error of -15 dB, within 4 dB for the 40 echoes of this draw.
    Kaiser-Bessel kernels of 4 and 6 bins reach -61 and -80 dB, here up to 6 dB less, as the pulse is short."""
    small = radar(**SMALL)
    points = chain_points(small, random_echoes(40, small))
    error = decibels_of(points)
    assert error["integer-delay chirps", "12 beamwidths"] == pytest.approx(-15, abs=4)
    assert error["integer delays, FFT", "1.5 beamwidths"] == pytest.approx(
        error["integer-delay chirps", "1.5 beamwidths"], abs=0.01
    )
    assert error["Kaiser-Bessel grid", "4 bins"] < -55 and error["Kaiser-Bessel grid", "6 bins"] < -74
    assert error["nearest bin", "1 bin"] > error["Kaiser-Bessel grid", "2 bins"] > error["Kaiser-Bessel grid", "4 bins"]
    assert all(p.seconds > 0 and p.extrapolated == ("chirps" in p.family) for p in points.values())


def test_every_preset_has_its_settings() -> None:
    """At rest the kernel widths identify a preset, under way the extent of the beam, and `documented` the printed beam."""
    small = radar(**SMALL)
    named = {m.preset: (m.family, m.setting) for m in methods(small) if m.preset}
    assert named == {
        "documented": ("integer-delay chirps", "printed beam"),
        "fast": ("Kaiser-Bessel grid", "4 bins"),
        "balanced": ("Kaiser-Bessel grid", "6 bins"),
        "reference": ("Kaiser-Bessel grid", "8 bins x 6 rows"),
        "fast under way": ("azimuth by azimuth", "3 beamwidths"),
        "balanced under way": ("azimuth by azimuth", "12 beamwidths"),
        "reference under way": ("azimuth by azimuth", "full circle"),
    }


def test_nearest_bins_are_exact_for_echoes_in_the_middle_of_a_bin() -> None:
    """No range is rounded, so only the error of the azimuth grid remains: below -70 dB as with six bins, not -16."""
    small = radar(**SMALL)
    echoes = random_echoes(20, small)
    centred = Echoes((np.floor(echoes.range / small.range_step) + 0.5) * small.range_step, echoes.azimuth, echoes.amplitude)
    assert decibels_of(chain_points(small, centred, "nearest bin"))["nearest bin", "1 bin"] < -70


def test_a_truncated_beam_loses_the_energy_outside() -> None:
    """The field of one echo around the scan is the pattern. A truncated beam leaves out blocks of 16 azimuths, and their share
    of the energy is the error. With the printed beam it is the share of the difference. The echo lies on a sample of the
    documented grid, so no delay is rounded. Tolerance 0.3 dB: the sampled pulse differs from the closed form by -30 dB."""
    small = radar(**{**SMALL, "azimuths": 360})
    echo = Echoes(np.array([500 * small.range_step]), np.array([1.0]), np.ones(1, dtype=np.complex128))
    error = decibels_of(chain_points(small, echo, "azimuth by azimuth", "integer-delay chirps"))
    off = np.angle(np.exp(1j * (np.arange(small.azimuths) * small.azimuth_step - 1.0)))
    gain, printed = np.sinc(0.88589 * off / small.beamwidth) ** 2, np.sinc(2.783 * off / small.beamwidth) ** 4
    block = np.arange(small.azimuths) // 16
    middle = np.array(
        [off[block == b][[0, -1]].mean() if abs(off[block == b][0]) < 2 else np.pi for b in range(block[-1] + 1)]
    )
    for extent in (1.5, 3.0, 6.0):
        beyond = np.abs(middle)[block] > extent * small.beamwidth + 8.0 * small.azimuth_step
        share = np.sum(gain[beyond] ** 2) / np.sum(gain**2)
        assert error["azimuth by azimuth", f"{extent:g} beamwidths"] == pytest.approx(10 * np.log10(share), abs=0.3)
    wrong = np.where(np.abs(off) <= 1.5 * small.beamwidth, printed, 0.0) - gain
    share = np.sum(wrong**2) / np.sum(gain**2)
    assert error["integer-delay chirps", "printed beam"] == pytest.approx(10 * np.log10(share), abs=0.3)


@pytest.mark.parametrize("pulse_s, family", [(8e-8, "pulse itself"), (1.2e-6, "Kaiser-Bessel grid")])
def test_unmodulated_pulses_have_their_own_methods(pulse_s: float, family: str) -> None:
    """The engine reaches -83 dB of the closed form in the table of accuracy, here at least -70. There are no chirp sums."""
    small = radar(**{**SMALL, "modulation": "none", "pulse_s": pulse_s, "sample_rate_hz": 8e7})
    points = chain_points(small, random_echoes(40, small), "pulse itself", "Kaiser-Bessel grid", "nearest bin")
    errors = {p.preset: p.error_db or 0.0 for p in points.values() if p.family == family and p.preset}
    assert set(", ".join(p for p in errors if p).split(", ")) == {"fast", "balanced", "reference"}
    assert all(error < -70 for preset, error in errors.items() if preset != "fast")
    assert decibels_of(points)["Kaiser-Bessel grid", "8 bins"] < -60 < -50 < decibels_of(points)["nearest bin", "1 bin"]
    assert not any("chirps" in m.family for m in methods(small))


SPOKES = np.arange(8, 20)
SMALL_RADAR = radar(**SMALL)


def echoes_at(radar: Radar, steps: Floats) -> Echoes:
    """Returns two echoes at ranges (2,) [range steps], 45 and 70 degrees from north."""
    return Echoes(steps * radar.range_step, np.deg2rad([45.0, 70.0]), np.array([1.0, 0.5j]))


def gain(offset: Floats) -> Floats:
    return SMALL_RADAR.pattern.gain(offset, SMALL_RADAR.beamwidth)


def test_impulses_and_chirps_with_rounded_delays_are_the_same_sum() -> None:
    """Convolution is linear. Both round to complex64, 1e-6 of the peak."""
    echoes, reach = echoes_at(SMALL_RADAR, np.array([200.3, 410.8])), np.pi
    one, other = (chirps(SMALL_RADAR, reach, gain, add)(echoes, SPOKES) for add in (chirp_sum, impulse_sum))
    assert np.abs(one).max() > 0.3 and np.abs(one - other).max() < 1e-6


def test_exact_delays_change_nothing_for_echoes_on_samples() -> None:
    """An echo on a sample has no delay to round; between two samples the two sums differ by several per cent."""
    for steps, differs in ((np.array([200.0, 410.0]), False), (np.array([200.4, 410.6]), True)):
        echoes = echoes_at(SMALL_RADAR, steps)
        rounded = chirps(SMALL_RADAR, np.pi, gain, chirp_sum)(echoes, SPOKES)
        exact = chirps(SMALL_RADAR, np.pi, gain, None)(echoes, SPOKES)
        assert (np.abs(rounded - exact).max() > 0.03) == differs


def test_samples_begin_where_the_method_says() -> None:
    """The documented chain samples whole steps, the engine the middles of range bins."""
    small = radar(**SMALL)
    for first in (0.0, 0.5):
        method = Method("family", "setting", lambda echoes, spokes: np.zeros((0, 0), np.complex64), small, first, None)
        assert method.sample_range[0] == first * small.range_step and len(method.sample_range) == small.bins
        np.testing.assert_allclose(np.diff(method.sample_range), small.range_step, rtol=1e-9)
