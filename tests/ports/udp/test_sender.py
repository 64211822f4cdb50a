"""Datagrams: whole pieces, networks that go away and come back, where they come from."""

import errno
import logging
import socket
from typing import Any, ClassVar

import pytest

from radar_service.ports.udp import sender
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.sender import MAX_DATAGRAM, UdpSender, datagrams
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.test_senders import free_port

HERE = "127.0.0.1"
IP_RECVTTL = 12  # of Linux; Python names it from 3.14 on
LINE = b"$HEHDT,1.00,T*00\r\n"


def test_udp_sends_whole_sentences_with_ttl_1() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind((HERE, 0))
        ear.setsockopt(socket.IPPROTO_IP, IP_RECVTTL, 1)
        ear.settimeout(10)
        made = UdpSender("--nmea-udp", Address(HERE, ear.getsockname()[1]))
        made.send([LINE] * 100)
        text = b""
        while len(text) < 100 * len(LINE):
            data, extra, _, _ = ear.recvmsg(2000, 100)
            assert extra[0][2] == (1).to_bytes(4, "little") and data.endswith(b"\r\n") and len(data) <= MAX_DATAGRAM
            text += data
        assert text == 100 * LINE
        made.close()


class Unplugged(socket.socket):
    """A socket whose network goes away and comes back."""

    faults: ClassVar[list[int]] = []

    def send(self, *_: Any) -> int:
        if fault := self.faults.pop(0):
            raise OSError(fault, "no network")
        return 1


def test_a_network_that_goes_away_is_told_once_and_tried_again(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(sender.socket, "socket", Unplugged)
    Unplugged.faults = [0, errno.ENETUNREACH, errno.ENETDOWN, errno.EHOSTUNREACH, 0, 0, errno.EAGAIN, 0]
    made = UdpSender("--nmea-udp", Address(HERE, 9))
    with caplog.at_level(logging.INFO, logger="radar_service"):
        for _ in range(8):
            made.send([LINE, LINE])
    made.close()
    assert made.lost == 8  # of 16
    assert [record.message for record in caplog.records] == ["network lost", "network back"] * 2


def test_an_interface_that_came_back_as_another_one_gets_another_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first socket fails for ever; another one is opened after a second, and not before."""
    now, opened = [0.0], list[socket.socket]()

    class Gone(Unplugged):
        def __init__(self, *words: Any) -> None:
            super().__init__(*words)
            opened.append(self)

        def send(self, *_: Any) -> int:
            if self is opened[0]:
                raise OSError(errno.ENODEV, "no device")
            return 1

    monkeypatch.setattr(sender.socket, "socket", Gone)
    made = UdpSender("--nmea-udp", Address(HERE, 9), lambda: now[0])
    for later, lost in ((0.5, 1), (0.9, 2), (1.0, 3), (1.1, 3)):
        now[0] = later
        made.send([LINE])
        assert made.lost == lost
    assert len(opened) == 2 and opened[0].fileno() == -1
    made.close()


def test_where_nobody_listens_yet_nothing_is_lost_and_whoever_comes_gets_the_next_sentence(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """The system refuses a datagram for the one before, so that it is sent once more."""
    port = free_port()
    made = UdpSender("--nmea-udp", Address(HERE, port))
    with caplog.at_level(logging.INFO, logger="radar_service"), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        for _ in range(4):
            made.send([LINE])
        ear.bind((HERE, port))
        ear.settimeout(10)
        made.send([LINE])
        assert ear.recv(100) == LINE
    made.close()
    assert made.lost == 0 and [record.message for record in caplog.records] == ["nobody there"]
    assert caplog.records[0].__dict__["fields"] == {"option": "--nmea-udp", "to": f"{HERE}:{port}"}


def test_no_way_to_an_address_ends_the_start() -> None:
    with pytest.raises(UsageError, match="--nmea-udp: 239.1.2.3:5%203.0.113.9 cannot be reached"):
        UdpSender("--nmea-udp", Address("239.1.2.3", 5, "203.0.113.9"))


def test_datagrams_hold_whole_sentences() -> None:
    assert datagrams([]) == [] and datagrams([LINE]) == [(1, LINE)]
    lines = [bytes([65 + k]) * 500 for k in range(5)]
    assert datagrams(lines) == [(2, lines[0] + lines[1]), (2, lines[2] + lines[3]), (1, lines[4])]
    assert datagrams(lines, 0) == [(1, line) for line in lines]


def test_several_senders_share_one_source() -> None:
    """A reader on this machine may hold the port on all addresses, and each datagram comes from it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind((HERE, 0))
        ear.settimeout(10)
        source = Address(HERE, free_port())
        made = [UdpSender("--x", Address(*ear.getsockname()), source=source, joined=0) for _ in range(2)]
        for each in made:
            each.send([LINE, LINE])
            assert [ear.recvfrom(100) for _ in range(2)] == [(LINE, (HERE, source.port))] * 2
            each.close()
