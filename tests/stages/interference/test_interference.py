"""Other radars: in a scene file, and their pulses in spokes."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.stages.interference.stage import Arrivals, Interference
from tests.scenes import scene


# effect: other radars in a scene file.
def test_an_interfering_radar_in_si_units() -> None:
    (other,) = scene(interference=[{"bearing_deg": 90, "level_db": 20, "rpm": 30}]).effects["interference"]
    assert (other.position, other.rotation_period) == (None, 2.0)
    assert (other.bearing, other.level) == (pytest.approx(np.pi / 2), pytest.approx(100.0))


# stage: pulses of another radar: when they arrive, how loud, in which shape; against arithmetic and a sum in time of its own.
LIGHT = 299_792_458.0
RADAR = {"range_max_m": 3000, "azimuths": 720, "beamwidth_deg": 4, "rpm": 24}
OTHER = {"bearing_deg": 40, "prf_hz": 2000.3, "rpm": 31, "level_db": 60, "beamwidth_deg": 2}
EVERYWHERE = [[0.0, 0.0], [180.0, 0.0]]  # a pattern that receives all round


def made(radar: dict[str, Any] | None = None, **other: Any) -> rs.Scene:
    return scene([], radar=RADAR | (radar or {}), interference=[OTHER | other])


def one(of: rs.Scene, seed: int = 0) -> Interference:
    return Interference(of, 0, seed)


def received(of: rs.Scene, scans: int, seed: int = 0) -> tuple[Arrivals, NDArray[np.float64]]:
    """All arrivals of some scans, rows counted from the start, and the time of each row."""
    number = np.arange(scans * of.radar.azimuths)
    boresight, time = of.radar.schedule(number)
    return one(of, seed).arrivals(boresight, time), time


def lone_pulses(of: rs.Scene, since: float, until: float) -> tuple[Arrivals, NDArray[np.complex64], list[int]]:
    """The arrivals of a scan, its profiles, and which arrivals between two delays [s] are alone in theirs."""
    boresight, time = of.radar.schedule(np.arange(720))
    result, profiles = one(of).arrivals(boresight, time), np.zeros((720, of.radar.bins), dtype=np.complex64)
    for row, pulses in one(of).rows(boresight, time):
        profiles[row] += pulses
    alone = [w for w, row in enumerate(result.row) if np.sum(result.row == row) == 1 and since < result.delay[w] < until]
    return result, profiles, alone


def test_pulses_keep_their_own_time() -> None:
    """Arrival times are a fixed lag plus whole intervals of 1 / 2000.3 s, and every one that falls into a listening time
    (20 us of range) is there: 720 x 40 azimuths receive during 2000.3 x (20.0 + 2 x 5.1) us each, 5 sigma of a Poisson count."""
    result, time = received(made({"pattern": EVERYWHERE}, beamwidth_deg=90, level_db=140), 40)
    arrived = time[result.row] + result.delay
    whole = (arrived - arrived[0]) * 2000.3
    np.testing.assert_allclose(whole, np.rint(whole), atol=1e-6)
    window = 2 * np.ceil(3000 / 1.99862) * 1.99862 / LIGHT + 10.25e-6
    expected = 40 * 720 * 2000.3 * window
    assert len(result.row) == pytest.approx(expected, abs=5 * np.sqrt(expected))


def test_rows_of_dots_are_the_drift_of_one_clock_against_the_other() -> None:
    """2000 own pulses a second, a spoke every 6.944 of them: the nearest one makes the profile. Whoever sends at
    just 2000 Hz arrives at one delay for ever; at 2000.5 Hz each own interval moves it by the difference of the two."""
    locked = made({"pattern": EVERYWHERE, "prf_hz": 2000.0}, prf_hz=2000.0, beamwidth_deg=90, level_db=140)
    for seed in range(200):
        result, _ = received(locked, 1, seed)
        if len(result.row):
            break
    assert len(result.row) == 720
    np.testing.assert_allclose(result.delay, result.delay[0], atol=1e-12)
    drifting = made({"pattern": EVERYWHERE, "prf_hz": 2000.0}, prf_hz=2000.5, beamwidth_deg=90, level_db=140)
    result, time = received(drifting, 2, 3)
    next_to = np.flatnonzero(np.diff(result.row) == 1)
    intervals = np.diff(np.rint(time * 2000.0))[result.row[next_to]]
    np.testing.assert_allclose(np.diff(result.delay)[next_to], intervals * (1 / 2000.5 - 1 / 2000.0), atol=1e-12)


def test_the_level_is_as_declared_when_both_beams_meet() -> None:
    """Heard all round, the other's turning beam brings 60 dB over the noise once a turn, and half of it (3.01 dB) half its
    beamwidth (7.5 degrees) to either side; 0.05 dB: it turns 0.1 degrees from spoke to spoke."""
    of = made({"pattern": EVERYWHERE}, prf_hz=20_000.0, rpm=12, beamwidth_deg=15)
    result, time = received(of, 2)
    level = 10 * np.log10(np.abs(result.amplitude) ** 2 / rs.Simulator(of).noise_power)
    assert level.max() == pytest.approx(60.0, abs=0.05) and level.max() <= 60.0
    arrived = time[result.row] + result.delay
    above = arrived[level > 60 - 3.0103]
    assert np.ptp(above) == pytest.approx(15 / 360 * 5.0, abs=2 * 2.5 / 720)


def test_own_beam_weighs_what_arrives() -> None:
    """The other's beam hardly moves while own one sweeps over it: levels follow the sinc^2 of own 4-degree beam, one way."""
    of = made(prf_hz=20_000.0, rpm=0.01, beamwidth_deg=90, level_db=100)
    result, _ = received(of, 1, seed=4)
    offset = of.radar.schedule(result.row)[0] - np.deg2rad(40)
    gain = np.sinc(0.885893 / np.deg2rad(4) * ((offset + np.pi) % (2 * np.pi) - np.pi)) ** 2
    sure = gain > 1e-4
    level_db = 10 * np.log10(np.abs(result.amplitude[sure]) ** 2 / gain[sure])
    assert sure.sum() > 20 and np.ptp(level_db) < 0.05  # the other's beam turns by 0.15 degrees of its 90 meanwhile


def test_shape_is_the_correlation_with_the_chirp() -> None:
    """Slow reference: the pulse as it arrives, correlated in time with the windowed chirp, every nanosecond; -40 dB of its energy
    (edges of 1/250 of the pulse, and what the sampled band cuts off)."""
    of = made({"pattern": EVERYWHERE, "pulse_s": 4e-6}, beamwidth_deg=90, level_db=140, frequency_offset_hz=3e6)
    result, profiles, (which, *_) = lone_pulses(of, 5e-6, 14e-6)
    fine = 1e-9
    t = np.arange(-2e-6 + fine / 2, 2e-6, fine)
    reference = (0.54 + 0.46 * np.cos(2 * np.pi * t / 4e-6)) * np.exp(1j * np.pi * 50e6 / 4e-6 * t**2)
    delays = (np.arange(of.radar.bins) + 0.5) / 75e6
    expected = np.empty(of.radar.bins, dtype=np.complex128)
    for n, delay in enumerate(delays):
        since = t + delay - result.delay[which]
        pulse = np.where(np.abs(since) <= 0.125e-6, np.exp(2j * np.pi * 3e6 * since), 0)
        expected[n] = np.sum(pulse * np.conj(reference)) / (0.54 * t.size)
    error = profiles[result.row[which]] - result.amplitude[which] * expected
    assert np.sum(np.abs(error) ** 2) < 1e-4 * np.sum(np.abs(result.amplitude[which] * expected) ** 2)


def test_a_like_pulse_passes_a_plain_receiver_whole() -> None:
    """Own pulse 0.25 us without modulation, the other's the same: the peak is the amplitude that arrived, on whichever side
    of a sample it falls (0.4 dB: a third of a sample off the top of the filtered pulse)."""
    plain = {"modulation": "none", "bandwidth_hz": 5e6, "pulse_s": 0.25e-6, "sample_rate_hz": 40e6, "pattern": EVERYWHERE}
    of = made(plain, beamwidth_deg=90, level_db=100)
    result, profiles, inside = lone_pulses(of, 1e-6, 18e-6)
    assert len(inside) > 5
    for which in inside:
        profile = profiles[result.row[which]]
        assert 20 * np.log10(np.abs(profile).max() / np.abs(result.amplitude[which])) == pytest.approx(0.0, abs=0.4)
        assert int(np.argmax(np.abs(profile))) == pytest.approx(result.delay[which] * 40e6 - 0.5, abs=1.01)


def test_bearings_of_another_radar_follow_a_moving_own_ship() -> None:
    """1000 m east, own ship going north at 20 m/s: bearing 090 at first, 135 after 50 s (past the other's beam)."""
    own = {"position_m": [-500, 0], "course_deg": 0, "speed_kn": 20 / 0.514444}
    other = OTHER | {"position_m": [500, 0], "prf_hz": 20_000.0, "beamwidth_deg": 90, "rpm": 0.01}
    del other["bearing_deg"]
    of = scene([], radar=RADAR, own_ship=own, interference=[other])
    result, time = received(of, 21, seed=4)
    boresight = of.radar.schedule(result.row)[0]
    loud = np.abs(result.amplitude) > 0.5 * np.abs(result.amplitude).max()
    bearing = np.pi / 2 + np.arctan(20 * time[result.row] / 1000)
    assert np.rad2deg(np.abs(boresight - bearing)[loud]).max() < 4.0
    assert np.ptp(np.rad2deg(boresight[loud])) > 15


def test_in_the_profiles_it_is_added_and_reproducible() -> None:
    """Same seed same bytes, for any grouping; without the section nothing; loud against the noise where both beams meet: with
    this seed the other one looks here while the own beam passes over it."""
    of = made({"range_max_m": 1500}, prf_hz=20_000.0, rpm=200, beamwidth_deg=90, level_db=80)
    scans = [rs.Simulator(of, seed=5).scan() for _ in range(2)]
    np.testing.assert_array_equal(scans[0].field, scans[1].field)
    grouped = np.concatenate([b.field for b in rs.Simulator(of, seed=5, threads=2).blocks(scans=1, size=7)])
    np.testing.assert_array_equal(grouped, scans[0].field)
    assert not np.array_equal(rs.Simulator(of, seed=2).scan().field, scans[0].field)
    strongest = int(np.argmax(scans[0].power.max(axis=1)))
    assert abs(strongest - 80) <= 9 and scans[0].power[260:620].max() < scans[0].power.max() / 20
    assert rs.Simulator(scene([], radar=RADAR)).scan().power.max() == 0.0


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"bearing_deg": None}, "bearing_deg: an interfering radar needs exactly one of bearing_deg and position_m"),
        ({"position_m": [100, 100]}, "bearing_deg: an interfering radar needs exactly one of bearing_deg and position_m"),
        ({"pulse_s": 1e-4, "prf_hz": 5000}, "pulse_s: 0.0001 s at 5000 pulses a second transmits half the time or more"),
        ({"prf_hz": 1.0}, "prf_hz: "),
        ({"eirp": 3}, "eirp: "),
    ],
)
def test_impossible_settings_are_refused_with_their_key(wrong: dict[str, Any], text: str) -> None:
    section = {key: value for key, value in (OTHER | wrong).items() if value is not None}
    with pytest.raises(rs.SceneError) as refused:
        scene([], interference=[section])
    assert str(refused.value).startswith(f"interference[0].{text}")
