"""Radars of other makers, as their readers know them: what all such ports share."""

import argparse
import contextlib
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radar_service.ports.dialect.dialect import Dialect
    from radar_service.ports.port import Port

WARNING = "Never on a ship's live network: displays there take this simulated radar for a real one."


def add_options(groups: "Mapping[str, argparse._ActionsContainer]", name: str, title: str) -> None:
    """Adds the options of a dialect. title: with its article."""
    where = groups["where"]
    where.add_argument(
        f"--{name}", metavar="INTERFACE",
        help=f"be {title} on this network interface: lo, a veth or a bridge of such; another one with --insecure (Linux)",
    )  # fmt: skip
    where.add_argument(f"--{name}-of", metavar="RADAR", help="the radar that it is (default the first)")


def opened_port(dialect: "Dialect", options: argparse.Namespace) -> "Port":
    """Returns the port of a dialect that is asked for, with its sockets open. Raises UsageError."""
    from radar_service.ports.dialect.announcements import senders_of
    from radar_service.ports.dialect.dialect_port import DialectPort, Listener
    from radar_service.ports.dialect.interfaces import checked_address
    from radar_service.ports.udp.capture import capture_of

    option, name = f"--{dialect.name}", dialect.name.replace("-", "_")
    interface = getattr(options, name)
    here = checked_address(option, interface, options.insecure)
    print(f"{option} {interface} ({here}): {WARNING}", file=sys.stderr)
    with contextlib.ExitStack() as on_failure:
        listeners = [Listener(option, here, *where) for where in dialect.commands]
        for each in listeners:
            on_failure.callback(each.close)
        senders = senders_of(dialect, here, capture_of(options))
        port = DialectPort(dialect, here, senders, listeners, getattr(options, f"{name}_of"))
        on_failure.pop_all()
    return port
