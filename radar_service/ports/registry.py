"""The ports that `serve` may have. A new one is a folder beside this file and a line here."""

import argparse
import contextlib
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

if TYPE_CHECKING:
    from radar_service.ports.port import Port

PORTS = (
    "radar_service.ports.rest",
    "radar_service.ports.feed",
    "radar_service.ports.recorder",
    "radar_service.ports.nmea",
    "radar_service.ports.nmea_in",
    "radar_service.ports.ais",
    "radar_service.ports.signalk",
)
REPLAY_PORTS = ("radar_service.ports.rest", "radar_service.ports.feed")


class PortPackage(Protocol):
    """What the package of a port has. All commands import it: what takes long is imported by `opened`."""

    def add_arguments(self, groups: "Mapping[str, argparse._ActionsContainer]") -> None:
        """Adds options of `serve` to the groups of its help, by their titles."""

    def opened(self, options: argparse.Namespace) -> "Port | None":
        """Returns the port that the options of `serve` ask for, with its files and sockets open; None where they ask for none.

        Raises UsageError with the name of an option, and OSError.
        """


def packages(names: Sequence[str] | None = None) -> list[PortPackage]:
    """Returns the packages of ports, by default of all."""
    return [cast(PortPackage, import_module(name)) for name in names or PORTS]


@contextlib.contextmanager
def opened(options: argparse.Namespace, names: Sequence[str] | None = None) -> Iterator["list[Port]"]:
    """The ports that options ask for; they are closed at the end. Raises UsageError and OSError."""
    with contextlib.ExitStack() as on_end:
        ports: list[Port] = []
        for package in packages(names):
            port = package.opened(options)
            if port is not None:
                on_end.callback(port.close)
                ports.append(port)
        yield ports
