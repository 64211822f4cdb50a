"""Datagrams: addresses of the command line, who may be there, senders, and what is lost. Captures have a file of their own."""

import argparse
import errno
import logging
import re
import select
import socket
import sys
from collections.abc import Sequence
from typing import Any, ClassVar

import pytest

from radar_service.ports.nmea_in.receivers import UdpReceiver
from radar_service.ports.port_thread import PortThread
from radar_service.ports.udp import sender
from radar_service.ports.udp.addresses import IP_MULTICAST_ALL, REJOIN, Address, UdpListener, address, check_reach, numeric
from radar_service.ports.udp.sender import MAX_DATAGRAM, UdpSender, datagrams
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.test_senders import free_port
from tests.ports.nmea_in.test_nmea_in import Clock


# addresses: of the command line, and who may be there.
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10110", Address("127.0.0.1", 10110)), ("0.0.0.0:1", Address("0.0.0.0", 1)), ("bridge:65535", Address("bridge", 65535)),
        ("239.192.0.4:60004%192.168.0.7", Address("239.192.0.4", 60004, "192.168.0.7")), ("[::1]:7", Address("::1", 7)),
        ("[ff02::1]:7%eth0", Address("ff02::1", 7, "eth0")),
    ],
)  # fmt: skip
def test_addresses(text: str, expected: Address) -> None:
    assert address(text) == expected and address(str(expected)) == expected


@pytest.mark.parametrize("text", ["", "0", "65536", "a", "host:", "::1:7", ":7", "[::1]", "a b:7", "1%"])
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="10110"):
        address(text)


def test_names_are_not_allowed_in() -> None:
    assert numeric("192.168.0.7") == "192.168.0.7"
    with pytest.raises(argparse.ArgumentTypeError, match="192.168.0.7"):
        numeric("bridge")


@pytest.mark.parametrize(
    ("host", "allowed", "insecure", "listens", "passes"),
    [
        ("127.0.0.1", [], False, True, True), ("::1", [], False, False, True), ("localhost", [], False, False, True),
        ("0.0.0.0", [], False, True, False), ("0.0.0.0", ["10.0.0.2"], False, True, True), ("0.0.0.0", [], True, True, True),
        ("10.0.0.2", [], False, False, False), ("10.0.0.2", ["10.0.0.3"], False, False, False),
        ("10.0.0.2", ["10.0.0.3", "10.0.0.2"], False, False, True), ("239.192.0.4", [], True, False, True),
        ("bridge", [], False, True, False), ("FF02:0::1", ["ff02::1"], False, False, True),
    ],
)  # fmt: skip
def test_beyond_this_machine_needs_a_permission(
    host: str, allowed: list[str], insecure: bool, listens: bool, passes: bool
) -> None:
    if passes:
        check_reach("--nmea-tcp", Address(host, 7), allowed, insecure, listens=listens)
        return
    with pytest.raises(UsageError, match="--nmea-allow .*--insecure"):
        check_reach("--nmea-tcp", Address(host, 7), allowed, insecure, listens=listens)


@pytest.mark.parametrize(
    ("host", "remedy"),
    [
        ("10.0.0.2", "give --nmea-allow 10.0.0.2, or"), ("FF02:0::1", "give --nmea-allow ff02::1, or"),
        ("bridge", "give an address in numbers, here and to --nmea-allow, or"), ("127.1", "give an address in numbers, here and"),
    ],
)  # fmt: skip
def test_the_remedy_of_a_message_works(host: str, remedy: str) -> None:
    """A name cannot be allowed: which machine has it may change. What --nmea-allow takes is what is compared."""
    with pytest.raises(UsageError, match=re.escape(remedy)):
        check_reach("--nmea-udp", Address(host, 7), [], False, listens=False)
    if allowed := re.search("--nmea-allow ([^ ,]+),", remedy):
        check_reach("--nmea-udp", Address(host, 7), [numeric(allowed[1])], False, listens=False)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        (Address("ff02::1", 7, "nosuch9"), "no interface has the name nosuch9"),
        (Address("fe80::1", 7), r"needs an interface, as \[fe80::1\]:7%eth0"), (Address("FF12::1", 7), "needs an interface"),
    ],
)  # fmt: skip
def test_an_interface_that_is_absent_or_missing_is_named(where: Address, message: str) -> None:
    with pytest.raises(OSError, match=message):
        _ = where.for_sockets
    with pytest.raises(OSError, match="eth0 is not the address of an interface"):
        _ = Address("239.1.1.1", 7, "eth0").interface_address
    assert Address("::1", 7).for_sockets == ("::1", 7, 0, 0) and Address("bridge", 7).for_sockets == ("bridge", 7)


@pytest.mark.parametrize("where", [Address("239.1.2.3", 5, "nosuch9"), Address("ff05::1", 5, "nosuch9")])
def test_sockets_say_so(where: Address) -> None:
    for make in (lambda: UdpSender("--x", where), lambda: UdpReceiver("--x", where, [])):
        with pytest.raises(UsageError, match="--x: .* cannot be (reached|opened) .*nosuch9"):
            make()


def test_a_group_is_listened_to_beside_readers_of_it() -> None:
    where, clock = Address("239.255.77.9", free_port(), "127.0.0.1"), Clock()
    listeners = [UdpListener("--x", where, clock) for _ in range(2)]  # as readers do
    clock.now = REJOIN  # it is in the group
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        sender.sendto(b"\1\xb1", (where.host, where.port))
    for each in listeners:
        assert select.select(each.sockets, [], [], 10)[0] and [data for data, *_ in each.datagrams(64)] == [b"\1\xb1"]
        if sys.platform == "linux":  # nothing comes by other interfaces, which a test has not
            assert each.sockets[0].getsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL) == 0
        each.close()


# sender: whole pieces, networks that go away and come back, where they come from.
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


# udp_port: what is lost is counted, once.
class Leaky:
    """A sender that loses all but the first piece, and cannot be closed."""

    lost = 0

    def send(self, pieces: Sequence[bytes]) -> None:
        self.lost += max(0, len(pieces) - 1)

    def close(self) -> None:
        raise OSError("gone")


class LeakyPort(UdpPort):
    name = "leaky"


def test_what_is_lost_is_counted_by_the_thread_of_the_port() -> None:
    port, thread = LeakyPort([Leaky(), Leaky()]), PortThread("leaky")
    port.send([b"a", b"b"])  # before it starts
    port.thread = thread
    for _ in range(2):
        port.send([b"a", b"b", b"c"])
    port.note_lost(1)
    port.note_lost(0)
    port.close()
    assert thread.dropped == 2 * 2 * 2 + 1
