"""What takes sentences: a TCP server, which does not wait; UDP is `ports.udp`."""

import contextlib
import socket
import time
from collections.abc import Callable, Sequence

from radar_service.ports.nmea.listeners import TcpListener
from radar_service.ports.udp.addresses import Address

MAX_WAITING = 64 * 2**10  # bytes that a client has not taken: half a minute of sentences
MAX_READ = 2**16  # bytes of what a client says, which nobody reads
STALLED = 30.0  # s in which a client was behind all the time; then another one takes its place


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

    def __init__(
        self, option: str, where: Address, allowed: Sequence[str] | None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(option, where, allowed, lambda connection, _: _TcpClient(connection, clock()), STALLED, clock)
        self.lost = 0

    def send(self, sentences: Sequence[bytes]) -> None:
        """Sends to all that are connected; one that does not read loses sentences, whole ones."""
        self.accept()
        for client in list(self.clients):
            try:
                self.lost += client.send(sentences, self._clock())
            except OSError:
                self.drop(client)
