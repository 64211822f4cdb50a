"""Morse code, timing and bands of racons and SARTs, against the code's own rules and the figures of M.824 and M.628."""

import numpy as np
import pytest

from radar_service.stages.beacons.beacon import MORSE, S_BAND, X_BAND, Racon, Sart, morse_dots, morse_marks

LIGHT = 299_792_458.0
COMMON = {"offset": (0.0, 0.0, 0.0), "power": 1.0, "sensitivity": 1e-8, "delay": 0.5e-6}


def racon(letters: str = "K", **more: object) -> Racon:
    return Racon(**(COMMON | {"letters": letters, "dot": 2e-6, "bands": (X_BAND,)} | more))  # type: ignore[arg-type]


def sart(**more: object) -> Sart:
    return Sart(**(COMMON | more))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "letters, keyed",
    [("K", "111010111"), ("E", "1"), ("Q", "1110111010111"), ("MO", "1110111000111011101110"[:-1]), ("A", "10111")],
)
def test_letters_as_they_are_keyed(letters: str, keyed: str) -> None:
    """A dash is three dots, a gap one, a gap between letters three."""
    begin, length = morse_marks(letters)
    dots = np.zeros(morse_dots(letters), dtype=int)
    for at, size in zip(begin.astype(int), length.astype(int), strict=True):
        dots[at : at + size] = 1
    assert "".join(map(str, dots)) == keyed


def test_the_alphabet() -> None:
    """26 different codes of one to four marks; SOS and its marks."""
    assert len(MORSE) == 26 == len(set(MORSE.values())) and max(map(len, MORSE.values())) == 4
    assert MORSE["S"] == "..." and MORSE["O"] == "---"


def test_a_racon_keys_its_carrier_in_dots() -> None:
    pulses = racon("A", tuning_error=1e6).pulses(9.41e9, 3.0)
    np.testing.assert_allclose(pulses.begin, [0, 4e-6])
    np.testing.assert_allclose(pulses.length, [2e-6, 6e-6])
    np.testing.assert_array_equal([pulses.first, pulses.last], np.full((2, 2), 1e6))
    assert pulses.duration == pytest.approx(10e-6)


def test_a_swept_carrier_is_a_sawtooth_over_the_band_of_the_radar() -> None:
    """From 9.3 to 9.5 GHz in 72 s: at the radar's 9.41 GHz after 0.55 of it; in S band as fast, over 2.9 to 3.1 GHz."""
    swept = racon(sweep=72.0, bands=(X_BAND, S_BAND))
    assert swept.carrier_offset(9.41e9, 0.55 * 72.0) == pytest.approx(0.0, abs=1.0)
    assert swept.carrier_offset(9.41e9, 72.0 + 0.25 * 72.0) == pytest.approx(-60e6, abs=1.0)
    assert swept.carrier_offset(3.05e9, 71.999) == pytest.approx(50e6, abs=3e4)
    assert not swept.is_steady and racon().is_steady


def test_on_and_off_by_turns() -> None:
    time = np.array([0.0, 19.9, 20.1, 59.9, 60.1, 80.1])
    np.testing.assert_array_equal(racon(on=20.0, off=40.0).active(time), [1, 1, 0, 0, 1, 0])
    assert racon().active(time).all()
    np.testing.assert_array_equal(sart(start=19.9, end=60.0).active(time), [0, 1, 1, 1, 0, 0])
    assert sart().active(time).all()


@pytest.mark.parametrize(
    "beacon, x, s, long_pulse",
    [
        (racon(), True, False, True),
        (racon(bands=(X_BAND, S_BAND)), True, True, True),
        (racon(bands=(S_BAND,), max_pulse=2e-6), False, True, False),
        (sart(), True, False, True),
        (sart(max_pulse=2e-6), True, False, False),
    ],
)
def test_bands_and_pulses_that_trigger(beacon: Racon | Sart, x: bool, s: bool, long_pulse: bool) -> None:
    assert beacon.receives(9.41e9, 1e-6) is x and beacon.receives(3.05e9, 1e-6) is s
    assert (beacon.receives(9.41e9, 20e-6) or beacon.receives(3.05e9, 20e-6)) is long_pulse
    assert not beacon.receives(5.6e9, 1e-6)


def test_a_sart_sweeps_twelve_times() -> None:
    """12 x (0.4 + 7.5) us, fast down and slow up over 9.2 to 9.5 GHz: dots 0.64 NM apart, the first of slow sweeps within 0.64 NM
    of the SART, of fast ones within 150 m, 0.5 us of delay included (IMO SN/Circ.197)."""
    pulses = sart().pulses(9.41e9, 0.0)
    assert len(pulses.begin) == 24 and pulses.duration == pytest.approx(94.8e-6)
    np.testing.assert_allclose(pulses.begin[:3], [0.0, 0.4e-6, 7.9e-6])
    np.testing.assert_allclose(pulses.begin[1:] - (pulses.begin + pulses.length)[:-1], 0.0, atol=1e-18)
    np.testing.assert_allclose(pulses.first[:2] + 9.41e9, [9.5e9, 9.2e9])
    np.testing.assert_allclose(pulses.last[:2] + 9.41e9, [9.2e9, 9.5e9])
    assert 7.9e-6 * LIGHT / 2 / 1852 == pytest.approx(0.64, abs=0.005)
    first = sart().first_dot(9.41e9)
    assert first == pytest.approx(0.4e-6 + 7.5e-6 * 0.7)
    assert (first + 0.5e-6) * LIGHT / 2 < 0.64 * 1852 and (0.4e-6 + 0.5e-6) * LIGHT / 2 < 150.0
    assert sart().first_dot(9.5e9) == pytest.approx(7.9e-6)
