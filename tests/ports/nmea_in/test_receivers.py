"""Sockets that read: whole lines of each sender, floods that are cut, ports that are taken."""

import contextlib
import socket
import struct
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest

from radar_service.ports.nmea.listeners import TcpSender
from radar_service.ports.nmea_in.receivers import (
    AT_ONCE,
    IDLE,
    MAX_CLIENTS,
    MAX_READ,
    RATE,
    Receiver,
    TcpReceiver,
    UdpReceiver,
)
from radar_service.ports.udp.addresses import REJOIN, Address
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.test_senders import HERE, free_port


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


def lines(receiver: Receiver, expected: int, counts: Counts | None = None) -> list[bytes]:
    """The first lines that come, so many of them."""
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
    assert sorted(lines(tcp, 2)) == [b"a1", b"b1"]
    other.sendall(b"b2\n")
    one.sendall(b"2\n")
    assert sorted(lines(tcp, 2)) == [b"a2", b"b2"] and len(tcp.sockets) == 4
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


def test_ten_megabytes_without_an_end_are_one_line_that_is_counted(tcp: TcpReceiver) -> None:
    client, counts = dialled(tcp), Counts()
    client.setblocking(False)
    left = 10 * 2**20
    while left:
        with contextlib.suppress(BlockingIOError):
            left -= client.send(b"x" * min(left, 2**20))
        assert not any(each.lines for each in tcp.received(counts))
    client.setblocking(True)
    client.sendall(b"\nnext\n")
    assert lines(tcp, 1, counts) == [b"next"] and counts == {"form": 1, "flood": 0, "connection": 0} and MAX_READ == 2**14
    client.close()


def test_who_has_said_nothing_for_long_gives_way(tcp: TcpReceiver, clock: Clock) -> None:
    """Bytes without an end are nothing. One that speaks stays, and so do all while nobody else comes."""
    clients = []
    while len(tcp.sockets) < 1 + MAX_CLIENTS:
        clients.append(dialled(tcp))
        tcp.received(Counts())
    clock.now = IDLE - 1.0
    clients[0].sendall(b"here\n")
    assert lines(tcp, 1) == [b"here"]
    clock.now = IDLE
    clients[1].sendall(b"$")
    tcp.received(Counts())
    late, counts = dialled(tcp), Counts()
    late.sendall(b"late\n")
    assert lines(tcp, 1, counts) == [b"late"] and counts["connection"] == 0 and len(tcp.sockets) == 1 + MAX_CLIENTS
    clients[0].sendall(b"still\n")
    assert lines(tcp, 1) == [b"still"]
    for client in (*clients, late):
        client.close()


def test_who_has_gone_before_he_was_taken_takes_nobody_along(tcp: TcpReceiver) -> None:
    """A connection that was reset has no other end any more; those that came with it are taken."""
    gone = dialled(tcp)
    gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    gone.close()
    client = dialled(tcp)
    client.sendall(b"next\n")
    assert lines(tcp, 1) == [b"next"]
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
        assert lines(receiver, 3) == [b"one", b"two", b"three"]
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
                lines(receiver, 1)
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
        assert lines(receiver, 1) == [b"again"]
