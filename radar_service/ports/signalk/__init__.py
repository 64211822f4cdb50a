"""Signal K: the Radar API 3.4.0, its stream, and pages of others that read it."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from radar_service.terminal import UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port


replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of Signal K."""
    where, may = groups["where"], groups["who may"]
    where.add_argument("--signalk", action="store_true", help="serve the Signal K Radar API under /signalk")
    where.add_argument(
        "--gui", type=Path, metavar="DIR", help="with --signalk: serve the web page of another program under /gui/"
    )
    where.add_argument(
        "--announce", action="store_true", help="with --signalk: tell others on the network of --host by mDNS where it is"
    )
    may.add_argument(
        "--signalk-truth", action="store_true", help="tell bodies in sight as targets named TRUTH, with --truth alone"
    )


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port; None without --signalk. Raises UsageError and MissingExtra."""
    for name, given in (("gui", options.gui), ("announce", options.announce), ("signalk-truth", options.signalk_truth)):
        if given and not options.signalk:
            raise UsageError(f"--{name}: is about Signal K; give --signalk as well")
    if options.gui is not None and not options.gui.is_dir():
        raise UsageError(f"--gui: {options.gui} is not a folder; give the one that has the page")
    if options.signalk_truth and not options.truth:
        raise UsageError("--signalk-truth: tells the truth to all that read; give --truth too where they may know it")
    if not options.signalk:
        return None
    from radar_service.ports.signalk.signalk_port import SignalKPort

    announcement = None
    if options.announce:
        from radar_service.ports.signalk.announcement import Announcement

        announcement = Announcement(options.host, options.port)
    return SignalKPort(options.gui, options.signalk_truth, announcement)
