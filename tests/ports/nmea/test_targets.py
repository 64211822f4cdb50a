"""Bodies in sight as TTM and TLL, named as truth, on request and with `--truth` alone."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import pynmea2
import pytest

from radar_service.commands.command_line import parser
from radar_service.ports import registry
from radar_service.ports.nmea.targets import MAX_TARGETS, closest_approach, label, target_sentences
from radar_service.records.truth import BodyTruth, Truth
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.reading import fields_of
from tests.ports.nmea.test_nmea_port import close, simulator_of, started

KNOT = 1852.0 / 3600.0
UTC_NOW = datetime(2026, 5, 4, 3, 2, 1, tzinfo=UTC)
OWN = {"speed_kn": 8, "course_deg": 30}
BODIES = [
    {"name": "ferry, *big*", "shape": "point", "rcs_dbsm": 30, "position_m": [300, 200, 5], "speed_kn": 17.3, "course_deg": 250},
    {"name": "behind the horizon", "shape": "point", "rcs_dbsm": 30, "position_m": [9000, 0, 5]},
    {"name": "buoy", "shape": "point", "rcs_dbsm": 3, "position_m": [0, 400, 3]},
]  # fmt: skip


def test_each_number_is_the_truth() -> None:
    simulator = simulator_of(OWN, body=BODIES)
    truth = simulator.truth(4.0)
    lines = target_sentences(truth, UTC_NOW)
    assert [fields_of(line)[0] for line in lines] == ["RATTM", "RATLL"] * 2 and max(map(len, lines)) <= 82
    ttm = [pynmea2.parse(line.decode().strip(), check=True) for line in lines[::2]]
    tll = [fields_of(line)[1] for line in lines[1::2]]
    for message, place, body in zip(ttm, tll, (truth.bodies[0], truth.bodies[2]), strict=True):
        close(message.distance, body.range / 1852, 0.001)
        close(message.bearing, math.degrees(body.azimuth), 0.01, 360.0)
        close(message.speed, body.speed / KNOT, 0.1)
        close(message.cog, math.degrees(body.course), 0.01, 360.0)
        assert (message.name[:6], message.status, message.data[9]) == ("TRUTH ", "T", "N")
        assert body.latitude_deg is not None and body.longitude_deg is not None
        close(float(place[1][:2]) + float(place[1][2:]) / 60, body.latitude_deg, 1e-5 / 60)
        close(float(place[3][:3]) + float(place[3][3:]) / 60, -body.longitude_deg, 1e-5 / 60)
        assert (place[2], place[4], place[6]) == ("N", "W", "030201.00")
    assert [int(message.target_number) for message in ttm] == [1, 3]  # 2 is out of sight
    crossing = next(c for c in simulator.crossings(1) if c.body == "ferry, *big*")
    here = simulator.truth(crossing.time)
    cpa, tcpa = closest_approach(here.bodies[0], here.own_ship)
    assert (cpa, tcpa) == pytest.approx((crossing.cpa, crossing.tcpa), rel=1e-9)  # rounding; other code computes these
    close(ttm[0].dist_cpa, closest_approach(truth.bodies[0], truth.own_ship)[0] / 1852, 0.01)


def test_names_are_marked_and_have_no_reserved_characters() -> None:
    assert label("a, *b*") == "TRUTH a   b" and label("f\u00e4hr\n") == "TRUTH f?hr"
    assert len(label("x" * 200)) == 11 and label("") == "TRUTH"


def test_a_name_is_the_same_in_each_sentence_however_long_the_numbers_are() -> None:
    """11 characters are what the longest TTM of 82 characters has room for."""
    truth = simulator_of(OWN, body=BODIES).truth(0.0)
    own = replace(truth.own_ship, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    named, lengths = set(), set()
    for miles, knots in ((0.2, 9.0), (99.4, 99.4), (99.9996, 99.96), (107.9, 1234.0)):
        far = replace(truth.bodies[0], position=(0.8 * miles * 1852, 0.6 * miles * 1852, 5.0), range=miles * 1852, azimuth=6.0,
                      speed=knots * KNOT, velocity=(0.0, knots * KNOT, 0.0), course=6.28)  # fmt: skip
        lines = target_sentences(Truth(0.0, own, (far,)), UTC_NOW)
        ttm, tll = (fields_of(line)[1] for line in lines)
        named |= {ttm[10], tll[5]}
        lengths |= {len(line) for line in lines}
        close(float(ttm[1]), miles, 0.01 if miles > 99.5 else 0.001)
        close(float(ttm[4]), knots, 1.0 if knots > 99.5 else 0.1)
        close(float(ttm[7]), 0.8 * miles, 0.01)
    assert named == {"TRUTH ferry"} and max(lengths) == 82


def test_who_keeps_its_distance_has_no_time() -> None:
    own = simulator_of(OWN, body=BODIES).truth(0.0)
    same = replace(own.bodies[0], velocity=own.own_ship.velocity)
    assert closest_approach(same, own.own_ship) == (pytest.approx(math.hypot(300, 200), rel=1e-12), None)
    line = target_sentences(Truth(0.0, own.own_ship, (same,)), UTC_NOW)[0]
    assert fields_of(line)[1][8] == ""


def test_numbers_have_two_digits() -> None:
    own = simulator_of(OWN, body=BODIES).truth(0.0)
    body: BodyTruth = own.bodies[0]
    lines = target_sentences(Truth(0.0, own.own_ship, (body,) * 150), UTC_NOW)
    assert len(lines) == 2 * MAX_TARGETS


def test_they_come_each_second_on_request_alone() -> None:
    simulator = simulator_of(OWN, body=BODIES)
    port, kept = started(simulator)
    port.tick("0", 3.0)
    assert not any(b"TRUTH" in line for line in kept.pieces)
    port, kept = started(simulator, tells_truth=True)
    for time in (0.0, 1.25, 2.55):
        port.tick("0", time)
    times = [fields_of(line)[1][13] for line in kept.pieces if b"TTM,01" in line]
    assert times == ["235930", "235931", "235932"]


def test_the_truth_must_be_allowed() -> None:
    def opened(*words: str) -> Any:
        return registry.opened(parser().parse_args(["serve", "--nmea-udp", "9", *words]))

    with pytest.raises(UsageError, match="--nmea-truth: .* --truth"), opened("--nmea-truth"):
        pass
    with opened("--nmea-truth", "--truth") as ports:
        assert "nmea" in [port.name for port in ports]
