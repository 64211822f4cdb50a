"""AIS messages, decoded by pyais; the checksum by a reader of its own."""

import math
from typing import Any

import pyais
import pytest

from radar_service.ports.ais.messages import (
    Bits,
    Position,
    aid_report,
    ais_sentences,
    class_a_position,
    class_a_static,
    class_b_position,
    class_b_static,
    position_of,
    rate_of_turn,
    static_of,
)
from radar_service.world.reporting import AisShip
from tests.ports.nmea.reading import fields_of

KNOT = 1852.0 / 3600.0
ROUNDING = 1e-6
PARTS = 600_000  # 1/10000 minutes in a degree


def ship(**more: Any) -> AisShip:
    values: dict[str, Any] = {
        "body": "ferry", "mmsi": 235_098_765, "station_class": "A", "name": "FERRY", "call_sign": "MABC7", "ship_type": 60,
        "imo": 9_074_729, "destination": "DOVER", "antenna": (0.0, 0.0), "to_bow": 140.2, "to_stern": 45.0, "to_port": 12.0,
        "to_starboard": 13.0, "draught": 6.37,
    }  # fmt: skip
    return AisShip(**values | more)


def at(**more: Any) -> Position:
    values: dict[str, Any] = {
        "second": 37, "latitude": 50.123_456_7, "longitude": -1.765_432_1, "course": 4.3, "speed": 12.34 * KNOT, "heading": 4.25,
        "turn_rate": math.radians(0.5),
    }  # fmt: skip
    return Position(**values | more)


def decoded(bits: Bits, kind: str = "VDM") -> Any:
    lines = ais_sentences(bits, kind, 3)
    for line in lines:
        assert fields_of(line)[0] == f"AI{kind}" and len(line) <= 82
    return pyais.decode(*lines)


def parts(degrees: float) -> int:
    """The whole number of 1/10000 minutes that was sent: pyais rounds degrees to six digits, 0.3 of it."""
    return round(degrees * PARTS)


def near(given: float, expected: float, digit: float, turn: float = 0.0) -> None:
    difference = given - expected
    assert abs(math.remainder(difference, turn) if turn else difference) <= 0.5 * digit + ROUNDING * digit


@pytest.mark.parametrize(
    "changes",
    [
        {}, {"latitude": 89.999_99, "longitude": 179.999_999_9}, {"latitude": -90.0, "longitude": -180.0}, {"course": 6.2831},
        {"heading": 6.2831, "turn_rate": math.radians(-3.0)}, {"latitude": -0.000_1, "longitude": 0.000_1, "second": 0},
        {"longitude": 181.5, "speed": 0.0}, {"turn_rate": math.radians(20.0), "speed": 102.2 * KNOT},
    ],
)  # fmt: skip
def test_each_number_of_a_position_is_within_half_of_its_last_bit(changes: dict[str, Any]) -> None:
    position = at(**changes)
    for make, kind in ((class_a_position, 1), (class_b_position, 18)):
        message = decoded(make(ship(), position))
        assert (message.msg_type, int(message.mmsi), message.second) == (kind, 235_098_765, position.second)
        assert position.latitude is not None and position.longitude is not None
        assert position.course is not None and position.heading is not None
        near(parts(message.lat), position.latitude * PARTS, 1.0)
        near(parts(message.lon), position.longitude * PARTS, 1.0, 360.0 * PARTS)
        near(message.speed, position.speed / KNOT, 0.1)
        near(message.course, math.degrees(position.course), 0.1, 360.0)
        near(message.heading, math.degrees(position.heading), 1.0, 360.0)
    message = decoded(class_a_position(ship(), position))
    assert message.status == (1 if position.speed == 0.0 else 0)


@pytest.mark.parametrize("degrees_a_minute", [0.0, 0.3, 7.0, -7.0, 180.0, -360.0, 707.0])
def test_the_turn_follows_its_root_law(degrees_a_minute: float) -> None:
    """The value is within a half of 4.733 sqrt(degrees a minute), with the sign of the turn."""
    value = rate_of_turn(math.radians(degrees_a_minute / 60.0))
    assert abs(value - math.copysign(4.733 * math.sqrt(abs(degrees_a_minute)), degrees_a_minute)) <= 0.5 + ROUNDING
    assert rate_of_turn(math.radians(900.0 / 60.0)) == 126 and rate_of_turn(-1.0) == -126
    turn = decoded(class_a_position(ship(), at(turn_rate=math.radians(degrees_a_minute / 60.0)))).turn
    assert turn == pytest.approx(math.copysign((value / 4.733) ** 2, value), abs=0.5 + ROUNDING)  # pyais rounds it


def test_what_is_not_known_has_its_number() -> None:
    message = decoded(class_a_position(ship(), at(latitude=None, longitude=None, course=None, heading=None)))
    assert (message.lat, message.lon, message.course, message.heading) == (91.0, 181.0, 360.0, 511)


def test_faster_than_the_scale_is_its_end() -> None:
    assert decoded(class_a_position(ship(), at(speed=300 * KNOT))).speed == 102.2


def test_the_static_report_of_class_a() -> None:
    message = decoded(class_a_static(ship()))
    assert message.msg_type == 5 and len(ais_sentences(class_a_static(ship()), "VDM", 0)) == 2
    assert (message.shipname, message.callsign, message.destination) == ("FERRY", "MABC7", "DOVER")
    assert (message.imo, message.ship_type, message.draught) == (9_074_729, 60, 6.4)
    assert (message.to_bow, message.to_stern, message.to_port, message.to_starboard) == (140, 45, 12, 13)
    assert (message.month, message.day, message.hour, message.minute) == (0, 0, 24, 60)


def test_the_static_reports_of_class_b() -> None:
    yacht = ship(station_class="B-CS", name="A VERY LONG NAME OF 28 CHARS", ship_type=36, call_sign="", to_bow=9.6)
    name, rest = (decoded(bits) for bits in class_b_static(yacht))
    assert (name.msg_type, name.partno, name.shipname) == (24, 0, "A VERY LONG NAME OF")
    assert (rest.msg_type, rest.partno, rest.ship_type, rest.to_bow, rest.to_starboard) == (24, 1, 36, 10, 13)
    assert decoded(class_b_position(yacht, at())).cs == 1
    assert decoded(class_b_position(ship(station_class="B-SO"), at())).cs == 0


def test_an_aid_to_navigation_reports_itself_by_type_21() -> None:
    """Its MMSI does not matter: its kind decides."""
    for mmsi in (992_350_001, 235_098_765):
        buoy = ship(kind="aid", mmsi=mmsi, name="FAIRWAY BUOY", aid_type=30, station_class="B-CS", to_bow=2.0, to_stern=2.0)
        message = decoded(position_of(buoy, at()))
        assert (message.msg_type, int(message.mmsi), message.aid_type) == (21, mmsi, 30)
        assert (message.name, message.second, message.to_bow, message.to_port) == ("FAIRWAY BUOY", 37, 2, 12)
        near(parts(message.lat), 50.123_456_7 * PARTS, 1.0)
        near(parts(message.lon), -1.765_432_1 * PARTS, 1.0)
        assert (message.off_position, message.virtual_aid) == (False, False) and static_of(buoy) == ()
    payload, fill = aid_report(buoy, at()).payload()
    assert 6 * len(payload) - fill == 272  # bits, of ITU-R M.1371-5 without an extension of the name


def test_a_sart_reports_itself_active_by_types_1_and_14() -> None:
    raft = ship(kind="sart", mmsi=970_010_001, station_class="B-SO")
    message = decoded(position_of(raft, at(speed=0.0)))
    assert (message.msg_type, int(message.mmsi), message.status) == (1, 970_010_001, 14)
    assert (message.turn, message.heading) == (-128.0, 511)
    (text,) = static_of(raft)
    assert (decoded(text).msg_type, decoded(text).text) == (14, "SART ACTIVE")
    assert decoded(position_of(ship(mmsi=970_010_001), at(speed=0.0))).status == 1  # a ship with such a number stays one


def test_own_ship_has_another_kind_of_sentence() -> None:
    message = decoded(class_a_position(ship(), at()), "VDO")
    assert message.msg_type == 1


def test_characters_without_a_code_are_told_so() -> None:
    assert decoded(class_a_static(ship(name="FÄHRE~"))).shipname == "F?HRE?"


def test_channels_and_groups_go_round() -> None:
    groups = [fields_of(ais_sentences(class_a_static(ship()), "VDM", k)[1])[1] for k in range(12)]
    assert [fields[2] for fields in groups] == [*"0123456789", "0", "1"] and {fields[3] for fields in groups} == {"A", "B"}
