"""The ports that `serve` and `replay` may have: the entry points `radar_service.ports`, each a package like `PortPackage`."""

import argparse
import contextlib
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Protocol

from radar_service import plug_ins
from radar_service.terminal import MissingExtra, UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port


class PortPackage(Protocol):
    """What the package of a port has. `serve` imports it: what takes long is imported by `opened`.

    One that has `replays = True` takes part in `replay`, too. One that has `exported(number, capture, options)`, which returns a
    sink that writes a recorded radar into a capture, has an option of `export`; `add_export_arguments(parser)` may add more.
    """

    def add_arguments(self, groups: "Mapping[str, argparse._ActionsContainer]") -> None:
        """Adds options to the groups of the help, by their titles."""

    def opened(self, options: argparse.Namespace) -> "Port | None":
        """Returns the port that the options ask for, with its files and sockets open; None where they ask for none.

        Raises UsageError with the name of an option, and OSError.
        """


def add_ports(
    parser: argparse.ArgumentParser, groups: "Mapping[str, argparse._ActionsContainer]", replays: bool = False
) -> None:
    """Adds the options of ports, and the ports to those of the command; standard error tells of each that is broken.

    replays: only of those that can replay a recording.
    """
    ports: dict[str, PortPackage] = {}
    for name, package in plug_ins.working("ports").items():
        if replays and not getattr(package, "replays", False):
            continue
        try:
            with plug_ins.guarded(plug_ins.entry("ports", name)):
                package.add_arguments(groups)
                ports[name] = package
        except plug_ins.PlugInError as error:
            print(error, file=sys.stderr)
    parser.set_defaults(ports=ports)


@contextlib.contextmanager
def opened(options: argparse.Namespace) -> Iterator["list[Port]"]:
    """The ports that options ask for; they are closed at the end. Raises UsageError, MissingExtra and OSError."""
    with contextlib.ExitStack() as on_end:
        ports: list[Port] = []
        for name, package in options.ports.items():
            with plug_ins.guarded(plug_ins.entry("ports", name), UsageError, MissingExtra, OSError):
                port = package.opened(options)
            if port is not None:
                on_end.callback(port.close)
                ports.append(port)
        yield ports
