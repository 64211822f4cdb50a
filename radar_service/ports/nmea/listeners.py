"""A TCP server that lets only some machines in; nothing here waits."""

import contextlib
import logging
import socket
from collections.abc import Callable, Sequence
from ipaddress import IPv6Address, ip_address
from typing import NamedTuple

from radar_service.ports.nmea.sentences import RADAR, sentence
from radar_service.ports.udp.addresses import Address, bound
from radar_service.service.access import is_loopback
from radar_service.service.logs import log_event

MAX_CLIENTS = 32  # of a TCP port
BACKLOG = 16


def may_come(host: str, allowed: Sequence[str] | None) -> bool:
    """Whether the machine of that address is this one, or allowed. allowed: others; None: everybody."""
    address = ip_address(host.partition("%")[0])
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None  # of a socket of both protocols
    host = str(mapped or address)
    return allowed is None or is_loopback(host) or host in allowed


class Connection(NamedTuple):
    """A connection that does not wait, and the address and port of its other end."""

    socket: socket.socket
    host: str
    port: int


class TcpListener:
    """Takes connections. refused: how many it did not take."""

    def __init__(self, option: str, where: Address, allowed: Sequence[str] | None) -> None:
        """option: with which messages begin; allowed: who may connect from other machines; None: everybody. Raises UsageError."""
        self.refused = 0
        self._option, self._allowed, self._logged = option, allowed, ""
        self._listener = bound(option, where, socket.SOCK_STREAM, lambda listener: listener.listen(BACKLOG))

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        host, port, *_ = self._listener.getsockname()
        return host, port

    def may_come(self, host: str) -> bool:
        """Whether the machine of that address may connect."""
        return may_come(host, self._allowed)

    def accepted(self, clients: int, make_room: Callable[[], bool] = bool) -> list[Connection]:
        """Returns the connections that have come.

        clients: how many there are; one beyond MAX_CLIENTS is refused, unless `make_room` has closed another one.
        """
        result: list[Connection] = []
        with contextlib.suppress(OSError):  # nobody waits; or he has gone again
            for _ in range(BACKLOG):
                connection, (host, port, *_) = self._listener.accept()
                connection.setblocking(False)
                is_full = clients + len(result) >= MAX_CLIENTS
                reason = "" if self.may_come(str(host)) else "this machine is not allowed"
                if reason or (is_full and not make_room()):
                    self._refuse(connection, str(host), reason or f"no room for more than {MAX_CLIENTS} clients")
                    continue
                clients -= is_full
                self._logged = ""
                result.append(Connection(connection, str(host), int(port)))
        return result

    def _refuse(self, connection: socket.socket, host: str, reason: str) -> None:
        """Says to a client why it is not taken; the log says the same once, until another one is taken."""
        self.refused += 1
        with contextlib.suppress(OSError):
            connection.send(sentence(RADAR, "TXT", "01", "01", "01", reason))
        connection.close()
        if reason != self._logged:
            log_event("client refused", logging.WARNING, option=self._option, host=host, reason=reason)
        self._logged = reason

    def close(self) -> None:
        """Closes what listens."""
        self._listener.close()
