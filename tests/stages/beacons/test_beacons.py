"""Beacons: racons and SARTs, each module under its name."""

import json
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar_feed import crossing_from_line
from radar_service.scene_file.describe import describe
from radar_service.stages.beacons.beacon import MORSE, S_BAND, X_BAND, Racon, Sart, morse_dots, morse_marks
from tests.scenes import point, scene

# beacon: morse code, timing and bands of racons and SARTs, against the code's own rules and the figures of M.824 and M.628.
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


# effect: beacons from scene files: units, defaults, and what `check` says of them.
def beacon(**keys: Any) -> Any:
    return scene([point("b", 0, 3000, **keys)]).bodies[0].effects.get("beacon")


def test_a_racon_with_its_defaults() -> None:
    """K has 9 dots: of 3704 m, a fifth of 10 NM, each has 411.6 m, 2.746 us. -50 dBm at the antenna."""
    made = beacon(racon={"letter": "K"})
    assert isinstance(made, Racon) and made.letters == "K" and made.bands == (X_BAND, S_BAND) and made.sweep is None
    assert made.dot == pytest.approx(3704 / 9 * 2 / LIGHT) and made.power == pytest.approx(1.0)
    assert made.sensitivity == pytest.approx(1e-8) and made.delay == 0.5e-6 and made.offset == (0.0, 0.0, 0.0)
    assert made.max_pulse is None and made.active(np.arange(100.0)).all()


def test_keys_of_a_racon() -> None:
    made = beacon(racon={"letter": "MO", "band": "s", "mode": "sweep", "sweep_s": 90, "dot_s": 2e-6, "power_dbm": 27.0,
                         "on_s": 12.0, "off_s": 36.0, "offset_m": [1, 2, 3], "max_pulse_s": 2e-6})  # fmt: skip
    assert (made.bands, made.sweep, made.dot, made.offset) == ((S_BAND,), 90.0, 2e-6, (1.0, 2.0, 3.0))
    assert (made.on, made.off, made.max_pulse) == (12.0, 36.0, 2e-6) and made.power == pytest.approx(0.501, abs=0.001)


def test_a_sart() -> None:
    """400 mW (M.628), -50 dBm at the antenna."""
    made = beacon(sart={"start_s": 30.0, "end_s": 60.0})
    assert isinstance(made, Sart) and (made.start, made.end) == (30.0, 60.0)
    assert made.power == pytest.approx(0.4, rel=0.01) and made.sensitivity == pytest.approx(1e-8)


@pytest.mark.parametrize(
    "keys, message",
    [
        ({"racon": {}}, "racon.letter"),
        ({"racon": {"letter": "k"}}, "racon.letter"),
        ({"racon": {"letter": "ABCD"}}, "racon.letter"),
        ({"racon": {"letter": "K", "color": 1}}, "racon.color"),
        ({"racon": {"letter": "K", "delay_s": -1e-9}}, "racon.delay_s"),
        ({"racon": {"letter": "K", "mode": "sweep", "tuning_error_hz": 1e6}}, "tuning_error_hz: this key is of mode"),
        ({"racon": {"letter": "K", "sweep_s": 60}}, "sweep_s: this key is of mode"),
        ({"racon": {"letter": "K", "dot_s": 5e-5}}, "dot_s: 5e-05 makes an answer longer than 200 us; give at most 2.2e-05"),
        ({"racon": {"letter": "K", "dot_s": 1e-6, "mark_m": 500}}, "dot_s: mark_m defines it too"),
        ({"racon": {"letter": "K", "on_s": 5}}, "on_s: it is never silent"),
        ({"sart": {"start_s": 5, "end_s": 4}}, "end_s: 4 is not after start_s 5"),
        ({"sart": {}, "racon": {"letter": "K"}}, "sart: a body has one beacon"),
    ],
)
def test_keys_that_do_not_fit(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message.replace("(", r"\(")):
        beacon(**keys)


def test_what_check_says() -> None:
    """25 kW and 30 dBi reach -50 dBm 126.8 km away: 74 + 30 + 50 = 153.98 dB of free space."""
    bodies = [
        point("tower", 0, 3000, racon={"letter": "K", "off_s": 40.0}),
        point("raft", 0, 2000, sart={"max_pulse_s": 1e-7}),
    ]
    text = describe(scene(bodies))
    assert 'racon: "K", dots of 412 m, agile, 20 s on and 40 s off; triggered within 127 km in free space' in text
    assert "sart: not triggered by this radar" in text


# effect: `check` warns of beacons that answer no radar, with the remedy, and of no others.
STRONG: dict[str, Any] = {"power_w": 10e3, "gain_dbi": 30.0, "range_max_m": 5000}
S_BAND_RADAR = STRONG | {"frequency_hz": 3.05e9}
K = {"racon": {"letter": "K"}}


def warnings(body: dict[str, Any], radar: Any, **sections: Any) -> list[str]:
    made = scene([point("mark", 0, 4000) | body], radar=radar, **sections)
    return [warning for warning in made.warnings if warning.startswith("body[0].")]


@pytest.mark.parametrize(
    "body, radar, expected",
    [
        (
            {"sart": {}}, S_BAND_RADAR,
            "body[0].sart: mark answers no radar of this scene, for it takes 9.2 to 9.5 GHz; give the radar such a frequency_hz",
        ),
        (
            {"racon": {"letter": "K", "band": "x"}}, S_BAND_RADAR,
            "body[0].racon: mark answers no radar of this scene, for it takes 9.3 to 9.5 GHz; give the radar such a "
            'frequency_hz or the racon band = "both"',
        ),
        (
            {"racon": {"letter": "K", "band": "x", "max_pulse_s": 1e-6}}, STRONG | {"pulse_s": 2e-6},
            "body[0].racon: mark answers no radar of this scene, for it takes 9.3 to 9.5 GHz and pulses up to 1e-06 s; raise "
            "max_pulse_s or shorten the radar's pulse",
        ),
        (
            K, STRONG | {"power_w": 0.2},
            "body[0].racon: mark is 4 km off, but the peak power of the radar's pulses triggers it within 0.359 km in free "
            "space; raise power_w of the radar or lower sensitivity_dbm",
        ),
    ],
)  # fmt: skip
def test_a_beacon_that_answers_nobody(body: dict[str, Any], radar: dict[str, Any], expected: str) -> None:
    """0.2 W and 30 dBi reach -50 dBm at 0.359 km: 53.01 + 50 - 32.45 - 20 log10(9410) - 20 log10(km) = 0."""
    assert warnings(body, radar) == [expected]


def test_no_warning_where_one_radar_is_enough() -> None:
    """An S-band set beside one of X band; 1.9 times the range of free space, as a sea may double the field; a ship that comes."""
    assert not warnings({"sart": {}}, [{"id": "x", **STRONG}, {"id": "s", **S_BAND_RADAR}])
    assert not warnings(K, STRONG | {"power_w": 0.2 * (4.0 / 0.359 / 1.9) ** 2})
    assert warnings(K, STRONG | {"power_w": 0.2 * (4.0 / 0.359 / 2.1) ** 2})
    assert not warnings(K, STRONG | {"power_w": 0.2}, own_ship={"speed_kn": 12})
    assert not warnings(K | {"speed_kn": 5.0}, STRONG | {"power_w": 0.2})
    near = {"modulation": "none", "bandwidth_hz": 5e6, "pulse_s": 0.2e-6, "range_max_m": 1800}
    far = {"modulation": "lfm", "bandwidth_hz": 5e6, "pulse_s": 2e-6}
    takes_the_near_pulse = {"racon": {"letter": "K", "max_pulse_s": 1e-6}}
    assert not warnings(takes_the_near_pulse, STRONG | {"sample_rate_hz": 15e6, "pulses": [near, far]})


# stage: what the truth says of beacons: against the one-way equation, the profile that the engine makes, and JSON lines.
RADAR = {"range_max_m": 6000, "azimuths": 360, "beamwidth_deg": 4, "rpm": 24, "modulation": "none", "bandwidth_hz": 20e6,
         "pulse_s": 0.1e-6, "sample_rate_hz": 60e6}  # fmt: skip
FLAT = {"earth": "flat"}
RACON = point("racon", 3000, 0, racon={"letter": "K", "dot_s": 1e-6})
SART = point("sart", 0, -2000, rcs_dbsm=-50.0, sart={"start_s": 2.0})
WALL = {"name": "wall", "shape": "box", "length_m": 300, "width_m": 2, "height_m": 40, "position_m": [1500, 0, 0]}


def crossings(*bodies: dict[str, Any], scan: int = 0, radar: Any = None) -> dict[str, Any]:
    sim = rs.Simulator(scene([*bodies], radar=RADAR | (radar or {}), environment=FLAT))
    return {crossing.body: crossing for crossing in sim.crossings(scan)}


def test_a_racon_as_the_beam_meets_it() -> None:
    """74 dBm and 30 dBi over 121.46 dB of free space: -17.5 dBm there; its 30 dBm give -61.5 dBm back. The mark begins c/2 x
    (0.5 - 0.05) us behind the echo and is 9 dots of 149.9 m long."""
    beacon = crossings(RACON)["racon"].effects["beacon"]
    assert (beacon.kind, beacon.letters, beacon.triggered, beacon.carrier_offset) == ("racon", "K", True, 0.0)
    assert beacon.pulse_dbm == pytest.approx(73.979 + 30 - 121.46, abs=0.006)
    assert beacon.answer_dbm == pytest.approx(30 + 30 - 121.46, abs=0.006)
    assert beacon.begin == pytest.approx(3000 + LIGHT / 2 * 0.45e-6, abs=1e-3)
    assert beacon.dot == pytest.approx(LIGHT / 2 * 1e-6) and beacon.end == pytest.approx(beacon.begin + 9 * beacon.dot)
    assert beacon.first_dot is None and beacon.dot_spacing is None


def test_a_sart_as_it_is_switched_on() -> None:
    """At 2 s, in the second half of its first scan of 2.5 s: the beam meets it at 1.25 s."""
    before, after = (crossings(SART, scan=scan)["sart"].effects["beacon"] for scan in (0, 1))
    assert (before.triggered, after.triggered) == (False, True) and after.kind == "sart" and after.letters is None
    assert after.first_dot == pytest.approx(2000 + LIGHT / 2 * (0.45e-6 + 0.4e-6 + 7.5e-6 * 0.7), abs=1e-3)
    assert after.dot_spacing / 1852 == pytest.approx(0.64, abs=0.001)


@pytest.mark.parametrize(
    "radar, others", [({}, [WALL]), ({"blind_sectors_deg": [[80, 100]]}, []), ({"frequency_hz": 5e9}, [])]
)
def test_it_is_not_triggered(radar: dict[str, Any], others: list[dict[str, Any]]) -> None:
    """Behind a wall, in a blind sector, on another carrier; the engine then adds no answer either. Sidelobes do not reach it."""
    racon = RACON | {"racon": {"letter": "K", "sensitivity_dbm": -25.0}}
    made = scene([racon, *others], radar=RADAR | radar, environment=FLAT)
    sim = rs.Simulator(made, labels=True)
    assert not next(crossing for crossing in sim.crossings(0) if crossing.body == "racon").effects["beacon"].triggered
    assert not (sim.scan().labels == 5).any()


def test_truth_and_picture_agree() -> None:
    """The strongest cells labelled as the racon's begin and end where the truth has the mark, to two cells of 2.5 m, while
    own ship and buoy move."""
    racon = RACON | {"course_deg": 200, "speed_kn": 12}
    made = scene([racon], radar=RADAR, own_ship={"course_deg": 50, "speed_kn": 15}, environment=FLAT | {"noise": True})
    sim = rs.Simulator(made, labels=True)
    for _ in range(3):
        scan = sim.scan()
    crossing = sim.crossings(2)[0]
    spoke = crossing.spoke % 360
    where = (np.arange(scan.power.shape[1]) + 0.5) * made.radar.range_step
    cells = where[(scan.labels[spoke] == 5) & (scan.power[spoke] > 0.25 * scan.power[spoke][scan.labels[spoke] == 5].max())]
    assert cells.min() == pytest.approx(crossing.effects["beacon"].begin, abs=5.1) and cells.max() == pytest.approx(
        crossing.effects["beacon"].end, abs=5.1
    )


def test_lines_have_a_beacon_where_there_is_one() -> None:
    of_beacon, of_none = (crossings(body)[body["name"]] for body in (RACON, point("p", 3000, 0)))
    assert "beacon" not in of_none.as_dict() and crossing_from_line(json.loads(json.dumps(of_none.as_dict()))) == of_none
    line = json.loads(json.dumps(of_beacon.as_dict()))
    assert line["beacon"]["letters"] == "K" and crossing_from_line(line) == of_beacon
    assert crossing_from_line(line | {"hail": {"size": 3}}).effects == of_beacon.effects | {
        "hail": {"size": 3}
    }  # not installed
