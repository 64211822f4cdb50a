"""Datagrams to one address. Nothing here waits; a network that fails is counted, logged once and tried again."""

import contextlib
import logging
import socket
import time
from collections.abc import Callable, Sequence

from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import Capture
from radar_service.service.logs import log_event
from radar_service.terminal import UsageError

REOPEN = 1.0  # s between two sockets to a network that is away
MAX_DATAGRAM = 1400  # bytes: fits a frame of Ethernet


class UdpSender:
    """Datagrams to one address, also of multicast or broadcast; they stay in the network of this machine (TTL 1).

    lost: how many pieces could not go out.
    """

    def __init__(
        self, option: str, where: Address, clock: Callable[[], float] = time.monotonic, *, joined: int = MAX_DATAGRAM,
        source: Address | None = None, capture: Capture | None = None,
    ) -> None:  # fmt: skip
        """option: with which messages begin; joined: bytes up to which pieces share a datagram; source: of the datagrams, which
        others may use too; capture: takes what was sent. Raises UsageError where no way leads there."""
        self.lost = 0
        self._option, self._where, self._has_failed, self._was_alone = option, where, False, False
        self._clock, self._opened, self._joined, self._source = clock, clock(), joined, source
        self._capture = capture
        try:
            self._socket = _prepared(where, source)
        except OSError as error:
            raise UsageError(
                f"{option}: {where} cannot be reached ({error.strerror}); give another address or interface"
            ) from None

    def send(self, pieces: Sequence[bytes]) -> None:
        """Sends whole pieces, as many in a datagram as fit."""
        for count, datagram in datagrams(pieces, self._joined):
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
                if self._capture is not None:
                    self._capture.take(self._socket.getsockname()[:2], self._socket.getpeername()[:2], datagram)

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
            fresh = _prepared(self._where, self._source)
            self._socket.close()
            self._socket = fresh


def _prepared(where: Address, source: Address | None) -> socket.socket:
    """Returns a socket for datagrams from one address to another, which does not wait. Raises OSError."""
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
        if source is not None:
            result.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            result.bind(source.for_sockets)
        result.connect(where.for_sockets)
        result.setblocking(False)
    except OSError:
        result.close()
        raise
    return result


def datagrams(pieces: Sequence[bytes], joined: int = MAX_DATAGRAM) -> list[tuple[int, bytes]]:
    """Returns datagrams of whole pieces, each with their number. joined: bytes up to which they share one."""
    result: list[tuple[int, bytes]] = []
    for each in pieces:
        if result and len(result[-1][1]) + len(each) <= joined:
            result[-1] = result[-1][0] + 1, result[-1][1] + each
        else:
            result.append((1, each))
    return result
