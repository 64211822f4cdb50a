"""Answers of beacons in profiles: where each mark lies, how strong, how wide, and what a filter makes of them; against
arithmetic and sums in time of its own."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.numerics.frames import effective_earth_radius
from radar_service.stages.beacons.stage import BeaconAnswers
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import point, scene

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
LIGHT = 299_792_458.0
PLAIN = {"modulation": "none", "bandwidth_hz": 20e6, "pulse_s": 0.1e-6, "sample_rate_hz": 60e6}
RADAR = {"range_max_m": 6000, "azimuths": 360, "beamwidth_deg": 4, "pattern": "taylor", "rpm": 24, **PLAIN}
CHIRP = {"modulation": "lfm", "bandwidth_hz": 10e6, "pulse_s": 4e-6, "sample_rate_hz": 20e6, "window": "hamming"}
RACON = {"letter": "K", "dot_s": 1e-6, "delay_s": 0.4e-6, "offset_m": [0, 0, 0]}
FLAT = {"earth": "flat"}


def made(beacon: dict[str, Any], radar: Any = None, distance: float = 3000.0, **body: Any) -> rs.Scene:
    body = point("b", 0, distance, **({"rcs_dbsm": -60.0} | beacon | body))
    return scene([body], radar={**RADAR, **(radar or {})}, environment=FLAT)


def answers(of: rs.Scene, seed: int = 0) -> BeaconAnswers:
    return BeaconAnswers(of, 0, OcclusionScene(of.bodies, effective_earth_radius(of.environment.earth_factor)), seed)


def rows(of: rs.Scene, scan: int = 0, seed: int = 0, blind: bool = False) -> dict[int, Complexes]:
    """The profiles of the azimuths of a scan that have an answer."""
    number = scan * of.radar.azimuths + np.arange(of.radar.azimuths)
    boresight, time = of.radar.schedule(number)
    return dict(answers(of, seed).rows(number, boresight, time, np.full(len(number), not blind)))


def ranges(of: rs.Scene) -> Floats:
    return (np.arange(of.radar.bins) + 0.5) * of.radar.range_step


def edges(of: rs.Scene, profile: Complexes) -> Floats:
    """Ranges [m] at which the magnitude passes half of its maximum, between samples."""
    magnitude, where = np.abs(profile) / np.abs(profile).max(), ranges(of)
    k = np.flatnonzero(np.diff((magnitude > 0.5).astype(int)))
    return where[k] + (0.5 - magnitude[k]) / (magnitude[k + 1] - magnitude[k]) * of.radar.range_step


def test_marks_lie_where_the_equation_has_them() -> None:
    """K, dots of 1 us: R + c/2 (0.4 us - half of the 0.1 us pulse), then dash, dot, dash. The filter is even, so an edge has half
    the amplitude at its place: a tenth of a cell of 2.5 m (straight lines between samples of a rounded edge)."""
    of = made({"racon": RACON})
    begin = 3000.0 + LIGHT / 2 * (0.4e-6 - 0.05e-6)
    expected = begin + LIGHT / 2 * 1e-6 * np.array([0, 3, 4, 5, 6, 9])
    np.testing.assert_allclose(edges(of, rows(of)[0]), expected, atol=0.25)


def test_the_power_is_that_of_the_one_way_equation() -> None:
    """30 dBm from 3000 m through a gain of 30 dB at 9410 MHz: 32.45 + 20 log10(3 x 9410) = 121.46 dB of free space, so -61.46 dBm
    in the middle of a dash, which the filter passes with a gain of 1.0002; half the last digit. From half as far 6.02 dB more:
    R^-2, not R^-4."""
    levels = []
    for distance in (3000.0, 1500.0):
        of = made({"racon": RACON}, distance=distance)
        dash = int((distance + LIGHT / 2 * 1.85e-6) / of.radar.range_step)
        levels.append(20 * np.log10(np.abs(rows(of)[0][dash])) + 30)
    assert levels[0] == pytest.approx(-61.46, abs=0.006)
    assert levels[1] - levels[0] == pytest.approx(20 * np.log10(2), abs=0.001)


def in_time(of: rs.Scene, carrier: Any, begin: float, end: float, heard_from: float = -np.inf) -> Complexes:
    """Slow reference: what arrives, correlated in time with the windowed chirp, every 2 ns. carrier: phase [rad] at times [s]
    from the middle of the transmitted pulse; begin, end: of the answer there; heard_from: before it nothing arrives [s]."""
    fine, half, band = 2e-9, of.radar.pulse / 2, of.radar.bandwidth
    t = np.arange(-half + fine / 2, half, fine)
    reference = (0.54 + 0.46 * np.cos(np.pi * t / half)) * np.exp(1j * np.pi * band / (2 * half) * t**2)
    result = np.empty(of.radar.bins, dtype=np.complex128)
    for n in range(of.radar.bins):
        at = t + (n + 0.5) / of.radar.sample_rate
        arriving = np.where((at >= max(begin, heard_from)) & (at < end), np.exp(1j * carrier(at)), 0.0)
        result[n] = np.sum(arriving * np.conj(reference)) / (0.54 * t.size)
    return result


def difference_db(profile: Complexes, expected: Complexes) -> float:
    """Of a profile from an expected one of any amplitude and phase [dB]."""
    fitted = np.vdot(expected, profile) / np.vdot(expected, expected) * expected
    return float(10 * np.log10(np.sum(np.abs(profile - fitted) ** 2) / np.sum(np.abs(profile) ** 2)))


def test_a_chirps_filter_smears_a_dash() -> None:
    """T, a dash of 3 us 2 MHz off the carrier, to a 4 us chirp: its leading edge follows that of the chirp, so it begins 2 us
    before the echo's delay, and the filter spreads it over 4 us more. -34 dB: the band of 20 MHz cuts the edges of the dash."""
    beacon = {"racon": RACON | {"letter": "T", "tuning_error_hz": 2e6}}
    of = made(beacon, CHIRP | {"range_max_m": 3000}, distance=1500.0)
    begin = 2 * 1500.0 / LIGHT + 0.4e-6 - 2e-6
    expected = in_time(of, lambda t: 2 * np.pi * 2e6 * t, begin, begin + 3e-6)
    profile = rows(of)[0]
    assert difference_db(profile, expected) < -34
    strong = ranges(of)[np.abs(profile) > 0.1 * np.abs(profile).max()]
    assert strong[0] < 1500.0 - 400.0 and np.ptp(strong) > 600.0


def test_a_sweep_through_a_chirps_filter() -> None:
    """The first slow sweep of a SART, 40 MHz each us, against the sum in time, about where it passes the carrier: there the fast
    sweeps before and after it are too far off. -26 dB: the sampled band cuts the reference off."""
    of = made({"sart": {"delay_s": 0.4e-6}}, CHIRP | {"range_max_m": 2400}, distance=400.0)
    begin = 2 * 400.0 / LIGHT + 0.4e-6 - 2e-6 + 0.4e-6
    passes = begin + 7.5e-6 * 0.7
    expected = in_time(of, lambda t: np.pi * 40e12 * (t - passes) ** 2, begin, begin + 7.5e-6)
    near = np.abs(ranges(of) * 2 / LIGHT - passes) < 0.3e-6
    assert difference_db(rows(of)[0][near], expected[near]) < -26


def test_one_antenna_hears_nothing_while_it_transmits() -> None:
    """A racon at 150 m, whose answer begins 0.6 us before the 4 us chirp has gone out."""
    beacon = {"racon": RACON | {"letter": "T"}}
    of = made(beacon, CHIRP | {"range_max_m": 2000, "eclipsing": True}, distance=150.0)
    begin = 2 * 150.0 / LIGHT + 0.4e-6 - 2e-6
    assert begin < 2e-6
    expected = in_time(of, lambda t: 0.0 * t, begin, begin + 3e-6, heard_from=2e-6)
    heard = in_time(of, lambda t: 0.0 * t, begin, begin + 3e-6)
    assert difference_db(rows(of)[0], expected) < -20 < difference_db(rows(of)[0], heard) + 15


def test_dots_of_a_sart() -> None:
    """12 slow dots, c/2 x 7.9 us = 1184.2 m apart, the first where the sweep passes 9.41 GHz; 12 fast ones, 750 MHz each us. In a
    receiver that a sweep crosses at once these are fainter by the rates of both, 12.7 dB. Peaks lie within half a sample."""
    receiver = {"bandwidth_hz": 1.5e6, "pulse_s": 0.5e-6, "sample_rate_hz": 30e6, "range_max_m": 17_000}
    of = made({"sart": {}}, receiver, distance=2000.0)
    profile, where = np.abs(rows(of)[0]), ranges(of)
    begin = 2000.0 + LIGHT / 2 * (0.5e-6 - 0.25e-6)
    levels = []
    for offset in (0.4e-6 + 7.5e-6 * 0.7, 0.4e-6 * 0.3):
        places = begin + LIGHT / 2 * (offset + 7.9e-6 * np.arange(12))
        windows = [np.abs(where - place) < 30.0 for place in places]
        peaks = np.array([where[window][np.argmax(profile[window])] for window in windows])
        np.testing.assert_allclose(peaks, places, atol=0.51 * of.radar.range_step)
        levels.append(20 * np.log10(np.median([profile[window].max() for window in windows])))
    assert levels[0] - levels[1] == pytest.approx(10 * np.log10(750 / 40), abs=1.0)
    assert profile[where < begin - 500.0].max() < 1e-3 * profile.max()
    assert profile[where > begin + 94.8e-6 * LIGHT / 2 + 500.0].max() < 1e-3 * profile.max()


@pytest.mark.parametrize("distance", [300.0, 5000.0])
def test_arcs_are_as_wide_as_the_beam_triggers(distance: float) -> None:
    """25 kW and 30 dBi on -50 dBm and a Taylor pattern of 30 dB: 5 km off an arc, 300 m off sidelobes fill most of the circle.
    Each azimuth answers whose gain reaches -50 dBm."""
    of = made({"sart": {}}, distance=distance)
    boresight, _ = of.radar.schedule(np.arange(360))
    gain = of.radar.pattern.gain((boresight + np.pi) % (2 * np.pi) - np.pi, of.radar.beamwidth)
    pulse_dbm = 10 * np.log10(25e6) + 30.0 - 32.45 - 20 * np.log10(distance / 1e3 * 9410.0) + 10 * np.log10(gain + 1e-30)
    answered = rows(of)
    certain = np.abs(pulse_dbm + 50.0) > 0.05
    np.testing.assert_array_equal(np.isin(np.arange(360), [*answered])[certain], (pulse_dbm > -50.0)[certain])
    assert len(answered) > 200 if distance < 1000 else len(answered) < 60


@pytest.mark.parametrize("beacon", [{"racon": RACON}, {"sart": {}}])
def test_samples_are_those_of_a_receiver_that_samples_faster(beacon: dict[str, Any]) -> None:
    """A plain pulse is sampled behind its filter, so every third sample of 36 MHz is one of 12 MHz, the edges of the
    band that fold there included. 4e-6: folds count to 30 MHz off, where this Gaussian receiver is down by 108 dB."""
    band = {"bandwidth_hz": 10e6, "range_max_m": 5000}
    slow, fast = (rows(made(beacon, band | {"sample_rate_hz": fs}, 1000.0))[0] for fs in (12e6, 36e6))
    count = min(len(slow), len(fast[1::3]))
    np.testing.assert_allclose(slow[:count], fast[1::3][:count], rtol=0, atol=4e-6 * np.abs(slow).max())


def test_what_begins_beyond_the_profile_is_smeared_into_it() -> None:
    """A dash that a 4 us chirp's filter gets 100 m beyond the last sample begins 300 m, half a chirp, before that."""
    of = made({"racon": RACON | {"letter": "T"}}, CHIRP | {"range_max_m": 2000}, distance=2340.0)
    begin = 2 * 2340.0 / LIGHT + 0.4e-6 - 2e-6
    assert begin * LIGHT / 2 > ranges(of)[-1] + 90
    expected = in_time(of, lambda t: 0.0 * t, begin, begin + 3e-6)
    assert difference_db(rows(of)[0], expected) < -25


def test_marks_are_as_wide_as_the_receiver_sees_them() -> None:
    """Beside the middle an answer loses the gain of the antenna once, where an echo loses it twice."""
    of = made({"racon": RACON})
    answered = rows(of)
    two_degrees = np.abs(answered[2]).max() / np.abs(answered[0]).max()
    assert 20 * np.log10(two_degrees) == pytest.approx(-3.01, abs=0.01)  # half the beamwidth off


@pytest.mark.parametrize(
    "beacon, radar",
    [
        ({"sart": {}}, {"frequency_hz": 3.05e9}),
        ({"racon": RACON, "position_m": [0, 6500, 15]}, {}),
        ({"racon": RACON | {"mode": "sweep", "sweep_s": 3600.0}}, {}),
        ({"racon": RACON | {"power_dbm": -60.0}, "position_m": [0, 5900, 15]}, {"noise_figure_db": 40}),
    ],
)
def test_no_answer(beacon: dict[str, Any], radar: dict[str, Any]) -> None:
    """Out of its band, beyond the profile, at the other end of its sweep, far below the noise."""
    assert not rows(made(beacon, radar))


def test_a_swept_racon_answers_as_it_passes() -> None:
    """From 9.3 to 9.5 GHz in 40 s: in the 20 MHz about 9.41 GHz from 20 s to 24 s; scans of 2.5 s."""
    of = made({"racon": RACON | {"mode": "sweep", "sweep_s": 40.0}})
    strength = {scan: max((np.abs(row).max() for row in rows(of, scan).values()), default=0.0) for scan in range(16)}
    strongest = max(strength, key=lambda scan: strength[scan])
    assert strongest == 9 and strength[9] > 30 * strength[5] and strength[2] == 0.0  # 22.5 s


def test_a_blind_sector_triggers_nothing_and_phases_are_keyed() -> None:
    of = made({"racon": RACON})
    assert not rows(of, blind=True)
    first, again, other = rows(of, 3)[0], rows(of, 3)[0], rows(of, 3, seed=1)[0]
    np.testing.assert_array_equal(first, again)
    assert np.abs(np.abs(first) - np.abs(other)).max() < 1e-12 * np.abs(first).max()
    assert np.abs(first - other).max() > 0.01 * np.abs(first).max()
    assert np.abs(first - rows(of, 4)[0]).max() > 0.01 * np.abs(first).max()
