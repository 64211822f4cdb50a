"""A capture of datagrams: a file of libpcap's format, with frames of Ethernet, that Wireshark, tcpreplay and others read.

https://ietf-opsawg-wg.github.io/draft-ietf-opsawg-pcap has the format. Times are in microseconds.
"""

import argparse
import logging
import struct
import threading
import time
from collections.abc import Callable, Sequence
from ipaddress import IPv4Address, IPv6Address, ip_address
from pathlib import Path

from radar_service.ports.port import Port
from radar_service.service.logs import log_event
from radar_service.terminal import named_errors, prepare

HEADER = struct.pack("<IHHIIII", 0xA1B2C3D4, 2, 4, 0, 0, 2**18, 1)  # of the file: Ethernet
UDP = 17  # number of the protocol
HERE, THERE = b"\2\0\0\0\0\1", b"\2\0\0\0\0\2"  # made up, as a datagram does not tell its frame
Socket = tuple[str, int]  # an address in numbers, and a port


class Capture:
    """Writes datagrams, each at once, from any thread. A file that cannot be written is given up, and the log says so.

    clock: tells the time of a datagram, since 1970 [s]; it may be set.
    """

    def __init__(self, path: Path, clock: Callable[[], float] = time.time, *, raises: bool = False) -> None:
        """raises: whether methods raise OSError in place of giving up. Raises OSError where the file cannot be written."""
        self.clock, self._path, self._lock = clock, path, threading.Lock()
        self._raises, self._ended = raises, False
        with named_errors(path):
            self._file = path.open("wb", buffering=0)  # so that a process that is killed leaves whole frames
            self._write(HEADER)

    def take(self, source: Socket, destination: Socket, datagram: bytes) -> None:
        """Writes one. source, destination: addresses in numbers, and ports."""
        frame = _frame(source, destination, datagram)
        with self._lock:
            seconds, micros = divmod(round(self.clock() * 1e6), 1_000_000)
            self._do(lambda: self._write(struct.pack("<IIII", seconds, micros, len(frame), len(frame)) + frame))

    def close(self) -> None:
        """Ends the file."""
        with self._lock:
            self._do(self._file.close)
            self._ended = True

    def _write(self, content: bytes) -> None:
        try:
            while content:
                content = content[self._file.write(content) :]
        except OSError:
            self._file.close()
            raise

    def _do(self, write: Callable[[], object]) -> None:
        if self._ended:
            return
        try:
            write()
        except OSError as error:
            self._ended = True
            if self._raises:
                raise
            log_event("capture given up", logging.WARNING, file=str(self._path), reason=str(error.strerror))


def capture_of(options: argparse.Namespace) -> Capture | None:
    """Returns the capture that ports share, open; None without --pcap. Raises OSError."""
    if options.pcap is None:
        return None
    if not hasattr(options, "capture"):
        prepare([options.pcap], options.overwrite)
        options.capture = Capture(options.pcap)
    capture: Capture = options.capture
    return capture


class CapturePort(Port):
    """Ends the capture with the service."""

    name = "udp"

    def __init__(self, capture: Capture) -> None:
        self._capture = capture

    def close(self) -> None:
        """Ends the capture."""
        self._capture.close()


class CaptureSender:
    """A sender whose datagrams go into a capture alone, each piece by itself. lost: none."""

    lost = 0

    def __init__(self, capture: Capture, source: Socket, destination: Socket) -> None:
        self._capture, self._source, self._to = capture, source, destination

    def send(self, pieces: Sequence[bytes]) -> None:
        """Writes datagrams."""
        for piece in pieces:
            self._capture.take(self._source, self._to, piece)

    def close(self) -> None:
        """Leaves the capture open."""


def _frame(source: Socket, destination: Socket, datagram: bytes) -> bytes:
    """A datagram with the headers of Ethernet, IP and UDP."""
    hosts, size = (ip_address(source[0].partition("%")[0]), ip_address(destination[0].partition("%")[0])), 8 + len(datagram)
    pair = hosts[0].packed + hosts[1].packed
    header = struct.pack(">HHH", source[1], destination[1], size)
    if hosts[1].version == 4:
        ip = struct.pack(">BBHHHBBH", 0x45, 0, 20 + size, 0, 0x4000, 1, UDP, 0) + pair
        ip = ip[:10] + _checksum(ip).to_bytes(2, "big") + ip[12:]
        return _ethernet(hosts[1], 0x0800) + ip + header + b"\0\0" + datagram  # no checksum
    pseudo = pair + struct.pack(">II", size, UDP) + header + b"\0\0" + datagram
    ip = struct.pack(">IHBB", 6 << 28, size, UDP, 1) + pair
    return _ethernet(hosts[1], 0x86DD) + ip + header + (_checksum(pseudo) or 0xFFFF).to_bytes(2, "big") + datagram


def _ethernet(to: IPv4Address | IPv6Address, kind: int) -> bytes:
    """The header of a frame, with the address that a group has there."""
    there = THERE
    if to.is_multicast:
        there = b"\x33\x33" + to.packed[-4:] if to.version == 6 else (0x01005E << 24 | int(to) & 0x7FFFFF).to_bytes(6, "big")
    return there + HERE + kind.to_bytes(2, "big")


def _checksum(content: bytes) -> int:
    """The checksum of IP: the complement of the sum of all words, carries added."""
    total: int = sum(struct.unpack(f">{(len(content) + 1) // 2}H", content + b"\0" * (len(content) % 2)))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF
