"""UDP for ports: addresses, who may be there, datagrams out, and a capture of these."""

import argparse
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from radar_service.terminal import UsageError, file_ending

if TYPE_CHECKING:
    from radar_service.ports.port import Port

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the option of captures."""
    groups["records"].add_argument(
        "--pcap", type=partial(file_ending, suffix=".pcap"), metavar="FILE.pcap",
        help="write what ports send by UDP as a capture",
    )  # fmt: skip


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns what ends the capture of other ports; None without --pcap. Raises UsageError where none has one."""
    if options.pcap is None:
        return None
    if not hasattr(options, "capture"):
        raise UsageError("--pcap: no port sends by UDP; give one that does, as --asterix, --garmin-xhd or --nmea-udp")
    from radar_service.ports.udp.capture import CapturePort

    return CapturePort(options.capture)
