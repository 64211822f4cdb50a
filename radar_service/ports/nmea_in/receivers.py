"""Sockets that take sentences: a TCP server, and UDP. None of them waits, and each keeps little of what comes."""

import contextlib
import socket
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from radar_service.ports.nmea.listeners import MAX_CLIENTS, TcpListener, may_come
from radar_service.ports.nmea_in.sentence_reader import SentenceLines
from radar_service.ports.udp.addresses import Address, UdpListener
from radar_service.service.token_bucket import TokenBucket

MAX_READ = 2**14  # bytes of a client at once; the rest waits in the system, which holds its sender back
RATE, AT_ONCE = 200.0, 100.0  # sentences of one sender a second: as poses
IDLE = 10.0  # s without a line, after which another client takes the place of one
Count = Callable[[str, int], None]


class Received(NamedTuple):
    """sender: a protocol and an address; lines: that it has sent."""

    sender: str
    lines: list[bytes]


class _Talk:
    """What one sender says, no more than is read. idle_since: when it has last ended a line, or begun [s]."""

    has_ended = False

    def __init__(self, clock: Callable[[], float]) -> None:
        self._lines, self._budget, self._clock = SentenceLines(), TokenBucket(RATE, AT_ONCE, clock), clock
        self.idle_since = clock()

    def lines_of(self, data: bytes, count: Count) -> list[bytes]:
        """Returns the lines that end in these bytes."""
        before, lines = self._lines.too_long, self._lines.of(data)
        count("form", self._lines.too_long - before)
        taken = next((n for n in range(len(lines)) if not self._budget.take(1)), len(lines))
        count("flood", len(lines) - taken)
        self.idle_since = self._clock() if lines else self.idle_since
        return lines[:taken]


class _TcpTalk(_Talk):
    """What a TCP client says. sender: its protocol and address."""

    def __init__(self, connection: socket.socket, address: str, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self.connection, self.sender = connection, f"tcp {address}"


class TcpReceiver(TcpListener[_TcpTalk]):
    """A TCP server that reads."""

    patience = IDLE

    def taken(self, connection: socket.socket, address: str) -> _TcpTalk:
        """Returns a client that has said nothing."""
        return _TcpTalk(connection, address, self._clock)

    @property
    def sockets(self) -> Sequence[socket.socket]:
        """The listener, and all connections."""
        return [self._listener, *(client.connection for client in self.clients)]

    def received(self, count: Count) -> list[Received]:
        """Takes those who connect, and returns what all have sent, without waiting. count: is told how many lines were left out,
        with a word."""
        before = self.refused
        self.accept()
        count("connection", self.refused - before)
        return [
            Received(client.sender, client.lines_of(data, count))
            for client in list(self.clients)
            if (data := self._data(client))
        ]

    def _data(self, client: _TcpTalk) -> bytes:
        """What a client has sent; one that has gone is left out from now on."""
        with contextlib.suppress(BlockingIOError):
            with contextlib.suppress(ConnectionError, TimeoutError):
                if data := client.connection.recv(MAX_READ):
                    return data
            self.drop(client)
        return b""


class UdpReceiver(UdpListener):
    """Datagrams of whole sentences."""

    def __init__(
        self, option: str, where: Address, allowed: Sequence[str] | None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Arguments as of TcpListener. Raises UsageError."""
        super().__init__(option, where, clock)
        self._allowed, self._clock = allowed, clock
        self._talks: dict[str, _Talk] = {}

    @property
    def remembered(self) -> int:
        """Of how many senders it knows what they have sent of late."""
        return len(self._talks)

    def received(self, count: Count) -> list[Received]:
        """Returns what has come, of each datagram by itself."""
        result: list[Received] = []
        for data, host, port in self.datagrams(MAX_READ):
            if may_come(host, self._allowed):
                sender = f"udp {host}:{port}"
                result.append(Received(sender, self._talk(sender).lines_of(data + b"\n", count)))
            else:
                count("connection", 1)
        return result

    def _talk(self, sender: str) -> _Talk:
        """The talk of one of the last MAX_CLIENTS senders."""
        talk = self._talks.pop(sender, None) or _Talk(self._clock)
        self._talks[sender] = talk
        if len(self._talks) > MAX_CLIENTS:
            del self._talks[next(iter(self._talks))]
        return talk


Receiver = TcpReceiver | UdpReceiver
