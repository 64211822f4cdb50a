"""Addresses of the command line, and who may be there.

These protocols have no login. So beyond this machine a socket opens only where an option, as `--nmea-allow`, names the other
side, or with `--insecure`.
"""

import argparse
import contextlib
import errno
import re
import socket
import sys
import time
from collections.abc import Callable, Iterator
from ipaddress import ip_address
from typing import NamedTuple

from radar_service.service.access import is_loopback
from radar_service.terminal import UsageError

HERE = "127.0.0.1"
MAX_DATAGRAMS = 64  # at once
IP_MULTICAST_ALL = 49  # of Linux
REJOIN = 5.0  # s: an interface that was away and came back is in no group
LINK_LOCAL = re.compile("fe[89ab]|ff.[12]:", re.IGNORECASE)  # of IPv6, RFC 4291


class Address(NamedTuple):
    """host: a numeric address or a name; interface: of multicast, "" for the system's choice."""

    host: str
    port: int
    interface: str = ""

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}" + (f"%{self.interface}" if self.interface else "")

    @property
    def family(self) -> socket.AddressFamily:
        """The family of IPv6 for an address with colons, otherwise of IPv4."""
        return socket.AF_INET6 if ":" in self.host else socket.AF_INET

    @property
    def for_sockets(self) -> tuple[str, int] | tuple[str, int, int, int]:
        """The tuple that `bind` and `connect` take. Raises OSError for an interface that is absent."""
        if self.family == socket.AF_INET6:
            if not self.interface and LINK_LOCAL.match(self.host):
                raise OSError(errno.EINVAL, f"a link-local address needs an interface, as [{self.host}]:{self.port}%eth0")
            return self.host, self.port, 0, self.interface_index
        return self.host, self.port

    @property
    def is_group(self) -> bool:
        """Whether it is one of multicast."""
        try:
            return ip_address(self.host).is_multicast
        except ValueError:  # a name
            return False

    @property
    def interface_index(self) -> int:
        """The number of the interface of IPv6, 0 for the system's choice. Raises OSError where none has that name."""
        try:
            return socket.if_nametoindex(self.interface) if self.interface else 0
        except OSError:
            raise OSError(errno.ENODEV, f"no interface has the name {self.interface}, as IPv6 needs it") from None

    @property
    def interface_address(self) -> bytes:
        """The address of the interface of IPv4, 0.0.0.0 for the system's choice. Raises OSError for what is no address."""
        try:
            return socket.inet_aton(self.interface or "0.0.0.0")
        except OSError:
            raise OSError(errno.ENODEV, f"{self.interface} is not the address of an interface, as IPv4 needs it") from None


def address(text: str) -> Address:
    """Returns the address of [HOST:]PORT[%INTERFACE]. Raises ArgumentTypeError."""
    form = re.fullmatch(
        r"(?:\[(?P<six>[0-9A-Fa-f:.]+)\]:|(?P<host>[^:%\[\]\s]+):)?(?P<port>\d{1,5})(?:%(?P<interface>\S+))?", text
    )
    if form is None or not 0 < int(form["port"]) < 65536:
        raise argparse.ArgumentTypeError(
            f'"{text}" is not [HOST:]PORT with a port from 1 to 65535, as 10110 or 192.168.0.7:10110'
        )
    return Address(form["six"] or form["host"] or HERE, int(form["port"]), form["interface"] or "")


def numeric(text: str) -> str:
    """Returns the address of another machine. Raises ArgumentTypeError."""
    try:
        return str(ip_address(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is not an address; give numbers, as 192.168.0.7') from None


def check_reach(
    option: str, where: Address, allowed: list[str], insecure: bool, *, listens: bool, allow: str = "--nmea-allow"
) -> None:
    """Raises UsageError for an address beyond this machine that no option allows. listens: others come to it; allow: the option
    that names those who are allowed."""
    try:
        host = numeric(where.host)
    except argparse.ArgumentTypeError:
        host = ""
    if is_loopback(where.host) or insecure or (listens and allowed) or host in allowed:
        return
    remedy = f"{allow} {host}" if host else f"an address in numbers, here and to {allow}"
    if listens:
        remedy = f"{allow} ADDRESS of those who may connect"
    raise UsageError(
        f"{option}: {where.host} is beyond this machine, and nothing asks for a login; give {remedy}, or --insecure"
    )


def bound(option: str, where: Address, kind: socket.SocketKind, prepare: Callable[[socket.socket], None]) -> socket.socket:
    """Returns a socket of this machine that does not wait.

    option: with which messages begin; prepare: is called once the socket is bound.
    Raises UsageError where the port is taken, or the address is not this machine's.
    """
    result = socket.socket(where.family, kind)
    try:
        if kind == socket.SOCK_STREAM or where.is_group:
            result.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        result.bind(where.for_sockets)
        prepare(result)
    except OSError as error:
        result.close()
        raise UsageError(f"{option}: {where} cannot be opened ({error.strerror}); give another port or address") from None
    result.setblocking(False)
    return result


class UdpListener:
    """A socket that takes datagrams without waiting, also of a group."""

    def __init__(self, option: str, where: Address, clock: Callable[[], float] = time.monotonic) -> None:
        """option: with which messages begin. Raises UsageError."""
        self.sockets = (bound(option, where, socket.SOCK_DGRAM, lambda socket: join(socket, where)),)
        self.close = self.sockets[0].close
        self._where, self._clock, self._joined = where, clock, clock()

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        host, port, *_ = self.sockets[0].getsockname()
        return host, port

    def datagrams(self, most: int) -> Iterator[tuple[bytes, str, int]]:
        """Yields those that have come, some at most, with the address and port of each. most: bytes, the rest is cut off."""
        if self._clock() - self._joined >= REJOIN:
            self._joined = self._clock()
            with contextlib.suppress(OSError):  # as a rule it is in the group
                join(self.sockets[0], self._where)
        with contextlib.suppress(OSError):  # none is left; or the interface is away
            for _ in range(MAX_DATAGRAMS):
                data, (host, port, *_) = self.sockets[0].recvfrom(most)
                yield data, host, port


def join(receiving: socket.socket, where: Address) -> None:
    """Joins the group, where the address is one. Raises OSError where it is in it already, or the interface is away."""
    if where.is_group:
        group = ip_address(where.host).packed
        if where.family == socket.AF_INET:
            if where.interface and sys.platform == "linux":  # not what comes by interfaces that other programs have joined
                receiving.setsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL, 0)
            receiving.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group + where.interface_address)
        else:
            request = group + where.interface_index.to_bytes(4, sys.byteorder)
            receiving.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, request)
