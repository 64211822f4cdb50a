"""Second-time-around echoes: a target at R > Ru appears at R - n Ru with the phase of its own pulse."""

import numpy as np
import pytest

from radar_service.echo.echoes import SECOND_TIME, AzimuthTimes, BeamWeightedEchoes
from radar_service.echo.second_time_around import apparent_range, fold_ranges, max_apparent_range, max_echo_range
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, radar, scene

LIGHT = 299_792_458.0
UNAMBIGUOUS = LIGHT / 2 / 40_000  # 3747 m
FOLDED = {"range_max_m": 3000, "prf_hz": 40_000, "second_time_around": True, "pulse_s": 1e-6, "azimuths": 720}
SPEED = 20.0  # m/s, away


def distance_at(start: float, time: np.ndarray) -> np.ndarray:
    return start + SPEED * time


def echoes_of(starts: list[float], wavelength: float):  # type: ignore[no-untyped-def]
    """Echoes of targets that recede from `starts`, of unit amplitude, for the pulses transmitted at given times."""

    def echoes(azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        each = np.array([distance_at(start, azimuths.time) for start in starts]).reshape(len(starts), -1)
        middle = each[:, len(azimuths.time) // 2]
        amplitude = np.exp(-4j * np.pi / wavelength * each).astype(np.complex64)
        return BeamWeightedEchoes(middle, (each - middle[:, None]).astype(np.float32), amplitude, np.arange(len(middle)))

    return echoes


def test_ranges_of_what_is_received() -> None:
    """range_max plus cT/2, 149.9 m, of sidelobes; nothing ends the range where second-time-around echoes are modelled."""
    plain, folded = radar(**{**FOLDED, "second_time_around": False}), radar(**FOLDED)
    assert max_apparent_range(plain) == max_echo_range(plain) == pytest.approx(3000 + 149.896, abs=1e-3)
    assert max_echo_range(folded) == np.inf and max_apparent_range(folded) == max_apparent_range(plain)


def test_apparent_ranges_lose_whole_intervals() -> None:
    distance = np.array([10.0, UNAMBIGUOUS - 1, UNAMBIGUOUS + 1, 2.3 * UNAMBIGUOUS])
    expected = [10.0, UNAMBIGUOUS - 1, 1.0, 0.3 * UNAMBIGUOUS]
    assert apparent_range(radar(**FOLDED), distance) == pytest.approx(expected, abs=1e-9)
    plain = radar(**{**FOLDED, "second_time_around": False})
    np.testing.assert_array_equal(apparent_range(plain, distance), distance)


def test_pulses_before_a_visibility_step_find_what_the_beam_meets_in_it() -> None:
    """A block at the start of a step, and the same 30 ms earlier, when its middle is in the step before: a point that its last
    boresight alone meets."""
    own = {"course_deg": 0, "speed_kn": 20}
    start = scene([point("t", 0, 2000)], radar=FOLDED, own_ship=own)
    prepared = prepare(start, PRESETS["fast"], 0)
    first = start.radar.first_spoke(prepared.moving.visibility.interval)
    number = first + np.arange(16)
    boresight, time = start.radar.schedule(number)
    bearing = boresight[-1] + 2.99 * start.radar.beamwidth
    made = scene([point("t", 9000 * np.sin(bearing), 9000 * np.cos(bearing))], radar=FOLDED, own_ship=own)
    moving = prepare(made, PRESETS["fast"], 0).moving
    for earlier in (0.0, 0.03):
        assert len(moving.echoes(AzimuthTimes(number, boresight, time - earlier)).range) == 1


@pytest.mark.parametrize("intervals", [0, 1, 2, 5])
def test_an_echo_has_the_range_and_phase_of_its_own_pulse(intervals: int) -> None:
    """A target that recedes is where it was when its pulse left, n intervals ago: 20 m/s for 25 us are 0.5 mm, 0.2 rad."""
    folded = radar(**FOLDED)
    time = 5.0 + np.arange(4) * 1e-3
    azimuths = AzimuthTimes(np.arange(4), np.zeros(4), time)
    start = (intervals + 0.4) * UNAMBIGUOUS
    parts = fold_ranges(echoes_of([start], folded.wavelength), azimuths, folded)
    received = [n for n, part in enumerate(parts) if len(part.range)]
    assert received == [intervals]
    assert parts[intervals].body.tolist() == [SECOND_TIME if intervals else 0]
    own = distance_at(start, time - intervals * 25e-6)
    part = parts[intervals]
    assert part.range[0] == pytest.approx(own[2] - intervals * UNAMBIGUOUS, abs=1e-8)
    turn = np.angle(part.amplitude[0] / np.exp(-4j * np.pi / folded.wavelength * own))
    assert np.abs(turn).max() < 1e-3  # float32 of the amplitude and rounding of 1e7 rad


def test_targets_of_several_intervals_are_all_received_once() -> None:
    """Also one whose apparent range changes from the end of an interval to the start of the next; none from the gap beyond
    range_max + cT/2."""
    folded = radar(**FOLDED)
    azimuths = AzimuthTimes(np.arange(3), np.zeros(3), np.array([0.0, 1e-3, 2e-3]))
    starts = [100.0, 0.9 * UNAMBIGUOUS, UNAMBIGUOUS + 0.01, 2.5 * UNAMBIGUOUS, 7.1 * UNAMBIGUOUS]
    parts = fold_ranges(echoes_of(starts, folded.wavelength), azimuths, folded)
    apparent = np.sort(np.concatenate([part.range for part in parts]))
    moved = SPEED * 1e-3
    expected = [0.01, 100.0, 0.1 * UNAMBIGUOUS, 0.5 * UNAMBIGUOUS]
    assert apparent == pytest.approx(np.array(expected) + moved, abs=SPEED * 8 * 25e-6)
    assert 0.9 * UNAMBIGUOUS > max_apparent_range(folded)


def test_without_second_time_around_echoes_pass_unchanged() -> None:
    plain = radar(**{**FOLDED, "second_time_around": False})
    azimuths = AzimuthTimes(np.arange(2), np.zeros(2), np.zeros(2))
    (part,) = fold_ranges(echoes_of([5000.0, 100.0], plain.wavelength), azimuths, plain)
    assert part.range.tolist() == [5000.0, 100.0]


def test_resting_echoes_fold_alike() -> None:
    """Two intervals and a half away, at the range of a half, with the phase and the level of the whole."""
    made = scene([point("t", 0, 2.5 * UNAMBIGUOUS)], radar=FOLDED, environment={"earth": "flat"})
    (distance,), (amplitude,) = (
        getattr(prepare(made, PRESETS["balanced"], 1).resting.echoes, name) for name in ("range", "amplitude")
    )
    whole = 2.5 * UNAMBIGUOUS
    assert distance == pytest.approx(0.5 * UNAMBIGUOUS, abs=1e-9)
    r = made.radar
    level = np.sqrt(r.power * r.gain**2 * r.wavelength**2 * 10 / (4 * np.pi) ** 3) / whole**2
    assert amplitude == pytest.approx(level * np.exp(-4j * np.pi * whole / r.wavelength), rel=1e-6)
