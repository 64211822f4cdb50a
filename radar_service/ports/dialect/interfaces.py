"""Network interfaces of Linux: their IPv4 address, and whether they stay in this machine."""

import array
import fcntl
import os
import socket
import struct
from pathlib import Path

from radar_service.terminal import UsageError

SIOCGIFFLAGS, SIOCGIFADDR, SIOCETHTOOL = 0x8913, 0x8915, 0x8946
IFF_LOOPBACK = 8
ETHTOOL_GDRVINFO = 3
DRIVER_INFO = 196  # bytes; the name of the driver stands in 32 from the fifth on
INSIDE = ("veth", "bridge", "tun")  # drivers of interfaces between parts of one machine; tun, too, as part of a bridge


def checked_address(option: str, interface: str, insecure: bool) -> str:
    """Returns the IPv4 address of an interface. insecure: also where it leads to other machines.

    Raises UsageError that begins with the option.
    """
    try:
        address = socket.inet_ntoa(_asked(interface, SIOCGIFADDR)[20:24])
    except OSError:
        names = ", ".join(name for _, name in socket.if_nameindex())
        raise UsageError(f"{option}: {interface} is no interface with an IPv4 address; this machine has {names}") from None
    if not insecure and not stays_here(interface):
        raise UsageError(
            f"{option}: {interface} may lead to a ship's live network, where displays take this radar for a real one; give lo, "
            "a veth or a bridge of such, or --insecure where no such network is"
        )
    return address


def stays_here(interface: str) -> bool:
    """Whether an interface is loopback, a veth, or a bridge whose parts are such or of virtual machines. Raises OSError."""
    if struct.unpack_from("<H", _asked(interface, SIOCGIFFLAGS), 16)[0] & IFF_LOOPBACK:
        return True
    driver = _driver(interface)
    if driver == "bridge":
        parts = Path("/sys/class/net", interface.partition(":")[0], "brif").glob("*")  # br0:1 is a second address of br0
        return all(_driver(part.name) in INSIDE for part in parts)
    return driver == "veth"


def _driver(interface: str) -> str:
    """The name of the driver of an interface, empty where it tells none."""
    info = array.array("B", struct.pack("<I", ETHTOOL_GDRVINFO).ljust(DRIVER_INFO, b"\0"))
    try:
        _asked(interface, SIOCETHTOOL, struct.pack("P", info.buffer_info()[0]))
    except OSError:
        return ""
    return info.tobytes()[4:36].split(b"\0")[0].decode(errors="replace")


def _asked(interface: str, request: int, content: bytes = b"") -> bytes:
    """What the system answers to a request about an interface: a `struct ifreq`. Raises OSError."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        return fcntl.ioctl(any_socket, request, struct.pack("16s24s", os.fsencode(interface)[:15], content))
