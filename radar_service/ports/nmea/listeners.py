"""A TCP server that lets only some machines in, and one that sends them lines; nothing here waits."""

import contextlib
import logging
import socket
import time
from collections.abc import Callable, Sequence
from ipaddress import IPv6Address, ip_address
from typing import ClassVar, Generic, Protocol, TypeVar

from radar_service.ports.nmea.sentences import RADAR, sentence
from radar_service.ports.udp.addresses import Address, bound
from radar_service.service.access import is_loopback
from radar_service.service.logs import log_event

MAX_CLIENTS = 32  # of a TCP port
BACKLOG = 16
MAX_WAITING = 64 * 2**10  # bytes that a client has not taken: half a minute of sentences
MAX_READ = 2**16  # bytes of what a client says, which nobody reads
STALLED = 30.0  # s in which a client was behind all the time; then another one takes its place


def may_come(host: str, allowed: Sequence[str] | None) -> bool:
    """Whether the machine of that address is this one, or allowed. allowed: others; None: everybody."""
    address = ip_address(host.partition("%")[0])
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None  # of a socket of both protocols
    host = str(mapped or address)
    return allowed is None or is_loopback(host) or host in allowed


class Client(Protocol):
    """A client. has_ended: whether it may have gone; idle_since: when it has last done its part [s]."""

    connection: socket.socket
    has_ended: bool
    idle_since: float


Made = TypeVar("Made", bound=Client)


class TcpListener(Generic[Made]):
    """Takes connections.

    refused: how many it did not take; clients: those that are connected; patience: how long one may do nothing while others want
    its place [s].
    """

    patience: ClassVar[float]

    def __init__(
        self, option: str, where: Address, allowed: Sequence[str] | None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """option: with which messages begin; allowed: who may connect from other machines, None: all. Raises UsageError."""
        self.refused, self.clients = 0, list[Made]()
        self._option, self._allowed, self._logged, self._clock = option, allowed, "", clock
        self._listener = bound(option, where, socket.SOCK_STREAM, lambda listener: listener.listen(BACKLOG))

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        host, port, *_ = self._listener.getsockname()
        return host, port

    def taken(self, connection: socket.socket, address: str) -> Made:
        """Returns the client of a new connection."""
        raise NotImplementedError

    def accept(self) -> None:
        """Takes the connections that have come. One beyond MAX_CLIENTS is refused, unless another one gives way."""
        with contextlib.suppress(OSError):  # nobody waits; or he has gone again
            for _ in range(BACKLOG):
                connection, (host, port, *_) = self._listener.accept()
                connection.setblocking(False)
                reason = "" if may_come(str(host), self._allowed) else "this machine is not allowed"
                if not reason and len(self.clients) >= MAX_CLIENTS and not self._make_room():
                    reason = f"no room for more than {MAX_CLIENTS} clients"
                if reason:
                    self._refuse(connection, str(host), reason)
                    continue
                self._logged = ""
                self.clients.append(self.taken(connection, f"{host}:{port}"))

    def drop(self, client: Made) -> None:
        """Ends a connection."""
        self.clients.remove(client)
        client.connection.close()

    def _make_room(self) -> bool:
        """Drops a client that has gone, perhaps, or else the one that is idle for the longest time."""
        client = min(self.clients, key=lambda each: (not each.has_ended, each.idle_since), default=None)
        if client is None or not (client.has_ended or self._clock() - client.idle_since >= self.patience):
            return False
        self.drop(client)
        return True

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
        """Closes all."""
        for client in self.clients:
            client.connection.close()
        self._listener.close()


class _TcpClient:
    """A TCP client, with what it has not taken yet.

    has_ended: whether it says nothing any more: it may have gone, or only read, as `ncat --recv-only` does.
    idle_since: when it has last taken all there was [s].
    """

    def __init__(self, connection: socket.socket, now: float) -> None:
        self.connection, self.waiting = connection, bytearray()
        self.has_ended, self.idle_since = False, now
        with contextlib.suppress(OSError):  # he has gone again
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, sentences: Sequence[bytes], now: float) -> int:
        """Hands on what it takes; returns how many sentences were left out. Raises OSError where it has gone."""
        with contextlib.suppress(BlockingIOError):
            for _ in range(MAX_READ // 4096):
                if self.has_ended:
                    break
                self.has_ended = not self.connection.recv(4096)
        count = 0
        for each in sentences:
            if len(self.waiting) + len(each) > MAX_WAITING:
                count += 1
            else:
                self.waiting += each
        with contextlib.suppress(BlockingIOError):
            while self.waiting:
                del self.waiting[: self.connection.send(self.waiting)]
        if not self.waiting:
            self.idle_since = now
        return count


class TcpSender(TcpListener[_TcpClient]):
    """A TCP server that sends. lost: as of each sender."""

    patience, lost = STALLED, 0

    def taken(self, connection: socket.socket, address: str) -> _TcpClient:
        """Returns a client that has taken all there is."""
        return _TcpClient(connection, self._clock())

    def send(self, sentences: Sequence[bytes]) -> None:
        """Sends to all that are connected; one that does not read loses sentences, whole ones."""
        self.accept()
        for client in list(self.clients):
            try:
                self.lost += client.send(sentences, self._clock())
            except OSError:
                self.drop(client)
