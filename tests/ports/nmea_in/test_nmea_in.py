"""NMEA 0183 in: sockets that read whole lines, and sentences as pynmea2, which shares no code, reads them."""

import contextlib
import random
import socket
import struct
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pynmea2
import pytest

from radar_service.ports.nmea.listeners import TcpSender
from radar_service.ports.nmea_in.receivers import (
    AT_ONCE,
    IDLE,
    MAX_CLIENTS,
    RATE,
    Receiver,
    TcpReceiver,
    UdpReceiver,
)
from radar_service.ports.nmea_in.sentence_reader import MAX_LINE, Reading, SentenceIgnoredError, SentenceLines, read
from radar_service.ports.udp.addresses import REJOIN, Address
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.reading import line
from tests.ports.nmea.test_senders import HERE, free_port

# sentence_reader: what is not a sentence is refused with a word.
ROUNDING = 1e-12  # of degrees up to 180: some ten times 2^-46
PLACE = "5030.12345,S,17959.99999,W"
PUBLISHED = [  # of the manuals of receivers: NMEA 0183 as others print it
    b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47",
    b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A",
    b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48",
]


def word(sentence: bytes) -> str:
    with pytest.raises(SentenceIgnoredError) as ignored:
        read(sentence)
    return str(ignored.value)


def test_published_sentences_are_read() -> None:
    gga, rmc, vtg = map(read, PUBLISHED)
    assert gga == Reading(position=(48 + 7.038 / 60, 11 + 31 / 60), clock=12 * 3600 + 35 * 60 + 19)
    assert rmc == Reading(None, 84.4, 22.4, gga.position, gga.clock)
    assert vtg == Reading(course_deg=54.7, speed_kn=5.5)


def test_drawn_sentences_are_read_as_pynmea2_reads_them() -> None:
    draw = random.Random(7)
    for _ in range(300):
        place = (
            f"{draw.randrange(90):02d}{draw.uniform(0, 59.9):08.5f},{draw.choice('NS')},"
            f"{draw.randrange(180):03d}{draw.uniform(0, 59.9):08.5f},{draw.choice('EW')}"
        )
        clock = f"{draw.randrange(24):02d}{draw.randrange(60):02d}{draw.uniform(0, 59):05.2f}"
        course, speed, talker = draw.uniform(0, 359.9), draw.uniform(0, 40), draw.choice(["GP", "GN", "II"])
        sentences = [
            line(f"{talker}RMC,{clock},A,{place},{speed:.2f},{course:.1f},010100,,,A"),
            line(f"{talker}GGA,{clock},{place},1,08,1.0,0.0,M,,M,,"),
            line(f"{talker}VTG,{course:.2f},T,,M,{speed:.3f},N,,K,A"),
            line(f"HEHDT,{course:.3f},T"),
        ]
        rmc, gga, vtg, hdt = map(read, sentences)
        theirs = [pynmea2.parse(sentence.decode(), check=True) for sentence in sentences]
        for ours, other in ((rmc, theirs[0]), (gga, theirs[1])):
            assert ours.position == pytest.approx((other.latitude, other.longitude), rel=0, abs=ROUNDING)
            seconds = other.timestamp.hour * 3600 + other.timestamp.minute * 60 + other.timestamp.second
            assert ours.clock == pytest.approx(
                seconds + other.timestamp.microsecond * 1e-6, rel=0, abs=1e-6
            )  # theirs ends there
        assert (rmc.course_deg, rmc.speed_kn) == (theirs[0].true_course, theirs[0].spd_over_grnd)
        assert (vtg.course_deg, vtg.speed_kn) == (theirs[2].true_track, float(theirs[2].spd_over_grnd_kts))
        assert hdt == Reading(heading_deg=float(theirs[3].heading))


def test_what_is_left_empty_is_not_known() -> None:
    assert read(line(f"GPRMC,120000,A,{PLACE},,,010126,,,A")).motion == {}
    assert read(line("GPVTG,,T,,M,0.00,N,,K,A")) == Reading(speed_kn=0.0)
    assert read(line("HETHS,12.5,A")).motion == {"heading_deg": 12.5}


@pytest.mark.parametrize(
    ("sentence", "reason"),
    [
        (b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*49", "checksum"), (b"$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K", "form"),
        (b"", "form"), (bytes(range(256)), "form"), (b"$" + b"A" * 400, "form"), (b"\xff" * 40, "form"),
        (line("HEHDT," + "1" * MAX_LINE + ",T"), "form"), (line("GPGSV,3,1,11"), "kind"), (line("XXHDT,12,T"), "talker"),
        (line("HEHDT,361,T"), "value"), (line("HEHDT,-1,T"), "value"), (line("HEHDT,nan,T"), "value"),
        (line("HEHDT,1e2,T"), "value"), (line("HEHDT,12,M"), "value"), (line("HEHDT,12"), "value"),
        (line("HEHDT,,T"), "invalid"), (line("HETHS,12.0,V"), "invalid"), (line("HETHS,,V"), "invalid"),
        (line(f"GPRMC,120000,V,{PLACE},1,2,010126,,,A"), "invalid"), (line(f"GPRMC,120000,A,{PLACE},1,2,010126,,,N"), "invalid"),
        (line(f"GPGGA,120000,{PLACE},0,0,,,M,,M,,"), "invalid"), (line("GPVTG,1,T,,M,2,N,,K,N"), "invalid"),
        (line("GPVTG,054.7,034.4,005.5,010.2,,,,"), "value"), (line(f"GPGGA,250000,{PLACE},1,8,,,M,,M,,"), "value"),
        (line("GPGGA,120000,5060.0,N,00100.0,W,1,8,,,M,,M,,"), "value"),
        (line("GPGGA,120000,9000.1,N,00100.0,W,1,8,,,M"), "value"),
        (line("GPGGA,120000,5000.0,,00100.0,W,1,8,,,M"), "value"), (line("GPGGA,120000,5000.0,N,18000.1,W,1,8,,,M"), "value"),
    ],
)  # fmt: skip
def test_what_is_not_followed_has_a_reason(sentence: bytes, reason: str) -> None:
    assert word(sentence) == reason


def test_one_wrong_bit_never_passes() -> None:
    """The checksum finds each; no reading comes of it."""
    sentence = line(f"GPRMC,120000.00,A,{PLACE},6.00,80.00,010126,,,A")
    for at in range(8 * len(sentence)):
        changed = bytearray(sentence)
        changed[at // 8] ^= 1 << at % 8
        if bytes(changed).upper() != sentence:  # the letters of the checksum may be small
            assert word(bytes(changed)) in ("form", "checksum")


def test_rubbish_has_no_other_outcome() -> None:
    draw = random.Random(3)
    for _ in range(2000):
        assert word(draw.randbytes(draw.randrange(120))) == "form"
        word(line("HEHDT," + "".join(chr(draw.randrange(32, 127)) for _ in range(9))))


def test_lines_come_whole_however_they_are_cut() -> None:
    text = b"one\r\n\r\ntwo\nthree\r\n" + b"x" * 1000 + b"\nfour\n"
    for size in (1, 2, 7, 300, 2000):
        lines = SentenceLines()
        got = [each for at in range(0, len(text), size) for each in lines.of(text[at : at + size])]
        assert [each for each in got if len(each) <= MAX_LINE] == [b"one", b"two", b"three", b"four"], size
        assert lines.too_long == (0 if size == 2000 else 1)  # whole at once it is a line, which `read` refuses


def test_ten_megabytes_without_an_end_keep_no_memory() -> None:
    lines = SentenceLines()
    for _ in range(640):
        assert lines.of(b"x" * 2**14) == [] and len(lines.rest) <= MAX_LINE
    assert lines.too_long == 1 and lines.of(b"\nnext\n") == [b"next"]


# receivers: whole lines of each sender, floods that are cut, ports that are taken.
class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


class Counts(Counter[str]):
    def __call__(self, word: str, times: int) -> None:
        self[word] += times


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def tcp(clock: Clock) -> Iterator[TcpReceiver]:
    with contextlib.closing(TcpReceiver("--nmea-in-tcp", Address(HERE, free_port()), [], clock)) as made:
        yield made


def received_lines(receiver: Receiver, expected: int, counts: Counts | None = None) -> list[bytes]:
    """The first received_lines that come, so many of them."""
    got: list[bytes] = []
    for _ in range(100_000):
        got += [line for each in receiver.received(counts if counts is not None else Counts()) for line in each.lines]
        if len(got) >= expected:
            return got
    raise AssertionError(got)


def dialled(receiver: TcpReceiver) -> socket.socket:
    return socket.create_connection(receiver.address, timeout=10)


def test_each_client_has_its_own_lines(tcp: TcpReceiver) -> None:
    one, other, silent = (dialled(tcp) for _ in range(3))
    one.sendall(b"a1\r\na")
    other.sendall(b"b1\r\n")
    assert sorted(received_lines(tcp, 2)) == [b"a1", b"b1"]
    other.sendall(b"b2\n")
    one.sendall(b"2\n")
    assert sorted(received_lines(tcp, 2)) == [b"a2", b"b2"] and len(tcp.sockets) == 4
    for client in (one, other, silent):
        client.close()
    while len(tcp.sockets) > 1:
        tcp.received(Counts())


def test_a_flood_is_cut_and_counted(tcp: TcpReceiver, clock: Clock) -> None:
    client, counts, got = dialled(tcp), Counts(), 0
    client.sendall(b"x\n" * 10_000)
    while got + counts["flood"] < 10_000:
        got += sum(len(each.lines) for each in tcp.received(counts))
    assert got == AT_ONCE  # the clock stands
    clock.now = 0.25
    client.sendall(b"x\n" * 1000)
    while got + counts["flood"] < 11_000:
        got += sum(len(each.lines) for each in tcp.received(counts))
    assert got == AT_ONCE + 0.25 * RATE
    client.close()


def test_who_has_said_nothing_for_long_gives_way(tcp: TcpReceiver, clock: Clock) -> None:
    """Bytes without an end are nothing. One that speaks stays, and so do all while nobody else comes."""
    clients = []
    while len(tcp.sockets) < 1 + MAX_CLIENTS:
        clients.append(dialled(tcp))
        tcp.received(Counts())
    clock.now = IDLE - 1.0
    clients[0].sendall(b"here\n")
    assert received_lines(tcp, 1) == [b"here"]
    clock.now = IDLE
    clients[1].sendall(b"$")
    tcp.received(Counts())
    late, counts = dialled(tcp), Counts()
    late.sendall(b"late\n")
    assert received_lines(tcp, 1, counts) == [b"late"] and counts["connection"] == 0 and len(tcp.sockets) == 1 + MAX_CLIENTS
    clients[0].sendall(b"still\n")
    assert received_lines(tcp, 1) == [b"still"]
    for client in (*clients, late):
        client.close()


def test_who_has_gone_before_he_was_taken_takes_nobody_along(tcp: TcpReceiver) -> None:
    """A connection that was reset has no other end any more; those that came with it are taken."""
    gone = dialled(tcp)
    gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    gone.close()
    client = dialled(tcp)
    client.sendall(b"next\n")
    assert received_lines(tcp, 1) == [b"next"]
    client.close()


@pytest.mark.parametrize("kind", [TcpReceiver, UdpReceiver, TcpSender])
def test_a_port_that_is_taken_ends_the_start(kind: Any) -> None:
    with (
        contextlib.closing(kind("--nmea-in", Address(HERE, free_port()), [])) as made,
        pytest.raises(UsageError, match=f"--nmea-in: 127.0.0.1:{made.address[1]} cannot be opened .*another port"),
    ):
        kind("--nmea-in", Address(*made.address), [])
    with pytest.raises(UsageError, match="cannot be opened"):
        kind("--nmea-in", Address("192.0.2.1", free_port()), [])  # of documentation: no machine has it


def test_datagrams_have_whole_lines_of_senders_that_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    with (
        contextlib.closing(UdpReceiver("--nmea-in-udp", Address(HERE, free_port()), [], Clock())) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        for data in (b"one\r\ntwo", b"", b"three\r\n"):
            sender.sendto(data, receiver.address)
        assert received_lines(receiver, 3) == [b"one", b"two", b"three"]
        monkeypatch.setattr("radar_service.ports.nmea.listeners.is_loopback", lambda host: False)
        sender.sendto(b"four", receiver.address)
        counts = Counts()
        while not counts["connection"]:
            assert receiver.received(counts) == []


def test_senders_of_datagrams_that_are_remembered_are_few() -> None:
    with contextlib.closing(UdpReceiver("--nmea-in-udp", Address(HERE, free_port()), [])) as receiver:
        for _ in range(3 * MAX_CLIENTS):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                sender.sendto(b"x", receiver.address)
                received_lines(receiver, 1)
        assert receiver.remembered == MAX_CLIENTS


def test_a_group_is_joined_again_that_was_left(clock: Clock) -> None:
    """As the system leaves it with an interface that goes away."""
    where = Address("239.255.77.8", free_port(), HERE)
    with (
        contextlib.closing(UdpReceiver("--nmea-in-udp", where, None, clock)) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(HERE))
        (joined,) = receiver.sockets
        joined.setsockopt(
            socket.IPPROTO_IP, socket.IP_DROP_MEMBERSHIP, socket.inet_aton(where.host) + socket.inet_aton(HERE)
        )
        clock.now = REJOIN
        receiver.received(Counts())
        sender.sendto(b"again", (where.host, where.port))
        assert received_lines(receiver, 1) == [b"again"]
