"""The short modules of the NMEA port, each under its name."""

import contextlib
import math
import socket
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pynmea2
import pytest

from radar_service.ports.nmea import listeners, sentences
from radar_service.ports.nmea.listeners import TcpSender, bound, may_come
from radar_service.ports.nmea.own_ship import (
    delayed_times,
    fast_sentences,
    readings_of,
    report,
    slow_sentences,
    spoke_before,
)
from radar_service.ports.udp.addresses import Address
from radar_service.records.truth import ShipStates
from radar_service.terminal.arguments import UsageError
from radar_service.world.scene import outline_of
from tests.ports.nmea.reading import fields_of, read
from tests.ports.nmea.test_senders import HERE, free_port
from tests.service.fake import scene


# listeners: who may connect, and how many.
def test_another_machine_needs_a_permission() -> None:
    for allowed, expected in (([], [False, False]), (["10.0.0.2"], [True, False]), (None, [True, True])):
        assert [may_come(host, allowed) for host in ("10.0.0.2", "10.0.0.3")] == expected
        assert all(may_come(host, allowed) for host in ("127.0.0.1", "::1", "::ffff:127.0.0.1"))
    assert may_come("::ffff:10.0.0.2", ["10.0.0.2"]) and not may_come("fe80::1%eth0", ["10.0.0.2"])


def test_a_machine_that_may_not_come_is_told_so(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    monkeypatch.setattr(listeners, "is_loopback", lambda host: False)
    listener = TcpSender("--nmea-tcp", Address(HERE, free_port()), [])
    with contextlib.closing(socket.create_connection(listener.address, timeout=10)) as client:
        while not listener.refused:
            listener.accept()
        assert fields_of(client.recv(100)) == ("RATXT", ["01", "01", "01", "this machine is not allowed"])
    assert [record.message for record in caplog.records] == ["client refused"] and not listener.clients
    listener.close()


def test_what_fails_after_a_socket_is_bound_closes_it() -> None:
    def prepare(opened: socket.socket) -> None:
        raise OSError(19, "No such device")

    where = Address(HERE, free_port())
    with pytest.raises(UsageError, match="--x: .* cannot be opened \\(No such device\\)"):
        bound("--x", where, socket.SOCK_STREAM, prepare)
    bound("--x", where, socket.SOCK_STREAM, lambda opened: None).close()


# own_ship: own ship as its sensors report it at one instant.
SCENE = outline_of(scene())
START = datetime(2028, 2, 28, 23, 59, 59, tzinfo=UTC)
STATES = ShipStates(
    np.array([0.0, 1.0]), np.zeros((2, 3)), np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]), np.array([0.5, 0.0]), np.zeros(2),
    np.ones(2, dtype=np.bool_),
)  # fmt: skip


def test_a_leap_day_begins() -> None:
    made = report(START, STATES, 1, replace(SCENE, origin=(0.0, 0.0)), readings_of(STATES).part(slice(1, 2)), (0.0, 0.0))
    assert (made.utc.month, made.utc.day, made.position) == (2, 29, (0.0, 0.0))


def test_components_are_from_the_bow() -> None:
    """5 m/s to the north-east by east, the bow at north; the log shows 10 m/s."""
    true = readings_of(STATES).part(slice(1, 2))
    assert true.course[0] == pytest.approx(math.atan2(3.0, 4.0), rel=1e-15)
    streaming = replace(SCENE, origin=None, stream=(3.0, 0.0))
    made = report(START, STATES, 1, streaming, true._replace(speed=true.speed + 5.0), (0.0, 0.0))
    assert made.ground == pytest.approx((8.0, 6.0), rel=1e-12)
    assert made.water == pytest.approx((9.0, 0.0), abs=1e-12)
    assert made.position is None and len(slow_sentences(made)) == 5 and len(fast_sentences(made)) == 2


def test_the_course_of_who_stands_is_its_heading() -> None:
    assert readings_of(STATES).course[0] == 0.5


def test_a_sensor_with_latency_tells_of_an_earlier_spoke() -> None:
    radar = scene().radar  # 24 spokes in 2.5 s
    assert spoke_before(radar, 2.5).tolist() == [24] and spoke_before(radar, 2.49).tolist() == [23]
    assert delayed_times(radar, 2.5, 1.25).tolist() == [1.25] and delayed_times(radar, 0.3, 9.0).tolist() == [0.0]


# sentences: sentences, read by pynmea2 and by a reader of a few lines, with a checksum of its own.
KNOT = 1852.0 / 3600.0
HALF = 0.5 + 1e-6  # of the last digit, and the rounding of decimal numbers
YEAR_END = datetime(2026, 12, 31, 23, 59, 59, 900_000, tzinfo=UTC)


def test_the_checksum_is_that_of_an_independent_reader() -> None:
    """`read` adds the bits of each column, and takes those that are odd."""
    for line in (sentences.hdt(1.0), sentences.zda(YEAR_END), sentences.sentence("AI", "XYZ", "", "9;w", start="!")):
        assert read(line)
        with pytest.raises(ValueError, match="checksum"):
            read(line.replace(b",", b";", 1))
    assert sentences.checksum("") == 0 and sentences.checksum("AA") == 0 and sentences.checksum("AB") == 3


@pytest.mark.parametrize("degrees", [0.0, 0.004, 123.456, 359.994, 359.996, 359.9999999, 180.0])
def test_bearings_round_within_a_turn(degrees: float) -> None:
    text = sentences.bearing(math.radians(degrees))
    assert 0.0 <= float(text) < 360.0
    assert abs(math.remainder(float(text) - degrees, 360.0)) <= HALF * 0.01


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [(0.4, 0.4), (50.3, -1.4), (-33.999_999_999, 151.2), (89.123_456_78, 179.999_999_999), (-0.000_001, -179.5), (12.5, 180.0),
     (59.999_999_9, 359.999_999_99), (-90.0, -180.0)],
)  # fmt: skip
def test_positions_round_as_a_whole(latitude: float, longitude: float) -> None:
    """Never 60 minutes; 1e-5 minutes are 1.7e-7 degrees."""
    line = sentences.gga(YEAR_END, (latitude, longitude))
    message = pynmea2.parse(line.decode().strip(), check=True)
    assert abs(message.latitude - latitude) <= HALF * 1e-5 / 60
    assert abs(math.remainder(message.longitude - longitude, 360.0)) <= HALF * 1e-5 / 60
    kind, fields = fields_of(line)
    assert kind == "GPGGA" and float(fields[1][2:]) < 60.0 and float(fields[3][3:]) < 60.0
    assert (len(fields[1]), len(fields[3])) == (10, 11)


def test_each_sentence_is_what_pynmea2_reads() -> None:
    heading, course, speed = math.radians(271.234), math.radians(5.678), 7.3456 * KNOT
    ours = [
        sentences.hdt(heading), sentences.vtg(course, speed), sentences.rmc(YEAR_END, (-12.5, 45.25), course, speed),
        sentences.rot(math.radians(-1.5), True), sentences.vbw((speed, -0.5 * KNOT), (6.0 * KNOT, 0.25 * KNOT)),
        sentences.vhw(heading, speed), sentences.zda(YEAR_END),
    ]  # fmt: skip
    hdt, vtg, rmc, rot, vbw, vhw, zda = (pynmea2.parse(line.decode().strip(), check=True) for line in ours)
    assert (hdt.talker, float(hdt.heading), hdt.hdg_true) == ("HE", 271.23, "T")
    assert (float(vtg.true_track), float(vtg.spd_over_grnd_kts), float(vtg.spd_over_grnd_kmph)) == (5.68, 7.35, 13.60)
    assert (rmc.datetime, rmc.status, rmc.mode_indicator) == (YEAR_END, "A", "A")
    assert (float(rmc.spd_over_grnd), float(rmc.true_course)) == (7.35, 5.68)
    assert (float(rot.rate_of_turn), rot.status) == (-90.0, "A")
    assert [float(each) for each in vbw.data[:2] + vbw.data[3:5]] == [7.35, -0.5, 6.0, 0.25]
    assert (vbw.data_validity_water_spd, vbw.data_validity_grnd_spd) == ("A", "A")
    assert (float(vhw.heading_true), float(vhw.water_speed_knots), float(vhw.water_speed_km)) == (271.23, 7.35, 13.60)
    assert (zda.datestamp.isoformat(), zda.timestamp.isoformat()) == ("2026-12-31", "23:59:59.900000+00:00")


def test_ths_and_a_lost_heading() -> None:
    """pynmea2 does not know THS."""
    assert fields_of(sentences.ths(math.radians(359.996))) == ("HETHS", ["0.00", "A"])
    assert fields_of(sentences.ths(None)) == ("HETHS", ["", "V"])
    assert fields_of(sentences.vhw(None, 1.0))[1][0] == "" and fields_of(sentences.rot(0.0, False))[1] == ["0.00", "V"]
    assert fields_of(sentences.vtg(None, 0.0))[1][0] == ""


def test_no_sentence_is_longer_than_the_standard_allows() -> None:
    """82 characters with `$` and line end."""
    far = (-89.999_99, -179.999_99)
    longest = [
        sentences.rmc(YEAR_END, far, 6.28, 999.99 * KNOT), sentences.gga(YEAR_END, far), sentences.vtg(6.28, 999.99 * KNOT),
        sentences.vbw((-999.0, -999.0), (-999.0, -999.0)), sentences.zda(YEAR_END),
    ]  # fmt: skip
    assert max(map(len, longest)) <= 82 and all(line.endswith(b"\r\n") for line in longest)


def test_small_numbers_have_no_sign() -> None:
    assert sentences.fixed(-0.001, 2) == "0.00" and sentences.fixed(-0.006, 2) == "-0.01"
