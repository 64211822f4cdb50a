"""What takes sentences: a TCP server, which does not wait; UDP is `ports.udp`."""

import contextlib
import socket
import time
from collections.abc import Callable, Sequence

from typing_extensions import override

from radar_service.ports.nmea.listeners import TcpListener
from radar_service.ports.udp.addresses import Address

MAX_WAITING = 64 * 2**10  # bytes that a client has not taken: half a minute of sentences
MAX_READ = 2**16  # bytes of what a client says, which nobody reads
STALLED = 30.0  # s in which a client was behind all the time; then another one takes its place


class _TcpClient:
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
        self._clients = list[_TcpClient]()

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
            self._clients.append(_TcpClient(connection, self._clock()))

    def _make_room(self) -> bool:
        """Drops a client that has gone, perhaps, or else the one that is behind for the longest time."""
        client = min(self._clients, key=lambda each: (not each.has_ended, each.took), default=None)
        if client is None or not (client.has_ended or self._clock() - client.took >= STALLED):
            return False
        self._drop(client)
        return True

    def _drop(self, client: _TcpClient) -> None:
        self._clients.remove(client)
        client.connection.close()
