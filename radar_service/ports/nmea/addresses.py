"""Where sentences go: addresses of the command line, and who may be there.

NMEA has no login. So beyond this machine a socket opens only where `--nmea-allow` names the other side, or with `--insecure`.
"""

import argparse
import re
from ipaddress import ip_address
from typing import NamedTuple

from radar_service.service.access import is_loopback
from radar_service.terminal.arguments import UsageError

HERE = "127.0.0.1"


class Address(NamedTuple):
    """host: a numeric address or a name; interface: of multicast, "" for the system's choice."""

    host: str
    port: int
    interface: str = ""

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}" + (f"%{self.interface}" if self.interface else "")


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


def check_reach(option: str, where: Address, allowed: list[str], insecure: bool, *, listens: bool) -> None:
    """Raises UsageError for an address beyond this machine that no option allows. listens: others come to it."""
    if is_loopback(where.host) or insecure or (listens and allowed) or where.host in allowed:
        return
    remedy = "--nmea-allow ADDRESS of those who may connect" if listens else f"--nmea-allow {where.host}"
    raise UsageError(f"{option}: {where.host} is beyond this machine, and NMEA has no login; give {remedy}, or --insecure")
