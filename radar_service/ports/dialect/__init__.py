"""Radars of other makers, as their readers know them: what all such ports share."""

import argparse
import contextlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radar_service.ports.dialect.dialect import Dialect
    from radar_service.ports.port import Port
    from radar_service.ports.udp.capture import Capture
    from radar_service.service.spokes import SpokeSink

WARNING = "Never on a ship's live network: displays there take this simulated radar for a real one."


@dataclass(frozen=True)
class DialectPackage:
    """What a dialect has for `serve`, `replay` and `export`, as `PortPackage`.

    name: of the port; title: with its article; dialect: where it is, as "module:name".
    """

    name: str
    title: str
    dialect: str
    replays = True

    def add_arguments(self, groups: "Mapping[str, argparse._ActionsContainer]") -> None:
        """Adds the options."""
        where = groups["where"]
        where.add_argument(
            f"--{self.name}", metavar="INTERFACE",
            help=f"be {self.title} on this network interface: lo, a veth or a bridge of such; others with --insecure (Linux)",
        )  # fmt: skip
        where.add_argument(f"--{self.name}-of", metavar="RADAR", help="the radar that it is (default the first)")

    def opened(self, options: argparse.Namespace) -> "Port | None":
        """Returns the port, open; None without its option. Raises UsageError."""
        option, key = f"--{self.name}", self.name.replace("-", "_")
        if (interface := getattr(options, key)) is None:
            return None
        from radar_service.ports.dialect.announcements import senders_of
        from radar_service.ports.dialect.dialect_port import DialectPort
        from radar_service.ports.dialect.interfaces import checked_address
        from radar_service.ports.udp.addresses import Address, UdpListener
        from radar_service.ports.udp.capture import capture_of

        dialect: Dialect = resolve_name(self.dialect)
        here = checked_address(option, interface, options.insecure)
        print(f"{option} {interface} ({here}): {WARNING}", file=sys.stderr)
        with contextlib.ExitStack() as on_failure:
            places = [Address(host, port, here) if host else Address(here, port) for host, port in dialect.commands]
            listeners = [on_failure.enter_context(contextlib.closing(UdpListener(option, each))) for each in places]
            senders = senders_of(dialect, here, capture_of(options))
            port = DialectPort(dialect, here, senders, listeners, getattr(options, f"{key}_of"))
            on_failure.pop_all()
        return port

    def exported(self, number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
        """Returns a sink that writes a recorded radar into a capture."""
        from radar_service.ports.dialect.announcements import DialectExport

        return DialectExport(resolve_name(self.dialect), capture)
