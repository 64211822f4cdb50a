"""Sockets: many clients, slow and foreign ones, ports that are taken."""

import contextlib
import logging
import socket
from collections.abc import Iterator

import pytest

from radar_service.ports.nmea import listeners
from radar_service.ports.nmea.listeners import MAX_CLIENTS, MAX_WAITING, STALLED, TcpSender
from radar_service.ports.udp.addresses import Address
from tests.ports.nmea.reading import fields_of

HERE = "127.0.0.1"
LINE = b"$HEHDT,1.00,T*00\r\n"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HERE, 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def sender() -> Iterator[TcpSender]:
    made = TcpSender("--nmea-tcp", Address(HERE, free_port()), [])
    yield made
    made.close()


def dialled(sender: TcpSender) -> socket.socket:
    """A client that the sender has met: a busy kernel may be late with a connection."""
    before = list(sender.clients), sender.refused
    connection = socket.create_connection(sender.address, timeout=10)
    while (list(sender.clients), sender.refused) == before:
        sender.send([])
    return connection


def test_all_that_connect_get_the_same(sender: TcpSender) -> None:
    clients = [dialled(sender) for _ in range(3)]
    sender.send([LINE, LINE])
    assert [client.recv(1000) for client in clients] == [2 * LINE] * 3 and len(sender.clients) == 3
    clients[0].close()
    for _ in range(2):
        sender.send([LINE])  # the others go on
    assert len(sender.clients) == 2 and clients[1].recv(1000) in (LINE, 2 * LINE)
    for client in clients:
        client.close()


def test_a_client_that_does_not_read_loses_whole_sentences_and_delays_nobody(sender: TcpSender) -> None:
    slow, quick = dialled(sender), dialled(sender)
    got = 0
    while not sender.lost:
        sender.send([LINE] * 500)
        with contextlib.suppress(BlockingIOError):
            quick.setblocking(False)
            while data := quick.recv(2**20):
                got += len(data)
    assert got > MAX_WAITING and sender.lost > 0
    slow.settimeout(10)
    text = b""
    while len(text) < 50 * len(LINE):
        text += slow.recv(2**16)
    assert set(text.splitlines(keepends=True)[:50]) == {LINE}
    for client in (slow, quick):
        client.close()


def test_what_a_client_says_is_ignored(sender: TcpSender) -> None:
    client = dialled(sender)
    client.settimeout(0.2)
    with contextlib.suppress(TimeoutError):
        for _ in range(20):
            client.sendall(b"x" * 2**16)  # without a line end
            sender.send([])
    sender.send([LINE])
    assert client.recv(1000) == LINE
    client.close()


def test_a_client_beyond_the_limit_is_told_so_and_the_log_says_it_once(
    sender: TcpSender, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, logger="radar_service"):
        clients = [dialled(sender) for _ in range(MAX_CLIENTS + 3)]
    assert len(sender.clients) == MAX_CLIENTS and sender.refused == 3
    for client in clients[-3:]:
        talker, fields = fields_of(client.recv(100))
        assert (talker, fields) == ("RATXT", ["01", "01", "01", "no room for more than 32 clients"]) and client.recv(
            10
        ) == b""
    (line,) = caplog.records
    told = {"option": "--nmea-tcp", "host": HERE, "reason": "no room for more than 32 clients"}
    assert (line.message, line.levelno, line.__dict__["fields"]) == ("client refused", logging.WARNING, told)
    clients.pop(0).close()
    for _ in range(2):
        sender.send([LINE])
    with caplog.at_level(logging.INFO, logger="radar_service"):
        clients += [dialled(sender) for _ in range(3)]
    assert len(caplog.records) == 2  # one was taken in between
    for client in clients:
        client.close()


def test_one_that_only_reads_gets_all_and_gives_way_when_there_is_no_room(sender: TcpSender) -> None:
    """`ncat --recv-only` ends what it says at once, as one does that has gone."""
    clients = [dialled(sender) for _ in range(MAX_CLIENTS)]
    clients[7].shutdown(socket.SHUT_WR)
    for _ in range(3):
        sender.send([LINE])
    assert len(sender.clients) == MAX_CLIENTS and clients[7].recv(1000)[: len(LINE)] == LINE
    clients.append(dialled(sender))
    sender.send([LINE])
    assert len(sender.clients) == MAX_CLIENTS and sender.refused == 0 and clients[-1].recv(1000) == LINE
    while clients[7].recv(1000):
        pass
    for client in clients:
        client.close()


def test_who_is_behind_for_long_gives_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """One whose line is full, not the one that has taken all."""
    monkeypatch.setattr(listeners, "MAX_CLIENTS", 2)
    now = [0.0]
    sender = TcpSender("--nmea-tcp", Address(HERE, free_port()), [], lambda: now[0])
    slow, quick = dialled(sender), dialled(sender)
    while not sender.lost:
        sender.send([LINE] * 500)
        waiting = 500 * len(LINE)
        while waiting:
            waiting -= len(quick.recv(waiting))
    late = []
    for now[0], refused in ((STALLED - 1.0, 1), (STALLED, 1)):
        sender.send([])
        late.append(dialled(sender))
        assert (len(sender.clients), sender.refused) == (2, refused)
    sender.send([LINE])
    assert late[1].recv(1000) == LINE == quick.recv(1000)
    for client in (slow, quick, *late):
        client.close()
    sender.close()
