"""Sockets that take sentences: a TCP server, and UDP. None of them waits; a network that fails is counted and tried again."""

import contextlib
import logging
import socket
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from typing_extensions import override

from radar_service.ports.nmea.addresses import Address
from radar_service.ports.nmea.listeners import TcpListener
from radar_service.service.logs import log_event
from radar_service.terminal.arguments import UsageError

MAX_WAITING = 64 * 2**10  # bytes that a client has not taken: half a minute of sentences
MAX_READ = 2**16  # bytes of what a client says, which nobody reads
REOPEN = 1.0  # s between two sockets to a network that is away
STALLED = 30.0  # s in which a client was behind all the time; then another one takes its place
MAX_DATAGRAM = 1400  # bytes: fits a frame of Ethernet


class Sender(Protocol):
    """Takes sentences. lost: of those that could not go out; `send` and `close` belong to one thread."""

    lost: int

    def send(self, sentences: Sequence[bytes]) -> None:
        """Sends sentences to whoever is there, without waiting; an empty list lets others connect."""

    def close(self) -> None:
        """Closes its sockets."""


class _Client:
    """A TCP client, with what it has not taken yet.

    has_ended: whether it says nothing any more: it may have gone, or only read, as `ncat --recv-only` does.
    took: when it has last taken all there was [s].
    """

    def __init__(self, connection: socket.socket, now: float) -> None:
        self.connection, self.waiting = connection, bytearray()
        self.has_ended, self.took = False, now

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
            self.took = now
        return count


class TcpSender(TcpListener):
    """A TCP server that sends. lost: as of each sender."""

    def __init__(
        self, option: str, where: Address, allowed: Sequence[str] | None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(option, where, allowed)
        self.lost, self._clock = 0, clock
        self._clients = list[_Client]()

    @property
    def clients(self) -> int:
        """How many are connected."""
        return len(self._clients)

    def send(self, sentences: Sequence[bytes]) -> None:
        """Sends to all that are connected; one that does not read loses sentences, whole ones."""
        self._accept()
        for client in list(self._clients):
            try:
                self.lost += client.send(sentences, self._clock())
            except OSError:
                self._drop(client)

    @override
    def close(self) -> None:
        """Closes all."""
        for client in self._clients:
            client.connection.close()
        super().close()

    def _accept(self) -> None:
        for connection, *_ in self.accepted(len(self._clients), self._make_room):
            with contextlib.suppress(OSError):  # he has gone again
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._clients.append(_Client(connection, self._clock()))

    def _make_room(self) -> bool:
        """Drops a client that has gone, perhaps, or else the one that is behind for the longest time."""
        client = min(self._clients, key=lambda each: (not each.has_ended, each.took), default=None)
        if client is None or not (client.has_ended or self._clock() - client.took >= STALLED):
            return False
        self._drop(client)
        return True

    def _drop(self, client: _Client) -> None:
        self._clients.remove(client)
        client.connection.close()


class UdpSender:
    """Datagrams to one address, also of multicast or broadcast; they stay in the network of this machine (TTL 1)."""

    def __init__(self, option: str, where: Address, clock: Callable[[], float] = time.monotonic) -> None:
        """option: with which messages begin. Raises UsageError where no way leads there."""
        self.lost = 0
        self._option, self._where, self._has_failed, self._was_alone = option, where, False, False
        self._clock, self._opened = clock, clock()
        try:
            self._socket = _prepared(where)
        except OSError as error:
            raise UsageError(
                f"{option}: {where} cannot be reached ({error.strerror}); give another address or interface"
            ) from None

    def send(self, sentences: Sequence[bytes]) -> None:
        """Sends whole sentences, as many in a datagram as fit."""
        for count, datagram in datagrams(sentences):
            try:
                self._send(datagram)
            except OSError as error:
                self.lost += count
                if not self._has_failed:
                    log_event(
                        "network lost", logging.WARNING, option=self._option, to=str(self._where), reason=str(error.strerror)
                    )
                self._has_failed = True
                self._open_again()
            else:
                if self._has_failed:
                    log_event("network back", option=self._option, to=str(self._where), lost=self.lost)
                self._has_failed = False

    def _send(self, datagram: bytes) -> None:
        """Sends a datagram; a refusal says that nobody was there to take the one before. Raises OSError."""
        try:
            self._socket.send(datagram)
        except ConnectionRefusedError:
            if not self._was_alone:
                log_event("nobody there", option=self._option, to=str(self._where))
            self._was_alone = True
            with contextlib.suppress(ConnectionRefusedError):
                self._socket.send(datagram)

    def close(self) -> None:
        """Closes the socket."""
        self._socket.close()

    def _open_again(self) -> None:
        """Opens another socket, once a second: an interface that was away may have come back as another one."""
        if self._clock() - self._opened < REOPEN:
            return
        self._opened = self._clock()
        with contextlib.suppress(OSError):
            fresh = _prepared(self._where)
            self._socket.close()
            self._socket = fresh


def _prepared(where: Address) -> socket.socket:
    """Returns a socket for datagrams to an address, which does not wait. Raises OSError."""
    result = socket.socket(where.family, socket.SOCK_DGRAM)
    try:
        result.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        if where.family == socket.AF_INET6:
            result.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_UNICAST_HOPS, 1)
            result.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, 1)
            if where.interface:
                result.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, where.interface_index)
        else:
            result.setsockopt(socket.IPPROTO_IP, socket.IP_TTL, 1)
            result.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 1)
            if where.interface:
                result.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, where.interface_address)
        result.connect(where.for_sockets)
        result.setblocking(False)
    except OSError:
        result.close()
        raise
    return result


def datagrams(sentences: Sequence[bytes]) -> list[tuple[int, bytes]]:
    """Returns datagrams of whole sentences, each with their number."""
    result: list[tuple[int, bytes]] = []
    for each in sentences:
        if result and len(result[-1][1]) + len(each) <= MAX_DATAGRAM:
            result[-1] = result[-1][0] + 1, result[-1][1] + each
        else:
            result.append((1, each))
    return result
