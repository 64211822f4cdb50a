"""Signal K: the Radar API 3.4.0, its stream, and pages of others that read it."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from radar_service.terminal.arguments import UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of Signal K."""
    where = groups["where"]
    where.add_argument("--signalk", action="store_true", help="serve the Signal K Radar API under /signalk")
    where.add_argument(
        "--gui", type=Path, metavar="DIR", help="with --signalk: serve the web page of another program under /gui/"
    )


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port; None without --signalk. Raises UsageError."""
    if options.gui is not None and not options.signalk:
        raise UsageError("--gui: a page of others reads Signal K; give --signalk as well")
    if options.gui is not None and not options.gui.is_dir():
        raise UsageError(f"--gui: {options.gui} is not a folder; give the one that has the page")
    if not options.signalk:
        return None
    from radar_service.ports.signalk.signalk_port import SignalKPort

    return SignalKPort(options.gui)
