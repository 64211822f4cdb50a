"""Who may connect, and how many."""

import contextlib
import socket

import pytest

from radar_service.ports.nmea import listeners
from radar_service.ports.nmea.listeners import TcpSender, bound, may_come
from radar_service.ports.udp.addresses import Address
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.reading import fields_of
from tests.ports.nmea.test_senders import HERE, free_port


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
